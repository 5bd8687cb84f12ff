# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Parsers of the options, and what to say of those that do not fit."""

import argparse
from collections.abc import Mapping
from collections.abc import Sequence
from typing import Any
from typing import NoReturn

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.verb.cli.messages import enumeration
from colcon_yamllaunch.verb.cli.option_table import Option
from colcon_yamllaunch.verb.cli.option_table import options_of
from colcon_yamllaunch.verb.cli.option_table import SECTIONS
from colcon_yamllaunch.verb.cli.option_table import Verb
from colcon_yamllaunch.verb.cli.option_values import read_value

_ARITIES: Mapping[str, Mapping[str, str]] = {
    'one': {},
    'each': {'action': 'append'},
    'choice': {'nargs': '?'},
    'any': {'nargs': '*'},
    'some': {'nargs': '+'},
}


class _Parser(argparse.ArgumentParser):
    """A parser that reports problems as all others are reported."""

    def error(self, message: str) -> NoReturn:
        raise UserError(message)


def add_options(parser: Any, verb: Verb) -> None:
    """Add the options of a verb to a parser, the common ones first."""
    # what stands in the section of --help is added to the parser itself
    groups = {'options': parser}
    for section in SECTIONS:
        if verb not in section.verbs:
            continue
        if section.title not in groups:
            group = parser.add_argument_group(section.title)
            groups[section.title] = group
        for option in section.options:
            _add(groups[section.title], option)


def _add(group: Any, option: Option) -> None:
    value = option.value
    settings: dict[str, Any] = {'help': option.help, 'dest': option.key}
    if value is None:
        settings['action'] = 'store_true'
    else:
        settings |= {'metavar': value.name, **_ARITIES[value.arity]}
        if value.arity == 'choice':
            settings['const'] = value.choices[0]
        elif value.choices:
            settings['choices'] = value.choices
            settings['default'] = value.choices[0]
    group.add_argument(*option.flags, **settings)


def parse_more(
    words: Sequence[str], known: Any, verb: Verb
) -> tuple[Any, list[str]]:
    """
    Parse options behind those that colcon's parser has read.

    Return the values of all options, and the words that belong to none,
    options that do not exist among them.

    :param known: What colcon's parser has made of the words in front
    :raises UserError: when an option lacks its value
    """
    parser = _Parser(add_help=False, allow_abbrev=False)
    named = {word.partition('=')[0] for word in words}
    options = {option.name: option for option in options_of(verb).values()}
    for option in options.values():
        # most command lines have few, and to add one takes long; those with a
        # short form may stand together, as in -sf
        if option.short or option.name in named:
            _add(parser, option)
    keys = (option.key for option in options.values())
    values = {key: getattr(known, key, None) for key in keys}
    return parser.parse_known_args(words, argparse.Namespace(**values))


def given_options(values: Any, verb: Verb) -> dict[str, Option]:
    """Return the options that were given, by name."""
    return {
        option.name: option
        for option in options_of(verb).values()
        if getattr(values, option.key, None) not in (None, False)
    }


def read_options(
    values: Any, verb: Verb, *, without: str | None = None
) -> dict[str, Any]:
    """
    Return the options that were given, read, by their keys.

    :param without: An option that is not looked at
    :raises UserError: when a value makes no sense, or options do not fit
      together
    """
    given = given_options(values, verb)
    given.pop(without or '', None)
    _refuse_unfit(given, values)
    return {
        option.key: read_value(option, getattr(values, option.key))
        for option in given.values()
    }


def unknown_option(word: str, verb: Verb) -> str:
    """Return what to say of an option that does not exist."""
    from colcon_yamllaunch.common.suggestions import did_you_mean

    hint = did_you_mean(word, options_of(verb)) or (
        f"'colcon {verb} --help' lists the options"
    )
    return f"there is no option '{word}': {hint}"


def _refuse_unfit(given: Mapping[str, Option], values: Any) -> None:
    """Refuse options that do not fit together."""
    for one, option in given.items():
        for other, error in option.excludes.items():
            if other in given:
                raise UserError(error.format(one=one, other=other))
    for option in given.values():
        value = option.value
        if option.needs and given.keys().isdisjoint(option.needs):
            written = option.flags[0]
            if value is not None:
                written = f'{written} {value.name}'
            needed = enumeration(option.needs)
            raise UserError(f'{written} goes with {needed}')
        if value is None or value.arity != 'choice':
            continue
        given_value = getattr(values, option.key)
        if given_value not in value.choices:
            raise UserError(
                f"{option.name} has no format '{given_value}': it is one of "
                f'{", ".join(value.choices)}'
            )
