# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The options of the verbs, each described once.

The parsers with their help, the errors for options that do not fit together,
completion and docs/options.md are made from these objects; the verbs read
their values as typed attributes.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Literal

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.engine.limits import LOG_LIMIT
from colcon_yamllaunch.verb.option import flag
from colcon_yamllaunch.verb.option import NO_LIMIT
from colcon_yamllaunch.verb.option import Option
from colcon_yamllaunch.verb.option import Options
from colcon_yamllaunch.verb.option import read_count
from colcon_yamllaunch.verb.option import read_file
from colcon_yamllaunch.verb.option import read_metric
from colcon_yamllaunch.verb.option import read_path
from colcon_yamllaunch.verb.option import read_pattern
from colcon_yamllaunch.verb.option import read_place
from colcon_yamllaunch.verb.option import read_seconds
from colcon_yamllaunch.verb.option import read_share
from colcon_yamllaunch.verb.option import read_size
from colcon_yamllaunch.verb.option import read_text
from colcon_yamllaunch.verb.option import read_words
from colcon_yamllaunch.verb.option import Value
from colcon_yamllaunch.verb.option import value
from colcon_yamllaunch.verb.option import values

#: The verbs that have options.
Verb = Literal['launch', 'run', 'create', 'sweep']

#: The format of what is shown to people.
TEXT = 'text'
#: How `--watch` tells that something failed: by its lines, or aloud, too.
WATCH_SILENTLY = 'silent'
WATCH_WITH_BELL = 'bell'
#: Which runs of a sweep are done again.
AGAIN_FAILED = 'failed'
AGAIN_ALL = 'all'
#: Bytes that the logs of each run of a sweep may take, as there are many.
RUN_LOG_LIMIT = 100_000_000

#: The options that show something of a launch instead of running it.
INSPECTIONS = ('--show-args', '--check', '--plan', '--schema')
#: The options that ask something of launches that run already.
REQUESTS = ('--status', '--stop', '--restart', '--lifecycle', '--logs')


def _not(
    *options: str, error: str = '{one} and {other} exclude one another'
) -> Mapping[str, str]:
    return dict.fromkeys(options, error)


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


class _Common(Options):
    """What all verbs have."""

    TITLE = 'options'
    version = flag(
        'Show the versions of this plug-in and of colcon-core, and exit'
    )


class _AllHelp(Options):
    """How to see the options that `--help` leaves out."""

    TITLE = 'options'
    help_all = flag('Show all options, and exit')


class _Inspection(Options):
    """What shows a launch instead of running it."""

    TITLE = 'Looking without running'
    show_args = flag(
        'Show the launch arguments',
        short='-s',
        excludes=_not('--check', '--plan', '--schema'),
    )
    check = value(
        'Check every branch of the launch file and of its includes, or all '
        'launch files of the workspace; written --check=json, '
        '--check=github or --check=sarif for programs',
        Value('FORMAT', read_text, choices=(TEXT, 'json', 'github', 'sarif')),
        arity='choice',
        excludes=_not('--plan', '--schema'),
    )
    portable = flag(
        'With --check: find what `ros2 launch` would reject, too',
        needs=('--check',),
    )
    plan = value(
        'Show what would run; --plan=sh is a script that runs it, '
        '--plan=json can be saved and run, --plan=mermaid and '
        '--plan=dot are drawings',
        Value(
            'FORMAT', read_text, choices=(TEXT, 'sh', 'json', 'mermaid', 'dot')
        ),
        arity='choice',
        excludes=_not('--schema'),
    )
    run_commands = flag(
        'With --plan: run $(command …), whatever $(eval …) says, and the '
        'setup scripts of the workspace, which a plan does without otherwise',
        needs=('--plan',),
    )
    from_plan = value(
        'Run a plan that was saved',
        Value('FILE', read_file, 'files'),
    )
    schema = flag('Print the JSON Schema of launch files, for editors')


class _Program(Options):
    """How a program is run."""

    TITLE = 'Running'
    prefix = Option(
        'A command in one word that gets the program and its arguments as '
        'its last arguments, such as "gdb -ex run --args"',
        (),
        Value('"COMMAND ..."', read_words),
    )


