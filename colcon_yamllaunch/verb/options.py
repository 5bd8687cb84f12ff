# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The options of the verbs, each described once.

The parsers with their help, the errors for options that do not fit together,
completion and docs/options.md are made from these objects; the verbs read
their values as typed attributes. First stands what an option is, then how
values are read, then the options.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field
from functools import cache
import math
from pathlib import Path
import re
import shlex
from types import MappingProxyType
from typing import (
    Any,
    ClassVar,
    Generic,
    Literal,
    overload,
    TYPE_CHECKING,
    TypeVar,
)

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.frozen import dataclass, mutable
from colcon_yamllaunch.engine.limits import DEFAULT_LOG_BYTES

if TYPE_CHECKING:
    from colcon_yamllaunch.engine.line_pattern import LinePattern
    from colcon_yamllaunch.sweep.run import Metric


#: How many values an option takes: one; one each time that it is given;
#: maybe one of its choices, behind '='; any number; at least one.
Arity = Literal['one', 'each', 'choice', 'any', 'some']
#: What Tab offers for a value, see `completing.py`.
Completer = Literal[
    'files',
    'folders',
    'hosts',
    'launches',
    'licenses',
    'lifecycles',
    'nothing',
    'packages',
    'members',
    'places',
    'processes',
    'profiles',
    'terminals',
]

_T = TypeVar('_T')
_Self = TypeVar('_Self', bound='Options')


@dataclass(frozen=True, slots=True)
class OptionValue(Generic[_T]):
    """
    The value of an option.

    :param name: What `--help` calls it
    :param read: Returns it from the name of the option and a word
    :param completer: The candidates that Tab offers
    :param choices: The words that it may be
    :param takes_dash: Whether it may begin with a dash
    """

    name: str | None
    read: Callable[[str, str], _T]
    completer: Completer = 'nothing'
    choices: tuple[str, ...] = ()
    takes_dash: bool = False


@mutable
class Option(Generic[_T]):
    """
    An option: an attribute of the class of a verb's options.

    :param default: Its value if it is not given
    :param value: Its value; None if it has none
    :param short: Its short form, if it has one
    :param excludes: Options that it must not be given with, and the error,
      with `{one}` for this option and `{other}` for that one
    :param needs: Options, one of which must be given with it, if any must
    :param key: The name of the attribute, from which that of the option is
      made: `no_build` is `--no-build`, `for_` is `--for`
    """

    help: str
    default: _T
    value: OptionValue[Any] | None = None
    arity: Arity = 'one'
    short: str | None = None
    excludes: Mapping[str, str] = field(default_factory=dict)
    needs: tuple[str, ...] = ()
    key: str = ''

    def __set_name__(self, owner: type, key: str) -> None:
        self.key = key

    @overload
    def __get__(self, options: None, owner: type) -> 'Option[_T]': ...

    @overload
    def __get__(self, options: 'Options', owner: type) -> _T: ...

    def __get__(
        self, options: 'Options | None', owner: type
    ) -> 'Option[_T] | _T':
        # a value that was given is in the object, where Python looks first
        return self if options is None else self.default

    @property
    def name(self) -> str:
        """How the option is written; others refer to it by this name."""
        return f'--{self.key.rstrip("_").replace("_", "-")}'

    @property
    def choices(self) -> tuple[str, ...]:
        """The words that its value may be, () for any words."""
        return () if self.value is None else self.value.choices

    @property
    def flags(self) -> list[str]:
        """All ways to write the option."""
        return [flag for flag in (self.short, self.name) if flag is not None]


