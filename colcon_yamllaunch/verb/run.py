# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The verb `colcon run`, as colcon loads it."""

from colcon_yamllaunch.verb.options_verb import OptionsVerb


class RunVerb(OptionsVerb):
    """Build what a program of a package needs, source and become it."""

    NAME = 'run'
    USAGE = 'colcon run [options] PKG EXEC [argument ...]'
    EPILOG = """\
examples:
  colcon run my_pkg counter.py
  colcon run my_pkg counter.py --ros-args -p delta:=2
  colcon run --prefix "gdb -ex run --args" flow pump 5"""
    WORDS = 'PKG EXEC [argument ...]'
    WORDS_HELP = (
        'The package and its executable, then the arguments of the '
        'program, which are passed as they are. Without EXEC the '
        'executables of the package are listed'
    )