class _Building(Options):
    """What is built."""

    TITLE = 'Building'
    workspace = value(
        'The root of the workspace (default: found from the current folder '
        'upwards)',
        Value('PATH', read_path, 'folders'),
    )
    paths = values(
        'Build the packages at just these paths, as `colcon build --paths` '
        'takes them',
        Value('PATH', read_text, 'folders'),
        'some',
    )
    no_build = flag(
        'Build nothing',
        excludes=_not('--build-all', '--paths', '--force'),
    )
    build_all = flag(
        'Build all packages of the workspace',
        excludes=_not('--paths'),
    )
    build_args = Option(
        'Further arguments for `colcon build`, in one word',
        (),
        Value('"ARG ..."', read_words, takes_dash=True),
    )


class _LaunchBuilding(_Building):
    """What is built for a launch."""

    TITLE = 'Building'
    why = flag(
        'Say of each package that the launch needs why it is built or not, '
        'and what needs it; with --plan or --no-build: why it would be; with '
        '--watch: what follows from each change, and why',
        excludes=_not('--show-args', '--check', '--schema'),
    )
    force = flag(
        'Build all packages that the launch needs, not just those that are '
        'not up to date',
    )


class _Shown(Options):
    """What a launch shows and keeps."""

    TITLE = 'What is shown and kept'
    quiet = flag(
        'Show only the output of the processes, warnings and failures',
        excludes={**_RUNS_NONE, **_not('--verbose')},
    )
    verbose = flag(
        'Show also the command line of each process, the variables that it '
        'gets, its parameters, and where each of them comes from',
        excludes=_RUNS_NONE,
    )
    tty = flag(
        'Let each process write to a terminal of its own, as if the launch '
        'file said `emulate_tty: true` for all of them',
    )
    no_color = flag('Use no colours')
    no_status = flag(
        'Do not keep the state of the processes at the bottom of a terminal'
    )
    log_limit = Option(
        'What the log files of the launch may take together, such as 500MB, '
        f'2GB or {NO_LIMIT} (default: {LOG_LIMIT // 10**9}GB)',
        LOG_LIMIT,
        Value('SIZE', read_size),
    )


class _Prefix(Options):
    """How the executables of a launch are started."""

    TITLE = 'Running'
    launch_prefix = value(
        'A command to start executables with, such as "gdb -ex run --args"; '
        'in one word',
        Value('COMMAND', read_text),
        excludes=_MADE_ALREADY,
    )
    launch_prefix_filter = value(
        'Use the prefix for executables whose name matches from its start',
        Value('REGEX', read_text),
        excludes=_MADE_ALREADY,
    )


class _Watching(Options):
    """Whether files are watched."""

    TITLE = 'Watching files'
    watch = value(
        'Go on with the files: when one is saved, build and evaluate what '
        'depends on it, and restart just what runs it; --watch=bell rings '
        'when something fails. With --until: check after each change',
        Value('HOW', read_text, choices=(WATCH_SILENTLY, WATCH_WITH_BELL)),
        arity='choice',
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
    )


class _Machines(Options):
    """Where processes run."""

    TITLE = 'Other machines'
    on = value(
        'Run all of it on another machine, as if it were here: USER@HOST or '
        'whatever ssh takes, slurm:partition=NAME for an allocation, or with '
        '--deploy the name of a machine',
        Value('HOST', read_text, 'hosts'),
        excludes=_ONE_COMPUTER,
    )
    deploy = value(
        'Run processes on the machines that a file names for them',
        Value('FILE', read_file, 'files'),
        excludes=_ONE_COMPUTER,
    )


class _Goal(Options):
    """What ends a launch."""

    TITLE = 'What each run is to achieve'
    until = values(
        'End with success as soon as a line of a process matches; given '
        'several times, all must have matched',
        Value('REGEX', read_pattern, takes_dash=True),
        'each',
        excludes=_RUNS_NONE,
    )
    timeout = value(
        'End with failure when --until takes longer; without --until, when '
        'the launch does',
        Value('SECONDS', read_seconds),
        excludes=_RUNS_NONE,
    )
    for_ = value(
        'Run for a time, and end with failure as soon as a process fails; '
        'with --until, the time starts when all has matched',
        Value('SECONDS', read_seconds),
        excludes=_RUNS_NONE,
    )


class _Ending(_Goal):
    """What ends a launch, and its report."""

    TITLE = 'Ending by itself, as in CI'
    junit = value(
        'Write a JUnit report with a case for each process and --until',
        Value('FILE', read_file, 'files'),
        excludes=_RUNS_NONE,
    )