class Options:
    """
    The options that were given, with the other words.

    A subclass is a section of options, or has the sections of a verb as its
    bases, in the order of `--help`.

    :param values: The options that were given, by their attributes
    :raises TypeError: if there is no such attribute
    """

    #: What `--help` shows above the options; sections may share one.
    TITLE: ClassVar[str] = 'options'
    #: The options that `--help` shows, if it does not show all.
    DAILY: ClassVar[tuple[str, ...]] = ()
    #: The package and the launch file, or a path.
    positionals: tuple[str, ...] = ()

    def __init__(self, **values: Any) -> None:
        for key in values:
            if not hasattr(type(self), key):
                raise TypeError(f'{type(self).__name__} has no {key}')
        vars(self).update(values)

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and vars(self) == vars(other)

    def replaced(self: _Self, **values: Any) -> _Self:
        """Return the same options but for some values."""
        return type(self)(**{**vars(self), **values})

    @classmethod
    def sections(cls) -> Iterator[tuple[str, list[Option[Any]]]]:
        """Yield the title of each section with its options."""
        for section in cls.__bases__:
            assert issubclass(section, Options)
            yield (
                section.TITLE,
                [
                    option
                    for base in reversed(section.__mro__)
                    for option in vars(base).values()
                    if isinstance(option, Option)
                ],
            )

    @classmethod
    @cache
    def by_flag(cls) -> Mapping[str, Option[Any]]:
        """Return the options by each way to write them."""
        return {
            flag: option
            for _, options in cls.sections()
            for option in options
            for flag in option.flags
        }

    @classmethod
    def all(cls) -> Sequence[Option[Any]]:
        """Return the options in the order of `--help`."""
        return list(dict.fromkeys(cls.by_flag().values()))


def text(
    name: str | None,
    completer: Completer = 'nothing',
    choices: tuple[str, ...] = (),
) -> OptionValue[str]:
    """Make a value that is a text; see `OptionValue`."""
    return OptionValue(name, read_text, completer, choices)


def flag(help_text: str, **more: Any) -> Option[bool]:
    """Make an option that takes no value."""
    return Option(help_text, False, **more)


def value(
    help_text: str, value: OptionValue[_T], **more: Any
) -> Option[_T | None]:
    """Make an option that takes a value."""
    return Option(help_text, None, value, **more)


def choice(
    help_text: str, name: str, choices: tuple[str, ...], **more: Any
) -> Option[str | None]:
    """Make an option with a value, maybe: one of `choices`, behind '='."""
    return Option(
        help_text, None, text(name, choices=choices), 'choice', **more
    )


def values(
    help_text: str, value: OptionValue[_T], arity: Arity, **more: Any
) -> Option[tuple[_T, ...]]:
    """Make an option that takes several values."""
    return Option(help_text, (), value, arity, **more)


#: The value of `--log-limit` for no limit.
NO_LIMIT = 'none'
#: Bytes that a limit for logs has at least.
SMALLEST_LOG_LIMIT = 1_000_000

_SIZE_PATTERN = r'(\d+(?:\.\d+)?) ?([kmgt]?)(i?b?)'
_POWERS = ('', 'k', 'm', 'g', 't')


def read_text(_option: str, text: str) -> str:
    """Return the word as it is."""
    return text


def read_path(_option: str, text: str) -> Path:
    """Return a path, with `~` expanded."""
    return Path(text).expanduser()


def read_file(option: str, text: str) -> Path:
    """
    Return the path of a file.

    :raises UserError: if it is empty
    """
    if not text:
        raise UserError(f'{option} needs the name of a file')
    return read_path(option, text)


def read_words(option: str, text: str) -> tuple[str, ...]:
    """
    Split a text as a shell would.

    :raises UserError: if a quote is open
    """
    try:
        return tuple(shlex.split(text))
    except ValueError as e:
        raise UserError(f'{option} has an open quote: {e}') from e


def read_pattern(option: str, text: str) -> 'LinePattern':
    """
    Return a regular expression.

    :raises UserError: if it is empty or invalid
    """
    if not text:
        raise UserError(
            f'{option} needs a regular expression, and this one is empty'
        )
    # few launches wait for a line
    from colcon_yamllaunch.engine.line_pattern import LinePattern

    try:
        return LinePattern(text)
    except (re.error, OverflowError, RecursionError) as e:
        raise UserError(
            f"{option}: '{text}' is no regular expression: {e}"
        ) from e


