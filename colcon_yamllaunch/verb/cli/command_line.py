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
from collections.abc import Iterator
from collections.abc import Mapping
from collections.abc import Sequence
import re
from typing import Any
from typing import NoReturn

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.verb.cli.messages import enumeration
from colcon_yamllaunch.verb.cli.option import Option
from colcon_yamllaunch.verb.cli.options import OPTIONS
from colcon_yamllaunch.verb.cli.options import Verb

SEPARATOR = '--'

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
    """A parser that raises what it finds wrong."""

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
        settings['default'] = option.default
    group.add_argument(*option.flags, **settings)


def hide_rare_options(parser: Any, verb: Verb) -> None:
    """Leave the options out of the help that are not in daily use."""
    daily = OPTIONS[verb].DAILY
    rare = {o.key for o in OPTIONS[verb].all() if o.name not in daily}
    for action in parser._actions:
        if daily and action.dest in rare:
            action.help = argparse.SUPPRESS


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
    """Yield each word, or what belongs in front of and behind a '='."""
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
        from colcon_yamllaunch.common.suggestions import nearest

        name = word.partition('=')[0]
        if verb != 'launch' and name in OPTIONS['launch'].by_flag():
            raise UserError(
                f"'colcon {verb}' has no option '{name}'",
                "it is one of 'colcon launch'",
            )
        meant = [nearest(word, OPTIONS[verb].by_flag())]
        if verb in ('launch', 'sweep'):
            meant.insert(0, _as_argument(word, words[index + 1 :]))
        listed = ' or '.join(f"'{m}'" for m in meant if m is not None)
        listing = '--help-all' if OPTIONS[verb].DAILY else '--help'
        hint = f"'colcon {verb} {listing}' lists the options"
        if listed:
            hint = f'did you mean {listed}?'
        raise UserError(f"there is no option '{word}'", hint)


def _as_argument(word: str, rest: Sequence[str]) -> str | None:
    """Return the launch argument that `--name value` may be meant as."""
    name, is_given, value = word.lstrip('-').partition('=')
    if not is_given and rest and not rest[0].startswith('-'):
        value = rest[0]
    return f'{name}:={value}' if name and value else None