class _Control(Options):
    """Requests to running launches."""

    TITLE = 'Running launches'
    status = value(
        'Show all running launches with their processes and components; '
        '--status=json for programs',
        Value('FORMAT', read_text, choices=(TEXT, 'json')),
        arity='choice',
        excludes=_not(
            *('--stop', '--restart', '--lifecycle', '--logs', '--attach')
        ),
    )
    stop = values(
        'Stop processes and unload components, by name or glob; without a '
        'name, the launch',
        Value('NAME', read_text, 'parts'),
        'any',
        excludes=_not('--restart', '--lifecycle', '--logs', '--attach'),
    )
    restart = values(
        'Start processes and load components anew, by name or glob',
        Value('NAME', read_text, 'parts'),
        'any',
        excludes=_not('--lifecycle', '--logs', '--attach'),
    )
    lifecycle = values(
        'Change the state of lifecycle nodes, by name or glob: configure, '
        'activate, deactivate, cleanup or shutdown',
        Value('NAME TRANSITION', read_text, 'lifecycles'),
        'any',
        excludes=_not('--logs', '--attach', '--ui'),
    )
    logs = values(
        'Show what processes wrote, by name or glob; for a component, what '
        'its container did',
        Value('NAME', read_text, 'parts'),
        'any',
        excludes=_not('--attach'),
    )
    follow = flag(
        'With --logs: the last lines, then what comes',
        short='-f',
        needs=('--logs',),
    )
    attach = value(
        'Connect the keyboard to a process: with PKG FILE to one of the new '
        'launch, else to one of a running launch; Ctrl-] detaches',
        Value('NAME', read_text, 'terminals'),
    )
    ui = flag(
        'Show a running launch on the full screen; with PKG FILE, the new one',
        excludes={
            **_RUNS_NONE,
            **_not('--status', '--stop', '--restart', '--logs', '--attach'),
        },
    )
    of = value(
        'Which running launch is meant, where that is not clear: its '
        "package, launch file or pid, or a glob ('*' for all)",
        Value('LAUNCH', read_text, 'launches'),
        needs=(*REQUESTS, '--attach', '--ui'),
    )


class _Runs(Options):
    """The runs of a sweep."""

    TITLE = 'The runs'
    table = value(
        'A CSV file with launch arguments as columns and a run in each '
        'further line; with arguments beside it, all combinations',
        Value('FILE', read_file, 'files'),
    )
    repeat = Option(
        'Run each combination several times',
        1,
        Value('N', read_count),
    )
    jobs = value(
        'How many runs go on at a time (default: the number of processors; '
        'with --on slurm as many as Slurm lets)',
        Value('N', read_count),
    )
    on = value(
        'Where the runs are done: slurm:OPTION=VALUE,… has Slurm do them, '
        'as array jobs with these options of sbatch (default: this machine)',
        Value('WHERE', read_place, 'places'),
    )
    share_network = flag(
        'Leave the runs in the network of the machine, for those that need '
        'it; each still has a ROS_DOMAIN_ID of its own',
    )
    again = value(
        'Do runs again that are done: those that failed, or all',
        Value('WHICH', read_text, choices=(AGAIN_FAILED, AGAIN_ALL)),
    )


class _Results(Options):
    """The results of a sweep."""

    TITLE = 'Results'
    metric = values(
        'Measure something of each run: the group of the expression in the '
        'last line of a process that matches; may be given several times',
        Value('NAME=REGEX', read_metric, takes_dash=True),
        'each',
    )
    require = value(
        'How many runs have to succeed, such as 95%%, for the exit code 0 '
        '(default: all)',
        Value('SHARE', read_share),
    )
    results = value(
        'The folder for the results (default: one for just this sweep below '
        'the log folder of the workspace)',
        Value('DIR', read_path, 'folders'),
    )


class _SweepShown(Options):
    """What a sweep shows and keeps."""

    TITLE = 'What is shown and kept'
    quiet = flag('Show no progress, only failures and the end')
    tty = flag('Let each process of the runs write to a terminal of its own')
    no_color = flag('Use no colours')
    log_limit = Option(
        'What the log files of each run may take together, such as 50MB, '
        f'1GB or {NO_LIMIT} (default: {RUN_LOG_LIMIT // 10**6}MB)',
        RUN_LOG_LIMIT,
        Value('SIZE', read_size),
    )