def read_seconds(option: str, text: str) -> float:
    """
    Return a positive number of seconds.

    :raises UserError: if it is anything else
    """
    value = _number(text)
    if 0 < value < math.inf:
        return value
    raise UserError(
        f"{option} needs a number of seconds above 0, not '{text}'"
    )


def _number(text: str) -> float:
    """Return a number, or NaN for anything else."""
    try:
        return float(text)
    except ValueError:
        return math.nan


def read_count(option: str, text: str) -> int:
    """
    Return a positive number.

    :raises UserError: if it is anything else
    """
    if not (text.isascii() and text.isdigit()) or not 0 < int(text) < 10**9:
        raise UserError(f"{option} needs a number from 1 on, not '{text}'")
    return int(text)


def read_debug(option: str, text: str) -> tuple[str, int]:
    """
    Return the name of a process and a TCP port from `NAME[:PORT]`.

    :raises UserError: if there is no such port
    """
    name, colon, port = text.rpartition(':')
    if not colon:
        return text, DEBUG_PORT
    if not (port.isascii() and port.isdigit()) or not 0 < int(port) < 65536:
        raise UserError(
            f"{option} needs a port from 1 to 65535 after ':', not '{port}'"
        )
    return name, int(port)


def read_share(option: str, text: str) -> float:
    """
    Return a percentage as a number from 0 to 1.

    :raises UserError: if it is anything else
    """
    number, sign, rest = text.strip().partition('%')
    value = _number(number)
    if rest or not sign or not 0 <= value <= 100:
        raise UserError(
            f"{option} needs a share of all runs, such as 95%, not '{text}'"
        )
    return value / 100


def read_metric(option: str, text: str) -> 'Metric':
    """
    Return a metric of a sweep.

    :raises UserError: if it has no name or no group
    """
    # no other verb has it
    from colcon_yamllaunch.sweep.run import read_metric as read

    return read(option, text)


def read_place(option: str, text: str) -> tuple[str, ...]:
    """
    Return the options of `sbatch` from `slurm:OPTION=VALUE,…`.

    :raises UserError: if it is anything else
    """
    from colcon_yamllaunch.sweep.slurm_runner import read_slurm_options

    return read_slurm_options(option, text)


def read_size(option: str, text: str) -> int | None:
    """
    Return a number of bytes, or None for no limit.

    :param option: The option or variable that has it
    :raises UserError: when it is no size, or too small
    """
    if text == NO_LIMIT:
        return None
    match = re.fullmatch(_SIZE_PATTERN, text.strip(), re.IGNORECASE)
    if match is None:
        raise UserError(
            f"{option} takes a size such as 500MB or 2GB, or '{NO_LIMIT}', "
            f"not '{text}'"
        )
    number, prefix, unit = match.groups()
    # as in coreutils: kB is 1000 bytes, KiB and K are 1024
    base = 1000 if unit.lower() == 'b' else 1024
    size = int(float(number) * base ** _POWERS.index(prefix.lower()))
    if size < SMALLEST_LOG_LIMIT:
        raise UserError(
            f"{option} is at least 1MB, not '{text}'",
            f"'{NO_LIMIT}' means no limit",
        )
    return size


#: The verbs that have options.
Verb = Literal['launch', 'run', 'create', 'sweep']

#: The format of what is shown to people.
TEXT = 'text'
#: The files that there are schemas of.
LAUNCH_FILE = 'launch'
DEPLOYMENT = 'deploy'
#: How `--watch` tells that something failed: by its lines, or aloud, too.
WATCH_SILENTLY = 'silent'
WATCH_WITH_BELL = 'bell'
#: Where the output of a service goes.
JOURNAL = 'journal'
LOG_FILES = 'files'
#: Which runs of a sweep are done again.
AGAIN_FAILED = 'failed'
AGAIN_ALL = 'all'
#: Bytes that the logs of each run of a sweep may take, as there are many.
RUN_LOG_LIMIT = 100_000_000

