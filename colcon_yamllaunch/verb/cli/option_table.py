# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The options of the verbs, each described once.

The parsers with their help, the errors for options that do not fit together,
completion and docs/options.md are made from this table.
"""

from collections.abc import Mapping
from dataclasses import field
from functools import cache
from keyword import iskeyword
from typing import Literal

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.engine.limits import LOG_LIMIT

#: The verbs that have options.
Verb = Literal['launch', 'run', 'create', 'sweep']
#: How many values an option takes: one; one each time that it is given; maybe
#: one of its choices, behind '='; any number; at least one.
Arity = Literal['one', 'each', 'choice', 'any', 'some']
#: What a value is read as, see `option_parser.py`.
Kind = Literal[
    'count',
    'file',
    'metric',
    'path',
    'pattern',
    'place',
    'seconds',
    'share',
    'size',
    'text',
    'words',
]
#: What Tab offers for a value, see `completion/completing.py`.
Completer = Literal[
    'choices',
    'files',
    'folders',
    'hosts',
    'launches',
    'licenses',
    'lifecycles',
    'nothing',
    'packages',
    'parts',
    'places',
    'terminals',
]

#: The format of what is shown to people.
TEXT = 'text'
#: How `--watch` tells that something failed: by its lines, or aloud, too.
WATCH_SILENTLY = 'silent'
WATCH_WITH_BELL = 'bell'
#: Which runs of a sweep are done again.
AGAIN_FAILED = 'failed'
AGAIN_ALL = 'all'
#: The value of `--log-limit` for no limit.
NO_LIMIT = 'none'
#: Bytes that the logs of each run of a sweep may take, as there are many.
RUN_LOG_LIMIT = 100_000_000

#: The options that show something of a launch instead of running it.
INSPECTIONS = ('--show-args', '--check', '--plan', '--schema')
#: The options that ask something of launches that run already.
REQUESTS = ('--status', '--stop', '--restart', '--lifecycle', '--logs')


@dataclass(frozen=True, slots=True)
class Value:
    """
    What an option takes.

    :param name: What `--help` calls it
    :param completer: What Tab offers for it
    :param kind: What it is read as
    :param arity: How many there may be
    :param choices: The values that it may have, the default first
    :param takes_dash: Whether it may begin with a dash
    :param has_default: Whether the first choice holds without the option
    """

    name: str | None
    completer: Completer
    kind: Kind = 'text'
    arity: Arity = 'one'
    choices: tuple[str, ...] = ()
    takes_dash: bool = False
    has_default: bool = True


@dataclass(frozen=True, slots=True)
class Option:
    """
    An option.

    :param name: How it is written; the table refers to it by this
    :param value: What it takes; None for nothing
    :param short: How it is written in short, if it may be
    :param excludes: Options that it must not be given with, and what to say,
      with `{one}` for this option and `{other}` for that one
    :param needs: Options, one of which must be given with it, if any must
    """

    name: str
    help: str
    value: Value | None = None
    short: str | None = None
    excludes: Mapping[str, str] = field(default_factory=dict)
    needs: tuple[str, ...] = ()

    @property
    def flags(self) -> list[str]:
        """All ways to write it."""
        return [flag for flag in (self.short, self.name) if flag is not None]

    @property
    def key(self) -> str:
        """What its value is called in Python."""
        key = self.name.removeprefix('--').replace('-', '_')
        return f'{key}_' if iskeyword(key) else key


@dataclass(frozen=True, slots=True)
class Section:
    """
    Options that belong together.

    :param title: What `--help` shows them below; sections may share one
    """

    title: str
    verbs: tuple[Verb, ...]
    options: tuple[Option, ...]


def _not(
    *options: str, error: str = '{one} and {other} exclude one another'
) -> Mapping[str, str]:
    return dict.fromkeys(options, error)


def _formats(*others: str) -> Value:
    choices = (TEXT, *others)
    return Value('FORMAT', 'choices', arity='choice', choices=choices)


_RUNS_NONE = _not(
    *INSPECTIONS,
    error='{one} is about a launch that runs, and {other} runs none',
)
_ONE_COMPUTER = _not(
    '--show-args',
    '--schema',
    error='{one} is about where processes run, and {other} runs none',
)
_MADE_ALREADY = _not(
    '--from-plan',
    error='{one} goes with a launch file: the command lines of a saved plan '
    'are made already',
)

_COMMON = (
    Option(
        '--version',
        'Show the versions of this plug-in and of colcon-core, and exit',
    ),
)
_INSPECTION = (
    Option(
        '--show-args',
        'Show the launch arguments',
        short='-s',
        excludes=_not('--check', '--plan', '--schema'),
    ),
    Option(
        '--check',
        'Check every branch of the launch file and of its includes, or all '
        'launch files of the workspace; written --check=json, '
        '--check=github or --check=sarif for programs',
        _formats('json', 'github', 'sarif'),
        excludes=_not('--plan', '--schema'),
    ),
    Option(
        '--portable',
        'With --check: find what `ros2 launch` would reject, too',
        needs=('--check',),
    ),
    Option(
        '--plan',
        'Show what would run; --plan=sh is a script that runs it, '
        '--plan=json can be saved and run, --plan=mermaid and '
        '--plan=dot are drawings',
        _formats('sh', 'json', 'mermaid', 'dot'),
        excludes=_not('--schema'),
    ),
    Option(
        '--run-commands',
        'With --plan: run $(command …), whatever $(eval …) says, and the '
        'setup scripts of the workspace, which a plan does without otherwise',
        needs=('--plan',),
    ),
    Option(
        '--from-plan',
        'Run a plan that was saved',
        Value('FILE', 'files', 'file'),
    ),
    Option('--schema', 'Print the JSON Schema of launch files, for editors'),
)
_RUN = (
    Option(
        '--prefix',
        'A command in one word that gets the program and its arguments as '
        'its last arguments, such as "gdb -ex run --args"',
        Value('"COMMAND ..."', 'nothing', 'words'),
    ),
)
_BUILD = (
    Option(
        '--workspace',
        'The root of the workspace (default: found from the current folder '
        'upwards)',
        Value('PATH', 'folders', 'path'),
    ),
    Option(
        '--paths',
        'Build the packages at just these paths, as `colcon build --paths` '
        'takes them',
        Value('PATH', 'folders', arity='some'),
    ),
    Option(
        '--no-build',
        'Build nothing',
        excludes=_not('--build-all', '--paths', '--force'),
    ),
    Option(
        '--build-all',
        'Build all packages of the workspace',
        excludes=_not('--paths'),
    ),
    Option(
        '--build-args',
        'Further arguments for `colcon build`, in one word',
        Value('"ARG ..."', 'nothing', 'words', takes_dash=True),
    ),
)
_LAUNCH_BUILD = (
    Option(
        '--why',
        'Say of each package that the launch needs why it is built or not, '
        'and what needs it; with --plan or --no-build: why it would be; with '
        '--watch: what follows from each change, and why',
        excludes=_not('--show-args', '--check', '--schema'),
    ),
    Option(
        '--force',
        'Build all packages that the launch needs, not just those that are '
        'not up to date',
    ),
)
_SHOWN = (
    Option(
        '--quiet',
        'Show only the output of the processes, warnings and failures',
        excludes={**_RUNS_NONE, **_not('--verbose')},
    ),
    Option(
        '--verbose',
        'Show also the command line of each process, the variables that it '
        'gets, its parameters, and where each of them comes from',
        excludes=_RUNS_NONE,
    ),
    Option(
        '--tty',
        'Let each process write to a terminal of its own, as if the launch '
        'file said `emulate_tty: true` for all of them',
    ),
    Option('--no-color', 'Use no colours'),
    Option(
        '--no-status',
        'Do not keep the state of the processes at the bottom of a terminal',
    ),
    Option(
        '--log-limit',
        'What the log files of the launch may take together, such as 500MB, '
        f'2GB or {NO_LIMIT} (default: {LOG_LIMIT // 10**9}GB)',
        Value('SIZE', 'nothing', 'size'),
    ),
)
_PREFIX = (
    Option(
        '--launch-prefix',
        'A command to start executables with, such as "gdb -ex run --args"; '
        'in one word',
        Value('COMMAND', 'nothing'),
        excludes=_MADE_ALREADY,
    ),
    Option(
        '--launch-prefix-filter',
        'Use the prefix for executables whose name matches from its start',
        Value('REGEX', 'nothing'),
        excludes=_MADE_ALREADY,
    ),
)
_WATCH = (
    Option(
        '--watch',
        'Go on with the files: when one is saved, build and evaluate what '
        'depends on it, and restart just what runs it; --watch=bell rings '
        'when something fails. With --until: check after each change',
        Value(
            'HOW',
            'choices',
            arity='choice',
            choices=(WATCH_SILENTLY, WATCH_WITH_BELL),
        ),
        excludes={
            **_RUNS_NONE,
            **_not(
                '--from-plan',
                error='{one} goes with a launch file: {other} runs a plan '
                'that was made already',
            ),
            **_not(
                '--for',
                error='{one} goes on until it is stopped, {other} for a time',
            ),
        },
    ),
)
_MACHINES = (
    Option(
        '--on',
        'Run all of it on another machine, as if it were here: USER@HOST or '
        'whatever ssh takes, slurm:partition=NAME for an allocation, or with '
        '--deploy the name of a machine',
        Value('HOST', 'hosts'),
        excludes=_ONE_COMPUTER,
    ),
    Option(
        '--deploy',
        'Run processes on the machines that a file names for them',
        Value('FILE', 'files', 'file'),
        excludes=_ONE_COMPUTER,
    ),
)
_GOAL = (
    Option(
        '--until',
        'End with success as soon as a line of a process matches; given '
        'several times, all must have matched',
        Value('REGEX', 'nothing', 'pattern', arity='each', takes_dash=True),
        excludes=_RUNS_NONE,
    ),
    Option(
        '--timeout',
        'End with failure when --until takes longer; without --until, when '
        'the launch does',
        Value('SECONDS', 'nothing', 'seconds'),
        excludes=_RUNS_NONE,
    ),
    Option(
        '--for',
        'Run for a time, and end with failure as soon as a process fails; '
        'with --until, the time starts when all has matched',
        Value('SECONDS', 'nothing', 'seconds'),
        excludes=_RUNS_NONE,
    ),
)
_REPORT = (
    Option(
        '--junit',
        'Write a JUnit report with a case for each process and --until',
        Value('FILE', 'files', 'file'),
        excludes=_RUNS_NONE,
    ),
)
_SESSIONS = (
    Option(
        '--status',
        'Show all running launches with their processes and components; '
        '--status=json for programs',
        _formats('json'),
        excludes=_not(
            *('--stop', '--restart', '--lifecycle', '--logs', '--attach')
        ),
    ),
    Option(
        '--stop',
        'Stop processes and unload components, by name or glob; without a '
        'name, the launch',
        Value('NAME', 'parts', arity='any'),
        excludes=_not('--restart', '--lifecycle', '--logs', '--attach'),
    ),
    Option(
        '--restart',
        'Start processes and load components anew, by name or glob',
        Value('NAME', 'parts', arity='any'),
        excludes=_not('--lifecycle', '--logs', '--attach'),
    ),
    Option(
        '--lifecycle',
        'Change the state of lifecycle nodes, by name or glob: configure, '
        'activate, deactivate, cleanup or shutdown',
        Value('NAME TRANSITION', 'lifecycles', arity='any'),
        excludes=_not('--logs', '--attach', '--ui'),
    ),
    Option(
        '--logs',
        'Show what processes wrote, by name or glob; for a component, what '
        'its container did',
        Value('NAME', 'parts', arity='any'),
        excludes=_not('--attach'),
    ),
    Option(
        '--follow',
        'With --logs: the last lines, then what comes',
        short='-f',
        needs=('--logs',),
    ),
    Option(
        '--attach',
        'Connect the keyboard to a process: with PKG FILE to one of the new '
        'launch, else to one of a running launch; Ctrl-] detaches',
        Value('NAME', 'terminals'),
    ),
    Option(
        '--ui',
        'Show a running launch on the full screen; with PKG FILE, the new one',
        excludes={
            **_RUNS_NONE,
            **_not('--status', '--stop', '--restart', '--logs', '--attach'),
        },
    ),
    Option(
        '--of',
        'Which running launch is meant, where that is not clear: its '
        "package, launch file or pid, or a glob ('*' for all)",
        Value('LAUNCH', 'launches'),
        needs=(*REQUESTS, '--attach', '--ui'),
    ),
)
_RUNS = (
    Option(
        '--table',
        'A CSV file with launch arguments as columns and a run in each '
        'further line; with arguments beside it, all combinations',
        Value('FILE', 'files', 'file'),
    ),
    Option(
        '--repeat',
        'Run each combination several times',
        Value('N', 'nothing', 'count'),
    ),
    Option(
        '--jobs',
        'How many runs go on at a time (default: the number of processors; '
        'with --on slurm as many as Slurm lets)',
        Value('N', 'nothing', 'count'),
    ),
    Option(
        '--on',
        'Where the runs are done: slurm:OPTION=VALUE,… has Slurm do them, '
        'as array jobs with these options of sbatch (default: this machine)',
        Value('WHERE', 'places', 'place'),
    ),
    Option(
        '--share-network',
        'Leave the runs in the network of the machine, for those that need '
        'it; each still has a ROS_DOMAIN_ID of its own',
    ),
    Option(
        '--again',
        'Do runs again that are done: those that failed, or all',
        Value(
            'WHICH',
            'choices',
            choices=(AGAIN_FAILED, AGAIN_ALL),
            has_default=False,
        ),
    ),
)
_RESULTS = (
    Option(
        '--metric',
        'Measure something of each run: the group of the expression in the '
        'last line of a process that matches; may be given several times',
        Value(
            'NAME=REGEX', 'nothing', 'metric', arity='each', takes_dash=True
        ),
    ),
    Option(
        '--require',
        'How many runs have to succeed, such as 95%%, for the exit code 0 '
        '(default: all)',
        Value('SHARE', 'nothing', 'share'),
    ),
    Option(
        '--results',
        'The folder for the results (default: one for just this sweep below '
        'the log folder of the workspace)',
        Value('DIR', 'folders', 'path'),
    ),
)
_SWEEP_SHOWN = (
    Option('--quiet', 'Show no progress, only failures and the end'),
    Option(
        '--tty', 'Let each process of the runs write to a terminal of its own'
    ),
    Option('--no-color', 'Use no colours'),
    Option(
        '--log-limit',
        'What the log files of each run may take together, such as 50MB, '
        f'1GB or {NO_LIMIT} (default: {RUN_LOG_LIMIT // 10**6}MB)',
        Value('SIZE', 'nothing', 'size'),
    ),
)
_CREATE = (
    Option(
        '--build-type',
        'How the package is built (default: %(default)s). That of type cmake '
        'needs no ROS',
        Value(
            None, 'choices', choices=('ament_cmake', 'ament_python', 'cmake')
        ),
    ),
    Option(
        '--dependencies',
        'The packages that it needs, such as rclpy std_msgs',
        Value('PKG', 'packages', arity='some'),
    ),
    Option(
        '--node',
        'The name of its node (default: that of the package and _node); '
        'NAME.cpp is one in C++',
        Value('NAME', 'nothing'),
    ),
    Option(
        '--add-node',
        'Add a node to a package that is there; NAME.cpp is one in C++',
        Value('NAME', 'nothing'),
        excludes=_not(
            *('--node', '--dependencies', '--license', '--description'),
            *('--maintainer-name', '--maintainer-email', '--destination'),
        ),
    ),
    Option(
        '--license',
        'Its license, as SPDX calls it; for Apache-2.0, BSD-3-Clause and MIT '
        'the text comes with it',
        Value('NAME', 'licenses'),
    ),
    Option(
        '--description', 'What the package is for', Value('TEXT', 'nothing')
    ),
    Option(
        '--maintainer-name',
        'Who looks after it (default: user.name of git)',
        Value('NAME', 'nothing'),
    ),
    Option(
        '--maintainer-email',
        'The address of this person (default: user.email of git)',
        Value('ADDRESS', 'nothing'),
    ),
    Option(
        '--destination',
        'The folder that the folder of the package is made in (default: src '
        'in the root of a workspace, elsewhere the current folder)',
        Value('PATH', 'folders', 'path'),
    ),
)

#: All options, in the order of the help.
SECTIONS = (
    Section('options', ('launch', 'run', 'create', 'sweep'), _COMMON),
    Section('Looking without running', ('launch',), _INSPECTION),
    Section('Running', ('run',), _RUN),
    Section('The runs', ('sweep',), _RUNS),
    Section('What each run is to achieve', ('sweep',), _GOAL),
    Section('Results', ('sweep',), _RESULTS),
    Section('Building', ('launch', 'run', 'sweep'), _BUILD),
    Section('Building', ('launch', 'sweep'), _LAUNCH_BUILD),
    Section('What is shown and kept', ('launch',), _SHOWN),
    Section('What is shown and kept', ('sweep',), _SWEEP_SHOWN),
    Section('Running', ('launch', 'sweep'), _PREFIX),
    Section('Watching files', ('launch',), _WATCH),
    Section('Other machines', ('launch',), _MACHINES),
    Section('Ending by itself, as in CI', ('launch',), (*_GOAL, *_REPORT)),
    Section('Running launches', ('launch',), _SESSIONS),
    Section('options', ('create',), _CREATE),
)


@cache
def options_of(verb: Verb) -> Mapping[str, Option]:
    """Return the options of a verb by each way to write them."""
    return {
        flag: option
        for section in SECTIONS
        if verb in section.verbs
        for option in section.options
        for flag in option.flags
    }
