# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Parsers and readers of options, and what to say of those that do not fit."""

import argparse
from collections.abc import Callable
from collections.abc import Mapping
from collections.abc import Sequence
import math
from pathlib import Path
import re
import shlex
from typing import Any
from typing import NoReturn
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.engine.output.line_pattern import LinePattern
from colcon_yamllaunch.verb.cli.argv import words_behind
from colcon_yamllaunch.verb.cli.messages import enumeration
from colcon_yamllaunch.verb.cli.option_scanner import program_index
from colcon_yamllaunch.verb.cli.option_scanner import scan
from colcon_yamllaunch.verb.cli.option_table import Kind
from colcon_yamllaunch.verb.cli.option_table import NO_LIMIT
from colcon_yamllaunch.verb.cli.option_table import Option
from colcon_yamllaunch.verb.cli.option_table import options_of
from colcon_yamllaunch.verb.cli.option_table import SECTIONS
from colcon_yamllaunch.verb.cli.option_table import Verb

if TYPE_CHECKING:
    from colcon_yamllaunch.sweep.run import Metric

#: Bytes that a limit for logs has at least.
SMALLEST_LOG_LIMIT = 1_000_000

_SIZE = r'(\d+(?:\.\d+)?) ?([kmgt]?)(i?b?)'
_POWERS = ('', 'k', 'm', 'g', 't')
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
            if value.has_default:
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


def read_options(values: Any, verb: Verb) -> dict[str, Any]:
    """
    Return the options that were given, read, by their keys.

    :raises UserError: when a value makes no sense, or options do not fit
      together
    """
    _refuse_separator(words_behind(verb), verb)
    given = given_options(values, verb)
    _refuse_unfit(given)
    return {
        option.key: read_value(option, getattr(values, option.key))
        for option in given.values()
    }


def _refuse_separator(words: Sequence[str], verb: Verb) -> None:
    """Refuse `--option=--`, whose value argparse drops."""
    if verb == 'run':
        words = words[: program_index(words)]
    for item in scan(words, verb):
        if item.option is not None and item.words[0].endswith('=--'):
            raise UserError(
                f"{item.option.name} takes no value '--': leave it "
                'out, or correct it'
            )


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
        if verb != 'launch' and name in options_of('launch'):
            raise UserError(
                f"'colcon {verb}' has no option '{name}'",
                "it is one of 'colcon launch'",
            )
        meant = [nearest(word, options_of(verb))]
        if verb in ('launch', 'sweep'):
            meant.insert(0, _as_argument(word, words[index + 1 :]))
        listed = ' or '.join(f"'{m}'" for m in meant if m is not None)
        hint = f"'colcon {verb} --help' lists the options"
        if listed:
            hint = f'did you mean {listed}?'
        raise UserError(f"there is no option '{word}'", hint)


def _as_argument(word: str, rest: Sequence[str]) -> str | None:
    """Return the launch argument that `--name value` may be meant as."""
    name, is_given, value = word.lstrip('-').partition('=')
    if not is_given and rest and not rest[0].startswith('-'):
        value = rest[0]
    return f'{name}:={value}' if name and value else None


def _refuse_unfit(given: Mapping[str, Option]) -> None:
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


def read_value(option: Option, given: Any) -> Any:
    """
    Read what argparse has got for an option.

    :param given: A text or texts, or for an option without a value True
    :raises UserError: when it makes no sense
    """
    if option.value is None:
        return given
    choices = option.value.choices
    if choices and given not in choices:
        raise UserError(
            f"{option.name} has no format '{given}'",
            f'it is one of {", ".join(choices)}',
        )
    read = READERS[option.value.kind]
    if isinstance(given, str):
        return read(option.name, given)
    return tuple(read(option.name, text) for text in given)


def _file(option: str, text: str) -> Path:
    if not text:
        raise UserError(f'{option} needs the name of a file')
    return Path(text).expanduser()


def _words(option: str, text: str) -> tuple[str, ...]:
    """Split a text as a shell would."""
    try:
        return tuple(shlex.split(text))
    except ValueError as e:
        raise UserError(f'{option} has an open quote: {e}') from e


def _pattern(option: str, text: str) -> LinePattern:
    if not text:
        raise UserError(
            f'{option} needs a regular expression, and this one is empty'
        )
    try:
        return LinePattern(text)
    except (re.error, OverflowError, RecursionError) as e:
        raise UserError(
            f"{option}: '{text}' is no regular expression: {e}"
        ) from e


def _seconds(option: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 < value < math.inf:
        raise UserError(
            f"{option} needs a number of seconds above 0, not '{text}'"
        )
    return value


def _count(option: str, text: str) -> int:
    if not (text.isascii() and text.isdigit()) or not 0 < int(text) < 10**9:
        raise UserError(f"{option} needs a number from 1 on, not '{text}'")
    return int(text)


def _share(option: str, text: str) -> float:
    """Return a part of all, from 0 to 1."""
    number, sign, rest = text.strip().partition('%')
    try:
        value = float(number)
    except ValueError:
        value = math.nan
    if rest or not sign or not 0 <= value <= 100:
        raise UserError(
            f"{option} needs a share of all runs, such as 95%, not '{text}'"
        )
    return value / 100


def _metric(option: str, text: str) -> 'Metric':
    # no other verb has it
    from colcon_yamllaunch.sweep.run import read_metric

    return read_metric(option, text)


def _place(option: str, text: str) -> tuple[str, ...]:
    from colcon_yamllaunch.sweep.slurm_client import read_slurm_options

    return read_slurm_options(option, text)


def read_size(option: str, text: str) -> int | None:
    """
    Return a number of bytes, or None for no limit.

    :param option: The option or variable that has it
    :raises UserError: when it is no size, or too small
    """
    if text == NO_LIMIT:
        return None
    match = re.fullmatch(_SIZE, text.strip(), re.IGNORECASE)
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


READERS: Mapping[Kind, Callable[[str, str], Any]] = {
    'text': lambda _, text: text,
    'count': _count,
    'file': _file,
    'metric': _metric,
    'path': lambda _, text: Path(text).expanduser(),
    'pattern': _pattern,
    'place': _place,
    'seconds': _seconds,
    'share': _share,
    'size': read_size,
    'words': _words,
}