#: The options that show something of a launch instead of running it.
INSPECTIONS = ('--show-args', '--check', '--plan', '--schema')
#: The options that ask something of launches that run already.
REQUESTS = (
    *('--status', '--stop', '--restart', '--lifecycle', '--logs', '--debug'),
)
#: The port at which a debugger waits for an editor unless another is given.
DEBUG_PORT = 5678


#: Options of which only one may be given.
EXCLUSIVE = (
    INSPECTIONS,
    (*REQUESTS, '--attach', '--ui', '--timeline'),
    ('--no-build', '--build-all', '--paths'),
    ('--no-build', '--force'),
    ('--quiet', '--verbose'),
    ('--install-service', '--remove-service'),
    *(('--why', other) for other in ('--show-args', '--check', '--schema')),
    *(
        ('--add-node', other)
        for other in (
            *('--node', '--dependencies', '--license', '--description'),
            *('--maintainer-name', '--maintainer-email', '--destination'),
        )
    ),
    *(
        ('--example', other)
        for other in (
            *('--build-type', '--dependencies', '--node', '--add-node'),
            *('--license', '--description', '--maintainer-name'),
            *('--maintainer-email', '--destination'),
        )
    ),
    *(
        ('--demo', other)
        for other in (*REQUESTS, '--from-plan', '--workspace')
    ),
)
_RUNS_NONE = dict.fromkeys(
    INSPECTIONS, '{one} is about a launch that runs, and {other} runs none'
)
_ONE_COMPUTER = dict.fromkeys(
    ('--show-args', '--schema'),
    '{one} is about where processes run, and {other} runs none',
)
_OWN_COPY = dict.fromkeys(
    (
        *(*INSPECTIONS, '--paths', '--no-build', '--build-all', '--watch'),
        *('--on', '--deploy', '--junit'),
    ),
    '{one} launches a copy that is removed at the end: for {other}, make one '
    'of your own with colcon create --example',
)
_MADE_ALREADY = {
    '--from-plan': '{one} goes with a launch file: the command lines of a '
    'saved plan are made already',
}

_SERVICES = ('--install-service', '--remove-service')
_INSTALLS = dict.fromkeys(
    (
        *(*INSPECTIONS, *REQUESTS, '--attach', '--ui', '--watch', '--until'),
        *('--timeout', '--for', '--junit'),
    ),
    '{one} runs no launch now, and {other} is about something else',
)
_REMOVES = '{one} NAME takes nothing to launch, such as {other}'

# values that several options have
_FILE = OptionValue('FILE', read_file, 'files')
_FOLDER = OptionValue('PATH', read_path, 'folders')
_NAME = text('NAME')
_MEMBERS = text('NAME', 'members')
_SECONDS = OptionValue('SECONDS', read_seconds)
_COUNT = OptionValue('N', read_count)
_SIZE = OptionValue('SIZE', read_size)


class _Common(Options):
    """The options of all verbs."""

    TITLE = 'options'
    version = flag(
        'Show the versions of this plug-in and of colcon-core, and exit'
    )


class _AllHelp(Options):
    """How to see the options that `--help` leaves out, and a launch."""

    TITLE = 'options'
    help_all = flag('Show all options, and exit')
    demo = flag(
        'Launch a copy of the sample workspace in a temporary folder; it '
        'needs no ROS',
        excludes=_OWN_COPY,
    )