class _Package(Options):
    """A new package."""

    TITLE = 'options'
    build_type = Option(
        'How the package is built (default: %(default)s). That of type cmake '
        'needs no ROS',
        'ament_cmake',
        Value(
            None, read_text, choices=('ament_cmake', 'ament_python', 'cmake')
        ),
    )
    dependencies = values(
        'The packages that it needs, such as rclpy std_msgs',
        Value('PKG', read_text, 'packages'),
        'some',
    )
    node = value(
        'The name of its node (default: that of the package and _node); '
        'NAME.cpp is one in C++',
        Value('NAME', read_text),
    )
    add_node = value(
        'Add a node to a package that is there; NAME.cpp is one in C++',
        Value('NAME', read_text),
        excludes=_not(
            *('--node', '--dependencies', '--license', '--description'),
            *('--maintainer-name', '--maintainer-email', '--destination'),
        ),
    )
    license = value(
        'Its license, as SPDX calls it; for Apache-2.0, BSD-3-Clause and MIT '
        'the text comes with it',
        Value('NAME', read_text, 'licenses'),
    )
    description = value('What the package is for', Value('TEXT', read_text))
    maintainer_name = value(
        'Who looks after it (default: user.name of git)',
        Value('NAME', read_text),
    )
    maintainer_email = value(
        'The address of this person (default: user.email of git)',
        Value('ADDRESS', read_text),
    )
    destination = value(
        'The folder that the folder of the package is made in (default: src '
        'in the root of a workspace, elsewhere the current folder)',
        Value('PATH', read_path, 'folders'),
    )


@dataclass(frozen=True, slots=True)
class ControlOptions:
    """
    What the user asks of running launches.

    :param action: `status`, `stop`, `restart`, `lifecycle`, `logs`, `attach`
      or `ui`
    :param names: The processes and components, by name or glob
    :param launch: Which launch is meant: its package, launch file, title or
      process id; None when that is clear
    :param follow: Whether `logs` waits for more
    :param status_format: How `status` is shown
    :param transition: What `lifecycle` has nodes do
    """

    action: str
    names: tuple[str, ...] = ()
    launch: str | None = None
    follow: bool = False
    status_format: str = TEXT
    transition: str = ''


class LaunchOptions(
    _Common,
    _AllHelp,
    _Inspection,
    _LaunchBuilding,
    _Shown,
    _Prefix,
    _Watching,
    _Machines,
    _Ending,
    _Control,
):
    """The command line of `colcon launch`."""

    DAILY = (
        *('--version', '--help-all', '--show-args', '--check', '--plan'),
        *('--no-build', '--watch', '--until', '--status', '--stop'),
        *('--restart', '--logs'),
    )
    #: The launch arguments, those that options stand for among them.
    arguments: Mapping[str, str] = MappingProxyType({})
    #: What is asked of running launches, if anything is; then there is
    #: nothing else.
    control: ControlOptions | None = None

    @property
    def is_deployed(self) -> bool:
        """Whether anything is to run on other machines."""
        return self.on is not None or self.deploy is not None

    @property
    def inspects(self) -> bool:
        """Whether something is shown instead of running."""
        formats = self.check, self.plan
        return self.show_args or self.schema or formats != (None, None)

    @property
    def checks_all(self) -> bool:
        """Whether all launch files of the workspace are to be checked."""
        names_none = not self.positionals and not self.arguments
        return self.check is not None and names_none

    @property
    def runs(self) -> bool:
        """Whether what is in the workspace may be run."""
        return not self.inspects or self.run_commands


class RunOptions(_Common, _Program, _Building):
    """The command line of `colcon run`."""

    package: str = ''
    #: The program as the user names it.
    executable: str | None = None
    arguments: tuple[str, ...] = ()


class SweepOptions(
    _Common,
    _Runs,
    _Goal,
    _Results,
    _LaunchBuilding,
    _SweepShown,
    _Prefix,
):
    """The command line of `colcon sweep`."""

    #: What was written for each launch argument.
    arguments: Mapping[str, str] = MappingProxyType({})
    #: Launch arguments that options stand for.
    fixed: Mapping[str, str] = MappingProxyType({})

    def as_launch(self) -> LaunchOptions:
        """Return the options of each of its launches, without arguments."""
        return LaunchOptions(
            positionals=self.positionals,
            arguments=dict(self.fixed),
            workspace=self.workspace,
            paths=self.paths,
            no_build=self.no_build,
            build_all=self.build_all,
            build_args=self.build_args,
            why=self.why,
            force=self.force,
            quiet=self.quiet,
            no_color=self.no_color,
        )


class CreateOptions(_Common, _Package):
    """The command line of `colcon create`."""

    package: str = ''


#: The options of each verb.
OPTIONS: Mapping[Verb, type[Options]] = {
    'launch': LaunchOptions,
    'run': RunOptions,
    'create': CreateOptions,
    'sweep': SweepOptions,
}
