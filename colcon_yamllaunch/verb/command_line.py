# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The words of a command line, read by argparse as the options say.

colcon's parser reads options up to the first other word, and leaves the rest
to the verb. Two things argparse cannot do: an option whose value is only
behind '=' (it takes the next word), and a value that begins with a dash. So
these options are written with '=' before it gets them.
"""

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
import os
import re
from typing import Any, NoReturn

import colcon_core
import colcon_yamllaunch
from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.messages import show
from colcon_yamllaunch.common.suggestions import enumeration
from colcon_yamllaunch.verb.options import (
    CreateOptions,
    EXCLUSIVE,
    LaunchOptions,
    Option,
    OPTIONS,
    read_debug,
    REQUESTS,
    RunOptions,
    SweepOptions,
    Verb,
)
from colcon_yamllaunch.verb.options_verb import report_errors

AnyOptions = LaunchOptions | RunOptions | CreateOptions | SweepOptions

SEPARATOR = '--'
_PATHS_FIX = "put it behind PKG and FILE, or '--' after the paths"

_ARGUMENT = re.compile(r'[^-][^\s]*?:=|:=')
#: What argparse calls the number of values.
_NARGS: Mapping[str, Mapping[str, str]] = {
    'one': {},
    'each': {'action': 'append'},
    'choice': {'nargs': '?'},
    'any': {'nargs': '*'},
    'some': {'nargs': '+'},
}


class _Parser(argparse.ArgumentParser):
    """A parser that raises its errors as `UserError`."""

    def __init__(self, verb: Verb, words: Sequence[str]) -> None:
        super().__init__(add_help=False, allow_abbrev=False)
        named = {word.partition('=')[0] for word in words}
        for option in OPTIONS[verb].all():
            # to add an option takes long, and most command lines have few;
            # those with a short form may stand together, as in -sf
            if option.short or option.name in named:
                _add(self, option)

    def error(self, message: str) -> NoReturn:
        raise UserError(message)


def add_options(parser: Any, verb: Verb) -> None:
    """Add the options of a verb to a parser, the common ones first."""
    # what stands in the section of --help is added to the parser itself
    groups = {'options': parser}
    for title, options in OPTIONS[verb].sections():
        if title not in groups:
            groups[title] = parser.add_argument_group(title)
        for option in options:
            _add(groups[title], option)


def _add(group: Any, option: Option[Any]) -> None:
    settings: dict[str, Any] = {'help': option.help, 'dest': option.key}
    if option.value is None:
        settings['action'] = 'store_true'
    else:
        settings |= {'metavar': option.value.name, **_NARGS[option.arity]}
    if option.arity == 'choice':
        settings['const'] = option.choices[0]
    elif option.choices:
        settings['choices'] = option.choices
    group.add_argument(*option.flags, **settings)


def show_help(parser: Any, verb: Verb) -> int:
    """Show the help without rare options, and return 0."""
    daily = OPTIONS[verb].DAILY
    rare = {o.key for o in OPTIONS[verb].all() if o.name not in daily}
    for action in parser._actions:
        if daily and action.dest in rare:
            action.help = argparse.SUPPRESS
    show(parser.format_help(), end='')
    return 0


def print_help(parser: Any, verb: Verb) -> None:
    """Do what argparse does for `--help`, and report an error of output."""
    code = report_errors(verb, lambda: show_help(parser, verb))
    if code:
        parser.exit(code)


def read_command_line(known: Any, verb: Verb) -> AnyOptions | None:
    """
    Return the options, or None if the user asked for help or versions.

    In this case, these are shown.

    :param known: What colcon's parser has made of it: options that stand
      before the first other word, and `positionals`
    :raises UserError: when it makes no sense
    """
    words = known.positionals
    if verb == 'run':
        # also where the executable would stand; all behind is the program's
        words = [word for word in words[:3] if word != SEPARATOR][:2]
    if not {'-h', '--help'}.isdisjoint(words):
        show_help(known.verb_parser, verb)
        return None
    options = _PARSERS[verb](known)
    if options.version:
        show(
            f'colcon-yamllaunch {colcon_yamllaunch.__version__}, '
            f'colcon-core {colcon_core.__version__}'
        )
    elif isinstance(options, LaunchOptions) and options.help_all:
        show(known.verb_parser.format_help(), end='')
    else:
        return options
    return None


def written_for_argparse(words: Sequence[str], verb: Verb) -> list[str]:
    """
    Write options with '=' where argparse would take another value.

    :raises UserError: if a value is `--`, which argparse drops
    """
    written = ['='.join(group) for group in _grouped(words, verb)]
    for word in written:
        name = word.removesuffix('=--')
        if name != word and name in OPTIONS[verb].by_flag():
            raise UserError(
                f"{name} takes no value '--': leave it out, or correct it"
            )
    return written


def program_index(words: Sequence[str]) -> int:
    """Return the index of the first word of `colcon run` that is no option."""
    groups = list(_grouped(words, 'run'))
    parser = _Parser('run', words)
    parser.add_argument('program', nargs=argparse.REMAINDER)
    try:
        values, _ = parser.parse_known_args(list(map('='.join, groups)))
    except UserError:
        # colcon's parser will find the same
        return len(words)
    program = groups[len(groups) - len(values.program) :]
    return len(words) - sum(map(len, program))


def _grouped(words: Sequence[str], verb: Verb) -> Iterator[list[str]]:
    """Yield each word, options whose value needs a '=' with their value."""
    options = OPTIONS[verb].by_flag()
    rest = iter(words)
    for word in rest:
        option = options.get(word)
        if option and option.arity == 'choice':
            yield [word, option.choices[0]]
        elif option and option.value and option.value.takes_dash:
            value = next(rest, None)
            yield [word] if value is None else [word, value]
        else:
            yield [word]


def split_line(
    known: Any, verb: Verb = 'launch'
) -> tuple[Any, list[str], list[str]]:
    """
    Separate options, other words and launch arguments, in any order.

    Return the values of all options, the words that belong to none (and
    options that do not exist), and the launch arguments.

    :param known: What colcon's parser has read: the options in front of the
      first other word, and `positionals`
    :raises UserError: if an option lacks its value
    """
    words = [word for word in known.positionals if word != SEPARATOR]
    written = written_for_argparse(words, verb)
    # an option that takes any number of values would take them, too
    arguments, words = _split_arguments(written)
    keys = [option.key for option in OPTIONS[verb].all()]
    front = argparse.Namespace(**{k: getattr(known, k, None) for k in keys})
    values, positionals = _Parser(verb, words).parse_known_args(words, front)
    if values.paths:
        # it has taken whatever follows
        more, values.paths = _split_arguments(values.paths)
        arguments = more + arguments
    return values, positionals, arguments


def _split_arguments(words: Sequence[str]) -> tuple[list[str], list[str]]:
    """Separate the launch arguments from the other words."""
    arguments = [word for word in words if _ARGUMENT.match(word)]
    return arguments, [word for word in words if not _ARGUMENT.match(word)]


def named(word: str) -> tuple[str, str]:
    """
    Return a launch argument and its value.

    :raises UserError: when it has no name
    """
    name, _, value = word.partition(':=')
    if not name:
        raise UserError(
            f"the launch argument '{word}' has no name",
            'it is written name:=value',
        )
    return name, value


def given_options(values: Any, verb: Verb) -> dict[str, Option[Any]]:
    """Return the options that were given, by name."""
    return {
        option.name: option
        for option in OPTIONS[verb].all()
        if getattr(values, option.key, None) not in (None, False)
    }


def read_options(values: Any, verb: Verb) -> dict[str, Any]:
    """
    Return the values of the options that were given, by their keys.

    :param values: What argparse has read
    :raises UserError: if a value makes no sense, or options do not fit
      together
    """
    given = given_options(values, verb)
    _refuse_unfit(given)
    return {
        option.key: _read_value(option, getattr(values, option.key))
        for option in given.values()
    }


def _read_value(option: Option[Any], given: Any) -> Any:
    if option.choices and given not in option.choices:
        raise UserError(
            f"{option.name} has no format '{given}'",
            f'it is one of {", ".join(option.choices)}',
        )
    if option.value is None:
        return given
    read = option.value.read
    if isinstance(given, str):
        return read(option.name, given)
    return tuple(read(option.name, text) for text in given)


def _refuse_unfit(given: Mapping[str, Option[Any]]) -> None:
    """Refuse options that do not fit together."""
    for group in EXCLUSIVE:
        found = [name for name in group if name in given]
        if len(found) > 1:
            raise UserError(f'{found[0]} and {found[1]} exclude one another')
    for one, option in given.items():
        for other, error in option.excludes.items():
            if other in given:
                raise UserError(error.format(one=one, other=other))
    for option in given.values():
        if option.needs and given.keys().isdisjoint(option.needs):
            written = option.flags[0]
            if option.value is not None:
                written = f'{written} {option.value.name}'
            needed = enumeration(option.needs)
            raise UserError(f'{written} goes with {needed}')


def refuse_unknown(words: Sequence[str], verb: Verb) -> None:
    """
    Refuse words that look like options.

    :raises UserError: when there is one
    """
    for index, word in enumerate(words):
        if not word.startswith('-'):
            continue
        from colcon_yamllaunch.common.suggestions import nearest, question

        name = word.partition('=')[0]
        if verb != 'launch' and name in OPTIONS['launch'].by_flag():
            raise UserError(
                f"'colcon {verb}' has no option '{name}'",
                "'colcon launch' has it",
            )
        meant = [nearest(word, OPTIONS[verb].by_flag())]
        if verb in ('launch', 'sweep'):
            meant.insert(0, _as_argument(word, words[index + 1 :]))
        listing = '--help-all' if OPTIONS[verb].DAILY else '--help'
        hint = f"'colcon {verb} {listing}' lists the options"
        raise UserError(
            f"there is no option '{word}'", question(*meant) or hint
        )


def _as_argument(word: str, rest: Sequence[str]) -> str | None:
    """Return the launch argument that `--name value` may be meant as."""
    name, is_given, value = word.lstrip('-').partition('=')
    if not is_given and rest and not rest[0].startswith('-'):
        value = rest[0]
    return f'{name}:={value}' if name and value else None


def parse_launch_options(known: Any) -> LaunchOptions:
    """
    Read the command line of `colcon launch`; see `read_command_line`.

    :raises UserError: when it makes no sense
    """
    values, positionals, arguments = split_line(known)
    if values.version:
        return LaunchOptions(version=True)
    if values.help_all:
        return LaunchOptions(help_all=True)
    request = request_of(values, positionals)
    if request is not None:
        names, transition = _read_names(request, values, positionals)
        return LaunchOptions(
            request=request,
            names=tuple(names),
            transition=transition,
            **read_options(values, 'launch'),
        )
    refuse_unknown(positionals, 'launch')
    attach = None
    if not is_about_service(values):
        # the process of a new launch is no request to a running one
        attach, values.attach = values.attach, None
    read = read_options(values, 'launch')
    if read.pop('of', None) is not None:
        raise UserError(
            '--of LAUNCH is about a launch that runs, and what else is given '
            'begins one'
        )
    meant = {**dict(map(named, arguments)), **_pop_prefixes(read)}
    options = LaunchOptions(
        positionals=tuple(positionals), arguments=meant, attach=attach, **read
    )
    _refuse_unclear(options)
    return options


def is_about_service(values: Any) -> bool:
    """Return whether a service is to be installed or removed."""
    services = values.install_service, values.remove_service
    return services != (None, None)


def request_of(values: Any, positionals: Sequence[str]) -> str | None:
    """Return the request to running launches; None for a new launch."""
    if values.demo or is_about_service(values):
        return None
    actions = [name.removeprefix('--') for name in (*REQUESTS, '--timeline')]
    if not positionals and values.from_plan is None:
        # with something to launch, these two are about the new launch
        actions += ['attach', 'ui']
    given = (a for a in actions if getattr(values, a) not in (None, False))
    return next(given, None)


def _read_names(
    request: str, values: Any, positionals: Sequence[str]
) -> tuple[Sequence[str], str]:
    """Return the names that a request is about, and a transition if any."""
    names: Sequence[str] = positionals
    if request == 'attach':
        names = (values.attach,)
    elif request == 'debug':
        names = (read_debug('--debug', values.debug)[0],)
    elif request not in ('status', 'ui'):
        names = (*getattr(values, request), *positionals)
    if '--all' in names:
        meant = f"--{request} '*' means all of a launch"
        if request in ('status', 'stop'):
            meant = f"--{request} --of '*' means all launches"
        raise UserError("there is no option '--all'", meant)
    # argparse takes options that do not exist for names
    refuse_unknown(names, 'launch')
    if request == 'status' and positionals:
        raise UserError(
            f"--status takes no '{positionals[0]}'",
            'it shows all running launches; one of them with --of LAUNCH',
        )
    if request == 'restart' and not names:
        raise UserError(
            '--restart needs the NAME of a process or component',
            "'*' means all of them",
        )
    if request == 'lifecycle':
        return _read_transition(names)
    return names, ''


def _read_transition(words: Sequence[str]) -> tuple[Sequence[str], str]:
    """Split words into the names of nodes and a transition."""
    from colcon_yamllaunch.common.suggestions import one_of
    from colcon_yamllaunch.plan.plan import TRANSITIONS

    *names, last = words or ('',)
    if names and last in TRANSITIONS:
        return names, last
    if names:
        raise UserError(
            f"--lifecycle: there is no transition '{last}'",
            one_of(last, TRANSITIONS),
        )
    raise UserError(
        '--lifecycle needs the NAME of a lifecycle node and a transition',
        f'it is one of {", ".join(TRANSITIONS)}',
    )


def _refuse_unclear(options: LaunchOptions) -> None:
    if options.remove_service is not None:
        if options.positionals or options.arguments:
            raise UserError('--remove-service NAME takes nothing to launch')
        return
    if options.from_plan is not None:
        if options.inspects or options.positionals:
            raise UserError('--from-plan FILE takes nothing else to launch')
    elif options.demo:
        if options.positionals:
            raise UserError('--demo takes nothing else to launch')
    elif not (options.positionals or options.schema or options.checks_all):
        _refuse_taken_words(options, 'paths', _PATHS_FIX)
        # most command lines name something
        from colcon_yamllaunch.verb import target
        from colcon_yamllaunch.workspace.colcon import package_scan

        root = target.find_workspace(options.workspace, ())
        locator = package_scan.scan_packages(root, os.environ)
        raise UserError(
            'there is nothing to launch',
            'usage: colcon launch PKG FILE, or colcon launch '
            f'path/to/file.yaml{target.launch_commands(locator)}',
        )
    if options.watch is not None and options.timeout and not options.until:
        raise UserError(
            '--watch goes on until it is stopped',
            'with it, --timeout is for what --until waits for',
        )
    if not options.until_ready:
        _refuse_two_ends(options, 'the launch')


def _refuse_two_ends(options: LaunchOptions | SweepOptions, what: str) -> None:
    """Refuse `--for` with `--timeout`, which end `what`, without `--until`."""
    if options.until or options.timeout is None or options.for_ is None:
        return
    raise UserError(
        f'--for and --timeout exclude one another: the one ends {what} with '
        'success, the other with failure',
        'with --until, --timeout is for what comes before, and --for for '
        'what comes after',
    )


def _refuse_taken_words(values: Any, name: str, fix: str) -> None:
    """Refuse an option that took the words that were not meant for it."""
    if getattr(values, name):
        raise UserError(f'--{name} took all that follows it', fix)


def _pop_prefixes(read: dict[str, Any]) -> dict[str, str]:
    """Remove the options that are launch arguments, and return these."""
    keys = [key for key in read if key.startswith('launch_prefix')]
    return {key.replace('_', '-'): read.pop(key) for key in keys}


_SWEEP_USAGE = (
    'usage: colcon sweep PKG FILE name:=1..100, or '
    'colcon sweep path/to/file.yaml name:=1..100'
)


def parse_sweep_options(known: Any) -> SweepOptions:
    """
    Read the command line of `colcon sweep`; see `read_command_line`.

    :raises UserError: when it makes no sense
    """
    values, positionals, arguments = split_line(known, 'sweep')
    if values.version:
        return SweepOptions(version=True)
    refuse_unknown(positionals, 'sweep')
    read = read_options(values, 'sweep')
    fixed = _pop_prefixes(read)
    given: dict[str, str] = {}
    for name, value in map(named, arguments):
        if name in given:
            raise UserError(
                f"the launch argument '{name}' is given twice",
                'several values are written as one list: '
                f'{name}:={given[name]},{value}',
            )
        given[name] = value
    options = SweepOptions(
        positionals=tuple(positionals), arguments=given, fixed=fixed, **read
    )
    if not options.positionals:
        _refuse_taken_words(options, 'paths', _PATHS_FIX)
        raise UserError('there is nothing to launch', _SWEEP_USAGE)
    names = [metric.name for metric in options.metric]
    for name in names:
        if names.count(name) > 1:
            raise UserError(
                f"--metric: there are two that are called '{name}'"
            )
    _refuse_two_ends(options, 'a run')
    return options


_RUN_USAGE = 'usage: colcon run [options] PKG EXEC [argument ...]'


def parse_run_options(known: Any) -> RunOptions:
    """
    Read the command line of `colcon run`; see `read_command_line`.

    :raises UserError: when it makes no sense
    """
    words = known.positionals
    words = words[1:] if words[:1] == [SEPARATOR] else words
    if known.version:
        return RunOptions(version=True)
    read = read_options(known, 'run')
    if not words:
        _refuse_taken_words(known, 'paths', "put '--' after the paths")
        raise UserError('there is nothing to run', _RUN_USAGE)
    package, *rest = words
    refuse_unknown([package], 'run')
    if rest and rest[0].startswith('-'):
        raise UserError(
            f"'{rest[0]}' stands where the executable should",
            f'options stand in front of the package; {_RUN_USAGE}',
        )
    return RunOptions(
        package=package,
        executable=rest[0] if rest else None,
        arguments=tuple(rest[1:]),
        **read,
    )


_CREATE_USAGE = 'usage: colcon create PKG [options]'
_EXAMPLE_USAGE = 'usage: colcon create --example [DIR]'


def parse_create_options(known: Any) -> CreateOptions:
    """
    Read the command line of `colcon create`; see `read_command_line`.

    :raises UserError: when it makes no sense
    """
    words = known.positionals
    if known.version:
        return CreateOptions(version=True)
    refuse_unknown(words, 'create')
    if known.example:
        read = read_options(known, 'create')
        if len(words) > 1:
            raise UserError(
                f"'{words[1]}' is one word too many", _EXAMPLE_USAGE
            )
        return CreateOptions(package=''.join(words), **read)
    if not words:
        fix = 'put it behind the name of the package'
        _refuse_taken_words(known, 'dependencies', fix)
        raise UserError('there is no name for the package', _CREATE_USAGE)
    if len(words) > 1:
        raise UserError(
            f"'{words[1]}' is one word too many: one package is made at a "
            'time',
            _CREATE_USAGE,
        )
    return CreateOptions(package=words[0], **read_options(known, 'create'))


_PARSERS: Mapping[Verb, Callable[[Any], AnyOptions]] = {
    'launch': parse_launch_options,
    'run': parse_run_options,
    'create': parse_create_options,
    'sweep': parse_sweep_options,
}