class _Inspection(Options):
    """The options that show a launch instead of running it."""

    TITLE = 'Looking without running'
    show_args = flag('Show the launch arguments', short='-s')
    check = choice(
        'Check every branch of the launch file and of its includes, or all '
        'launch files of the workspace; written --check=json, '
        '--check=github or --check=sarif for programs',
        'FORMAT',
        (TEXT, 'json', 'github', 'sarif'),
    )
    portable = flag(
        'With --check: find what `ros2 launch` would reject, too',
        needs=('--check',),
    )
    plan = choice(
        'Show what would run; --plan=sh is a script that runs it, '
        '--plan=json can be saved and run, --plan=mermaid and '
        '--plan=dot are drawings',
        'FORMAT',
        (TEXT, 'sh', 'json', 'mermaid', 'dot'),
    )
    run_commands = flag(
        'With --plan: run $(command …), whatever $(eval …) says, and the '
        'setup scripts of the workspace, which a plan does without otherwise',
        needs=('--plan',),
    )
    from_plan = value('Run a plan that was saved', _FILE)
    schema = value(
        'Print the JSON Schema of launch files, for editors; --schema=deploy '
        'is that of deployment files',
        OptionValue('WHAT', read_text, choices=(LAUNCH_FILE, DEPLOYMENT)),
        arity='choice',
    )


class _Program(Options):
    """How a program is run."""

    TITLE = 'Running'
    prefix = Option(
        'A command in one word that gets the program and its arguments as '
        'its last arguments, such as "gdb -ex run --args"',
        (),
        OptionValue('"COMMAND ..."', read_words),
    )


class _Building(Options):
    """Which packages are built."""

    TITLE = 'Building'
    workspace = value(
        'The root of the workspace (default: found from the current folder '
        'upwards)',
        _FOLDER,
    )
    paths = values(
        'Build the packages at just these paths, as `colcon build --paths` '
        'takes them',
        text('PATH', 'folders'),
        'some',
    )
    no_build = flag('Build nothing')
    build_all = flag('Build all packages of the workspace')
    build_args = Option(
        'Further arguments for `colcon build`, in one word',
        (),
        OptionValue('"ARG ..."', read_words, takes_dash=True),
    )


class _LaunchBuilding(_Building):
    """Which packages are built for a launch."""

    TITLE = 'Building'
    why = flag(
        'Say of each package that the launch needs why it is built or not, '
        'and what needs it; with --plan or --no-build: why it would be; with '
        '--watch: what follows from each change, and why'
    )
    force = flag(
        'Build all packages that the launch needs, not just those that are '
        'not up to date'
    )


class _Shown(Options):
    """The output and logs of a launch."""

    TITLE = 'What is shown and kept'
    quiet = flag(
        'Show only the output of the processes, warnings and failures',
        excludes=_RUNS_NONE,
    )
    verbose = flag(
        'Show also the command line of each process, the variables that it '
        'gets, its parameters, and where each of them comes from',
        excludes=_RUNS_NONE,
    )
    tty = flag(
        'Let each process write to a terminal of its own, as if the launch '
        'file said `emulate_tty: true` for all of them'
    )
    no_color = flag('Use no colours')
    no_status = flag(
        'Do not keep the state of the processes at the bottom of a terminal'
    )
    log_limit = Option(
        'What the log files of the launch may take together, such as 500MB, '
        f'2GB or {NO_LIMIT} (default: {DEFAULT_LOG_BYTES // 10**9}GB)',
        DEFAULT_LOG_BYTES,
        _SIZE,
    )


class _Prefix(Options):
    """How the executables of a launch are started."""

    TITLE = 'Running'
    launch_prefix = value(
        'A command to start executables with, such as "gdb -ex run --args"; '
        'in one word',
        text('COMMAND'),
        excludes=_MADE_ALREADY,
    )
    launch_prefix_filter = value(
        'Use the prefix for executables whose name matches from its start',
        text('REGEX'),
        excludes=_MADE_ALREADY,
    )


