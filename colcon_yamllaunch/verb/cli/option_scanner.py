# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Which words of a command line are options, and which are their values.

argparse cannot tell all that the table says: it takes any word behind an
option with a choice for the choice, and no value that looks like an option.
And some things are to be known before it reads the command line.
"""

from collections.abc import Iterator
from collections.abc import Mapping
from collections.abc import Sequence

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.verb.cli.option_table import Option
from colcon_yamllaunch.verb.cli.option_table import options_of
from colcon_yamllaunch.verb.cli.option_table import Verb

SEPARATOR = '--'

#: How many of the following words may be values.
_MOST = {'one': 1, 'each': 1, 'choice': 0}


@dataclass(frozen=True, slots=True)
class Item:
    """
    An option with its values, or another word.

    :param index: The index of its first word
    :param words: Its words
    :param option: The option; None for any other word
    """

    index: int
    words: tuple[str, ...]
    option: Option | None = None
    values: tuple[str, ...] = ()

    @property
    def is_positional(self) -> bool:
        """Whether this is no option, not even one that does not exist."""
        return self.option is None and not self.words[0].startswith('-')


def scan(words: Sequence[str], verb: Verb) -> Iterator[Item]:
    """Split the words behind a verb."""
    options = options_of(verb)
    index = 0
    while index < len(words):
        start = index
        index += 1
        name, equals, value = words[start].partition('=')
        option = options.get(name)
        if option is None or equals:
            values = (value,) if option else ()
            yield Item(start, (words[start],), option, values)
            continue
        index += _count_values(words[index:], option, options)
        found = tuple(words[start:index])
        yield Item(start, found, option, found[1:])


def normalised(words: Sequence[str], verb: Verb) -> list[str]:
    """Write options so that argparse reads them as the table says."""
    written: list[str] = []
    for item in scan(words, verb):
        value = None if item.option is None else item.option.value
        if value is not None and value.arity == 'choice' and not item.values:
            written.append(f'{item.words[0]}={value.choices[0]}')
        elif value is not None and value.takes_dash and len(item.words) > 1:
            written.append('='.join(item.words))
        else:
            written.extend(item.words)
    return written


def program_index(words: Sequence[str]) -> int:
    """Return where the words of a program begin, its package in front."""
    for item in scan(words, 'run'):
        if item.is_positional or item.words[0] == SEPARATOR:
            return item.index
    return len(words)


def _count_values(
    words: Sequence[str], option: Option, options: Mapping[str, Option]
) -> int:
    """Return how many words behind an option are its values."""
    if option.value is None:
        return 0
    most = _MOST.get(option.value.arity, len(words))
    if option.value.takes_dash:
        return min(most, len(words))
    for count, word in enumerate(words[:most]):
        if word == SEPARATOR or word.partition('=')[0] in options:
            return count
    return min(most, len(words))
