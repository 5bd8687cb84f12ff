# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The verb `colcon launch`, as colcon loads it."""

from colcon_yamllaunch.verb.options_verb import OptionsVerb


class LaunchVerb(OptionsVerb):
    """Build what a launch file needs, source the workspace and run it."""

    NAME = 'launch'
    USAGE = """\
colcon launch [options] PKG FILE [name:=value ...]
       colcon launch [options] path/to/file.yaml [name:=value ...]"""
    EPILOG = """\
examples:
  colcon launch my_pkg demo.yaml
  colcon launch my_pkg demo.yaml rate:=5
  colcon launch src/my_pkg/launch/demo.yaml
  colcon launch my_pkg demo.yaml --until "Received .*" --timeout 60
  colcon launch --demo"""
    WORDS = 'PKG FILE [name:=value ...]'
    WORDS_HELP = (
        'The package and its launch file: by name, with or without '
        'extension, or by its path in the package; or instead of both '
        'the path of a launch file. Then the launch arguments'
    )
