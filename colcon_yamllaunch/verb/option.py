# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Options: each is one object, which is also a typed attribute."""

from collections.abc import Callable
from collections.abc import Iterator
from collections.abc import Mapping
from collections.abc import Sequence
from dataclasses import field
from functools import cache
import math
from pathlib import Path
import re
import shlex
from typing import Any
from typing import ClassVar
from typing import Generic
from typing import Literal
from typing import overload
from typing import TYPE_CHECKING
from typing import TypeVar

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.frozen import mutable

if TYPE_CHECKING:
    from colcon_yamllaunch.engine.line_pattern import LinePattern
    from colcon_yamllaunch.sweep.run import Metric


#: How many values an option takes: one; one each time that it is given;
#: maybe one of its choices, behind '='; any number; at least one.
Arity = Literal['one', 'each', 'choice', 'any', 'some']
#: What Tab offers for a value, see `completion/completing.py`.
Completer = Literal[
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

_T = TypeVar('_T')
_Self = TypeVar('_Self', bound='Options')


@dataclass(frozen=True, slots=True)
class Value(Generic[_T]):
    """
    What an option takes.

    :param name: What `--help` calls it
    :param read: Returns it from the name of the option and a word
    :param completer: What Tab offers for it
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
    :param value: What it takes; None for nothing
    :param short: Its short form, if it has one
    :param excludes: Options that it must not be given with, and the error,
      with `{one}` for this option and `{other}` for that one
    :param needs: Options, one of which must be given with it, if any must
    :param key: The name of the attribute, from which that of the option is
      made: `no_build` is `--no-build`, `for_` is `--for`
    """

    help: str
    default: _T
    value: Value[Any] | None = None
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
        """How it is written; other options refer to it by this."""
        return f'--{self.key.rstrip("_").replace("_", "-")}'

    @property
    def choices(self) -> tuple[str, ...]:
        """The words that its value may be, () for any."""
        return () if self.value is None else self.value.choices

    @property
    def flags(self) -> list[str]:
        """All ways to write it."""
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

    def __setattr__(self, key: str, value: object) -> None:
        raise AttributeError(f'cannot change {key}')

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


def flag(help_text: str, **more: Any) -> Option[bool]:
    """Make an option that takes no value."""
    return Option(help_text, False, **more)


def value(help_text: str, value: Value[_T], **more: Any) -> Option[_T | None]:
    """Make an option that takes a value."""
    return Option(help_text, None, value, **more)


def values(
    help_text: str, value: Value[_T], arity: Arity, **more: Any
) -> Option[tuple[_T, ...]]:
    """Make an option that takes several values."""
    return Option(help_text, (), value, arity, **more)


#: The value of `--log-limit` for no limit.
NO_LIMIT = 'none'
#: Bytes that a limit for logs has at least.
SMALLEST_LOG_LIMIT = 1_000_000

_SIZE = r'(\d+(?:\.\d+)?) ?([kmgt]?)(i?b?)'
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
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 < value < math.inf:
        raise UserError(
            f"{option} needs a number of seconds above 0, not '{text}'"
        )
    return value


def read_count(option: str, text: str) -> int:
    """
    Return a positive number.

    :raises UserError: if it is anything else
    """
    if not (text.isascii() and text.isdigit()) or not 0 < int(text) < 10**9:
        raise UserError(f"{option} needs a number from 1 on, not '{text}'")
    return int(text)


def read_share(option: str, text: str) -> float:
    """
    Return a percentage as a number from 0 to 1.

    :raises UserError: if it is anything else
    """
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


def read_metric(option: str, text: str) -> 'Metric':
    """
    Return what is measured in a sweep.

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
