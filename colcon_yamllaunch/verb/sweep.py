# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The verb `colcon sweep`, as colcon loads it."""

from colcon_yamllaunch.verb.options_verb import OptionsVerb


class SweepVerb(OptionsVerb):
    """Launch the same many times with other arguments, and compare."""

    NAME = 'sweep'
    USAGE = """\
colcon sweep [options] PKG FILE [name:=values ...]
       colcon sweep [options] path/to/file.yaml [name:=values ...]"""
    EPILOG = """\
examples:
  colcon sweep my_pkg sim.yaml seed:=1..1000 world:=lab,street
  colcon sweep my_pkg sim.yaml gain:=0.5..2.0..0.1 --repeat 5 --jobs 8
  colcon sweep my_pkg sim.yaml --table runs.csv --require 95%
  colcon sweep my_pkg sim.yaml seed:=1..1000 --on slurm:partition=cpu,time=10
  colcon sweep my_pkg sim.yaml seed:=1..1000 --again failed"""
    WORDS = 'PKG FILE [name:=values ...]'
    WORDS_HELP = (
        'The package and its launch file, or the path of one, as '
        'colcon launch takes them. Then the launch arguments with their '
        'values: a list such as lab,street, or a range such as 1..1000 '
        'or 0..1..0.1, which is first..last..step'
    )