class _Watching(Options):
    """Whether files are watched."""

    TITLE = 'Watching files'
    watch = choice(
        'Go on with the files: when one is saved, build and evaluate what '
        'depends on it, and restart just what runs it; --watch=bell rings '
        'when something fails. With --until: check after each change',
        'HOW',
        (WATCH_SILENTLY, WATCH_WITH_BELL),
        excludes={
            **_RUNS_NONE,
            '--from-plan': '{one} goes with a launch file: {other} runs a '
            'plan that was made already',
            '--for': '{one} goes on until it is stopped, {other} for a time',
        },
    )


class _Machines(Options):
    """Where processes run."""

    TITLE = 'Other machines'
    on = value(
        'Run all of it on another machine, as if it were here: USER@HOST or '
        'whatever ssh takes, slurm:partition=NAME for an allocation, or with '
        '--deploy the name of a machine',
        text('HOST', 'hosts'),
        excludes=_ONE_COMPUTER,
    )
    deploy = value(
        'Read from a file which machines run which processes, what processes '
        'wait for, when they are restarted, and what they may use',
        _FILE,
        excludes=_ONE_COMPUTER,
    )
    profile = value(
        'The profile of the --deploy file to use',
        OptionValue('NAME', read_text, 'profiles'),
        needs=('--deploy',),
    )


class _Boot(Options):
    """Services of systemd."""

    TITLE = 'Start at boot'
    install_service = value(
        'Build, check and save the launch, and make it a service of systemd '
        'with this name; given again, update it',
        _NAME,
        excludes=_INSTALLS,
    )
    remove_service = value(
        'Stop such a service, and remove it',
        _NAME,
        excludes={**_INSTALLS, '--from-plan': _REMOVES, '--deploy': _REMOVES},
    )
    user = flag(
        'One of yours (the default, unless you are root)', needs=_SERVICES
    )
    system = flag(
        'One of the system, which needs sudo',
        needs=_SERVICES,
        excludes={'--user': '{one} and {other} exclude one another'},
    )
    as_ = value(
        'The user that a service of the system runs as (default: you)',
        OptionValue('USER', read_text),
        needs=('--install-service',),
        excludes={
            '--user': '{one} goes with --system: a service of yours runs as '
            'you'
        },
    )
    enable = flag('Start it at each boot', needs=('--install-service',))
    service_logs = value(
        'Where its output goes: to the journal, with an identifier for each '
        f'process, or to log files (default: {JOURNAL})',
        OptionValue('WHERE', read_text, choices=(JOURNAL, LOG_FILES)),
        needs=('--install-service',),
    )


class _Goal(Options):
    """When a launch ends by itself."""

    TITLE = 'What each run is to achieve'
    until = values(
        'End with success as soon as a line of a process matches; given '
        'several times, all must have matched',
        OptionValue('REGEX', read_pattern, takes_dash=True),
        'each',
        excludes=_RUNS_NONE,
    )
    timeout = value(
        'End with failure when --until takes longer; without --until, when '
        'the launch does',
        _SECONDS,
        excludes=_RUNS_NONE,
    )
    for_ = value(
        'Run for a time, and end with failure as soon as a process fails; '
        'with --until, the time starts when all has matched',
        _SECONDS,
        excludes=_RUNS_NONE,
    )


class _Ending(_Goal):
    """When a launch ends by itself, and its report."""

    TITLE = 'Ending by itself, as in CI'
    until_ready = flag(
        'End with success as soon as all processes and components are ready, '
        'as --deploy defines that (without it: when they run), or with '
        'failure when that takes longer than --timeout',
        excludes={
            **_RUNS_NONE,
            '--watch': '{one} ends the launch, and {other} goes on',
        },
    )
    junit = value(
        'Write a JUnit report with a case for each process, its readiness and '
        '--until',
        _FILE,
        excludes=_RUNS_NONE,
    )


