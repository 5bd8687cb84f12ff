# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Options: each is one object, which is also a typed attribute."""

from collections.abc import Callable
from collections.abc import Iterator
from collections.abc import Mapping
from collections.abc import Sequence
from dataclasses import field
from functools import cache
from typing import Any
from typing import ClassVar
from typing import Generic
from typing import Literal
from typing import overload
from typing import TypeVar

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.frozen import mutable

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
