# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A process as it is told on the screen."""

from colcon_yamllaunch.engine.description import (
    Description,
    EnclosingBlock,
    Parameter,
)
from colcon_yamllaunch.terminal.status_model import description_lines

WITHIN = (
    EnclosingBlock('file', '/ws/house.yaml', '/ws/house.yaml:1:1'),
    EnclosingBlock('group', '/house', '/ws/house.yaml:5:3'),
)
PARAMETERS = (
    Parameter('rate', '5', '/ws/house.yaml:9:7'),
    Parameter('id', 'a', '/ws/house.yaml:10:7', ('/ws/x.yaml:2:3',)),
)


def test_process_lines_have_environment_and_parameters():
    names = 'kitchen', 'thermometer.py-2', '/house/kitchen', 'house'
    description = Description(
        *(*names, '/ws/house.yaml:7:3', WITHIN, PARAMETERS, '/kitchen.log'),
        argv=('/bin/thermometer.py', 'two words'),
        cwd='/ws',
        environment=(('A', 'x y'), ('B', None)),
    )
    assert (
        '\n'.join(description_lines(description))
        == """\
kitchen:
  node: /house/kitchen
  package: house
  in ROS 2: thermometer.py-2
  from: /ws/house.yaml:7:3
  file: /ws/house.yaml:1:1
  group: /house (/ws/house.yaml:5:3)
  command: /bin/thermometer.py 'two words'
  folder: /ws
  log: /kitchen.log
  environment:
    A='x y'
    B unset
  parameters:
    rate: 5  (/ws/house.yaml:9:7)
    id: a  (/ws/house.yaml:10:7, from /ws/x.yaml:2:3)"""
    )


def test_component_lines_have_plugin_and_container():
    names = 'filter', 'filter', '/filter', 'vision'
    description = Description(
        *(*names, '/ws/a.yaml:1:1', (), (), None),
        plugin='vision::Filter',
        container='/box',
        remaps=('in:=out',),
    )
    assert (
        '\n'.join(description_lines(description))
        == """\
filter:
  node: /filter
  package: vision
  from: /ws/a.yaml:1:1
  plugin: vision::Filter
  container: /box
  remapping:
    in:=out"""
    )