class _Control(Options):
    """Requests to running launches."""

    TITLE = 'Running launches'
    status = choice(
        'Show all running launches with their processes and components; '
        '--status=json for programs',
        'FORMAT',
        (TEXT, 'json'),
    )
    stop = values(
        'Stop processes and unload components, by name or glob; without a '
        'name, the launch',
        _MEMBERS,
        'any',
    )
    restart = values(
        'Start processes and load components anew, by name or glob',
        _MEMBERS,
        'any',
    )
    lifecycle = values(
        'Change the state of lifecycle nodes, by name or glob: configure, '
        'activate, deactivate, cleanup or shutdown',
        text('NAME TRANSITION', 'lifecycles'),
        'any',
    )
    logs = values(
        'Show what processes wrote, by name or glob; for a component, what '
        'its container did',
        _MEMBERS,
        'any',
    )
    debug = value(
        'Restart a process under debugpy if it runs Python, else under '
        'gdbserver, which waits for an editor at a port of this computer '
        f'(default: {DEBUG_PORT})',
        OptionValue('NAME[:PORT]', read_debug, 'processes'),
    )
    follow = flag(
        'With --logs: the last lines, then what comes',
        short='-f',
        needs=('--logs',),
    )
    timeline = values(
        'Write a page that shows when each process of the latest launch, or '
        'of that with this log folder, started and was ready, and what it '
        'waited for; print the chain that took longest',
        OptionValue('LOG', read_text, 'folders'),
        'any',
    )
    attach = value(
        'Connect the keyboard to a process: with PKG FILE to one of the new '
        'launch, else to one of a running launch; Ctrl-] detaches',
        text('NAME', 'terminals'),
    )
    ui = flag(
        'Show a running launch on the full screen; with PKG FILE, the new one',
        excludes=_RUNS_NONE,
    )
    of = value(
        'Which running launch is meant, where that is not clear: its '
        "package, launch file or pid, or a glob ('*' for all)",
        text('LAUNCH', 'launches'),
        needs=(*REQUESTS, '--attach', '--ui'),
    )


class _Runs(Options):
    """The runs of a sweep."""

    TITLE = 'The runs'
    table = value(
        'A CSV file with launch arguments as columns and a run in each '
        'further line; with arguments beside it, all combinations',
        _FILE,
    )
    repeat = Option('Run each combination several times', 1, _COUNT)
    jobs = value(
        'How many runs go on at a time (default: the number of processors; '
        'with --on slurm as many as Slurm lets)',
        _COUNT,
    )
    on = value(
        'Where the runs are done: slurm:OPTION=VALUE,… has Slurm do them, '
        'as array jobs with these options of sbatch (default: this machine)',
        OptionValue('WHERE', read_place, 'places'),
    )
    share_network = flag(
        'Leave the runs in the network of the machine, for those that need '
        'it; each still has a ROS_DOMAIN_ID of its own'
    )
    again = value(
        'Do runs again that are done: those that failed, or all',
        text('WHICH', choices=(AGAIN_FAILED, AGAIN_ALL)),
    )


class _Results(Options):
    """The results of a sweep."""

    TITLE = 'Results'
    metric = values(
        'Measure something of each run: the group of the expression in the '
        'last line of a process that matches; may be given several times',
        OptionValue('NAME=REGEX', read_metric, takes_dash=True),
        'each',
    )
    require = value(
        'How many runs have to succeed, such as 95%%, for the exit code 0 '
        '(default: all)',
        OptionValue('SHARE', read_share),
    )
    results = value(
        'The folder for the results (default: one for just this sweep below '
        'the log folder of the workspace)',
        OptionValue('DIR', read_path, 'folders'),
    )


class _SweepShown(Options):
    """The output and logs of a sweep."""

    TITLE = 'What is shown and kept'
    quiet = flag('Show no progress, only failures and the end')
    tty = flag('Let each process of the runs write to a terminal of its own')
    no_color = flag('Use no colours')
    log_limit = Option(
        'What the log files of each run may take together, such as 50MB, '
        f'1GB or {NO_LIMIT} (default: {RUN_LOG_LIMIT // 10**6}MB)',
        RUN_LOG_LIMIT,
        _SIZE,
    )


