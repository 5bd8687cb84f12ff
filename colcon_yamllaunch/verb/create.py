# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The verb `colcon create`, as colcon loads it."""

from colcon_yamllaunch.verb.options_verb import OptionsVerb


class CreateVerb(OptionsVerb):
    """Create a package with a node, a launch file and tests."""

    NAME = 'create'
    USAGE = """\
colcon create [options] PKG [options]
       colcon create --example [DIR]"""
    EPILOG = """\
examples:
  colcon create my_pkg
  colcon create my_pkg --node counter --dependencies rclpy std_msgs
  colcon create my_pkg --build-type cmake --license MIT
  colcon create --example"""
    NARGS = '*'
    WORDS = 'PKG'
    WORDS_HELP = 'The name of the package, which is that of its folder, too'
