# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The table of substitutions.

To add a substitution is to add an entry here, and what makes it to
`actions/substitution_makers.py`.
"""

import re

from colcon_yamllaunch.common.frozen import dataclass

# one argument as `Kind.arguments` names it, in quotes if it has spaces
_ARGUMENT = re.compile(r"'[^']*'|[^ …]+")


@dataclass(frozen=True, slots=True)
class Kind:
    """
    A kind of substitution.

    :param name: Its name
    :param arguments: How its arguments are written: optional ones in brackets,
      `…` behind one that may stand several times
    :param help: What it comes to, in one sentence
    :param example: How it may be used
    :param since: The first ROS 2 release that has it, as in `actions.py`
    """

    name: str
    arguments: str
    help: str
    example: str
    since: str = 'Humble'

    @property
    def usage(self) -> str:
        """How it is written."""
        return f'$({" ".join((self.name, self.arguments)).rstrip()})'

    @property
    def minimum(self) -> int:
        """How many arguments it needs."""
        needed = self.arguments.partition('[')[0]
        return len(_ARGUMENT.findall(needed))

    @property
    def maximum(self) -> int | None:
        """How many arguments it takes, None without limit."""
        is_limited = '…' not in self.arguments
        return len(_ARGUMENT.findall(self.arguments)) if is_limited else None

    def arity_problem(self, count: int) -> str | None:
        """Return the error in a number of arguments, if any."""
        minimum, maximum = self.minimum, self.maximum
        if minimum <= count and (maximum is None or count <= maximum):
            return None
        wanted = str(minimum)
        if maximum is None:
            wanted = f'at least {minimum}'
        elif maximum != minimum:
            wanted = f'{minimum} to {maximum}'
        plural = '' if wanted == '1' else 's'
        return f"'{self.name}' takes {wanted} argument{plural}, not {count}"


_KINDS = (
    Kind(
        'var',
        'name [default]',
        'The value of a launch argument or other launch configuration.',
        '$(var rate 10)',
    ),
    Kind(
        'env',
        'NAME [default]',
        'The value of an environment variable.',
        "$(env ROBOT_NAME '')",
    ),
    Kind(
        'eval',
        "'expression' [modules]",
        'The result of a Python expression, which can use the names of the '
        '`math` module, or those of other modules, separated by commas (the '
        'modules since Iron).',
        "$(eval '2 * $(var rate 10)')",
    ),
    Kind(
        'command',
        "'command line' [stderr]",
        'The output of a command, which runs while the launch file is read; '
        'the command must succeed, and output on stderr is an error '
        '(`fail`), dropped (`ignore`), a warning (`warn`) or part of the '
        'output (`capture`).',
        "$(command 'uname -m' ignore)",
    ),
    Kind(
        'find-exec',
        'name',
        'The path of a program on the PATH.',
        '$(find-exec sh)',
    ),
    Kind(
        'find-pkg-prefix',
        'package',
        'The folder in which a package is installed.',
        '$(find-pkg-prefix my_pkg)',
    ),
    Kind(
        'find-pkg-share',
        'package',
        'The share folder of a package.',
        '$(find-pkg-share my_pkg)/config/rates.yaml',
    ),
    Kind(
        'exec-in-pkg',
        'executable package',
        'The path of a program in a package.',
        '$(exec-in-pkg my_node my_pkg)',
    ),
    Kind(
        'anon',
        'id',
        'A name that no other launch has; within a scope, the same id gives '
        'the same name.',
        '$(anon viewer)',
    ),
    Kind(
        'dirname',
        '',
        'The folder of the launch file in which it is written.',
        '$(dirname)/driver.yaml',
    ),
    Kind(
        'filename',
        '',
        'The path of the launch file in which it is written.',
        '$(filename)',
    ),
    Kind(
        'log_dir',
        '',
        'The folder for the logs of this launch.',
        '$(log_dir)/rosbag',
    ),
    Kind(
        'launch_log_dir',
        '',
        'The same as `log_dir`.',
        '$(launch_log_dir)/rosbag',
        'Iron',
    ),
    Kind(
        'file-content',
        'path',
        'The text of a file, including its last line end.',
        '$(file-content $(dirname)/arm.urdf)',
        'Iron',
    ),
    Kind(
        'not',
        'condition',
        '`true` if the condition is false, else `false`.',
        '$(not $(var sim true))',
    ),
    Kind(
        'and',
        'condition condition',
        '`true` if both are true, else `false`.',
        '$(and $(var sim true) $(var gui true))',
    ),
    Kind(
        'or',
        'condition condition',
        '`true` if one or both are true, else `false`.',
        '$(or $(var sim true) $(var gui true))',
    ),
    Kind(
        'any',
        '[condition …]',
        '`true` if one or more are true, else `false`.',
        '$(any $(var a true) $(var b true) $(var c true))',
        'Iron',
    ),
    Kind(
        'all',
        '[condition …]',
        '`true` if all are true, else `false`.',
        '$(all $(var a true) $(var b true) $(var c true))',
        'Iron',
    ),
    Kind(
        'equals',
        'left right',
        '`true` if both are equal as booleans, as numbers or as texts, else '
        '`false`.',
        '$(equals $(var mode fast) fast)',
        'Iron',
    ),
    Kind(
        'not-equals',
        'left right',
        'The opposite of `equals`.',
        '$(not-equals $(var mode fast) slow)',
        'Iron',
    ),
    Kind(
        'if',
        'condition then [else]',
        'One of two texts; empty if the condition is false and there is no '
        'second text.',
        '$(if $(var sim true) gazebo driver)',
        'Iron',
    ),
    Kind(
        'param',
        'name [default]',
        'The value of a parameter that `set_parameter` has set before (the '
        'default since Iron).',
        '$(param use_sim_time false)',
    ),
    Kind(
        'for-var',
        'name [default]',
        'The value of a variable of the `for_each` around it.',
        '$(for-var robot r2d2)',
        'Kilted',
    ),
    Kind(
        'index',
        'name',
        'The index of the `for` around it.',
        '$(index i)',
        'Kilted',
    ),
    Kind(
        'string-join',
        'delimiter text …',
        'The texts, with the delimiter between them.',
        '$(string-join _ left $(var camera front) raw)',
        'Lyrical',
    ),
    Kind(
        'path-join',
        'path …',
        'The parts of a path, joined.',
        '$(path-join $(dirname) config rates.yaml)',
        'Lyrical',
    ),
    Kind(
        'string-strip',
        'text',
        'The text without the white space at its ends.',
        '$(string-strip $(file-content $(dirname)/version))',
        'Rolling',
    ),
)

#: All kinds of substitutions by name.
KINDS = {kind.name: kind for kind in _KINDS}