class _Package(Options):
    """A new package."""

    TITLE = 'options'
    build_type = Option(
        'How the package is built (default: ament_cmake). That of type cmake '
        'needs no ROS',
        'ament_cmake',
        text(None, choices=('ament_cmake', 'ament_python', 'cmake')),
    )
    dependencies = values(
        'The packages that it needs, such as rclpy std_msgs',
        text('PKG', 'packages'),
        'some',
    )
    node = value(
        'The name of its node (default: that of the package and _node); '
        'NAME.cpp is one in C++',
        _NAME,
    )
    add_node = value(
        'Add a node to a package that is there; NAME.cpp is one in C++', _NAME
    )
    license = value(
        'Its license, as SPDX calls it; for Apache-2.0, BSD-3-Clause and MIT '
        'the text comes with it',
        text('NAME', 'licenses'),
    )
    description = value('What the package is for', text('TEXT'))
    maintainer_name = value(
        'Who looks after it (default: user.name of git)', _NAME
    )
    maintainer_email = value(
        'The address of this person (default: user.email of git)',
        text('ADDRESS'),
    )
    destination = value(
        'The folder that the folder of the package is made in (default: src '
        'in the root of a workspace, elsewhere the current folder)',
        _FOLDER,
    )
    example = flag(
        'Make no package, but a copy of the sample workspace, in the folder '
        'DIR (default: sample_ws)'
    )


class LaunchOptions(
    _Common,
    _AllHelp,
    _Inspection,
    _LaunchBuilding,
    _Shown,
    _Prefix,
    _Watching,
    _Machines,
    _Boot,
    _Ending,
    _Control,
):
    """The command line of `colcon launch`."""

    DAILY = (
        *('--version', '--help-all', '--demo', '--show-args', '--check'),
        *('--plan', '--no-build', '--watch', '--until', '--status'),
        *('--stop', '--restart', '--logs'),
    )
    #: The launch arguments, including those of `--launch-prefix`.
    arguments: Mapping[str, str] = MappingProxyType({})
    #: The request to running launches, if it is one: `status`, `stop`,
    #: `restart`, `lifecycle`, `logs`, `debug`, `attach`, `ui` or `timeline`,
    #: which is about one that has ended.
    request: str | None = None
    #: The processes and components that this is about, by name or glob.
    names: tuple[str, ...] = ()
    #: The transition of `lifecycle`.
    transition: str = ''

    @property
    def title_words(self) -> tuple[str, ...]:
        """What is launched, as the user calls it."""
        path = self.from_plan
        if path is None:
            return self.positionals
        # the plan of a service is in a folder of its name
        return (path.stem if path.stem == path.parent.name else str(path),)

    @property
    def title(self) -> str:
        """What is launched, in one line."""
        return ' '.join(self.title_words)

    @property
    def inspects(self) -> bool:
        """Whether something is shown instead of running."""
        formats = self.check, self.plan, self.schema
        return self.show_args or formats != (None, None, None)

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

    #: The text of each launch argument.
    arguments: Mapping[str, str] = MappingProxyType({})
    #: Launch arguments that options stand for.
    fixed: Mapping[str, str] = MappingProxyType({})

    def as_launch(self) -> LaunchOptions:
        """Return the options of each of its launches, without arguments."""
        kept = (
            *('positionals', 'workspace', 'paths', 'no_build', 'build_all'),
            *('build_args', 'why', 'force', 'quiet', 'no_color'),
        )
        values = {key: v for key, v in vars(self).items() if key in kept}
        return LaunchOptions(arguments=dict(self.fixed), **values)


class CreateOptions(_Common, _Package):
    """The command line of `colcon create`."""

    #: The name of the package; with `--example`, the folder, '' for none.
    package: str = ''


#: The options of each verb.
OPTIONS: Mapping[Verb, type[Options]] = {
    'launch': LaunchOptions,
    'run': RunOptions,
    'create': CreateOptions,
    'sweep': SweepOptions,
}
