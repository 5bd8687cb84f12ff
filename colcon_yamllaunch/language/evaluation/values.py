# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Texts that are known or not.

A launch knows all; before it, a text may depend on what the launch is given.
"""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.plan.position import Position

#: The longest key of a value, in characters; a longer one is cut.
MAXIMUM_KEY_LENGTH = 400
#: The longest text that is made before a launch, in characters.
MAXIMUM_TEXT_LENGTH = 1_000_000

_NO_SOURCES: frozenset[str] = frozenset()


class AlreadyReportedError(Exception):
    """A value is unknown for a reason that was reported before."""


class LeftOpen(str):
    """
    A substitution that stands in a plan as it is written.

    The value of one has itself as its source.
    """

    __slots__ = ()


@dataclass(frozen=True, slots=True)
class Place:
    """
    Where a launch file writes a value.

    :param length: How many characters it takes there
    :param includes: The includes that led to that file, innermost first
    """

    position: Position
    length: int
    includes: tuple[Position, ...]


class Value(NamedTuple):
    """
    A text that is known or not.

    :param text: The text, with every launch argument at its default; None when
      it is not known
    :param key: How it was made; two values of the same key are always equal
    :param sources: What it depends on that is not the launch files' own: the
      launch arguments, environment variables and commands. A value without
      any is the same in every launch.
    :param origins: Where the launch configuration that it was made of first
      was set, and those that this one was made of, nearest first
    :param place: Where it is written, if a policy keeps that
    """

    text: str | None
    key: str
    sources: frozenset[str] = _NO_SOURCES
    origins: tuple[Position, ...] = ()
    place: Place | None = None

    @property
    def is_sure(self) -> bool:
        """Whether it has this text in every launch."""
        return self.text is not None and not self.sources

    def forgotten(self) -> 'Value':
        """Return the same with a text that is not known."""
        sources = self.sources or frozenset((self.key,))
        return self._replace(text=None, sources=sources)


#: Stands for an environment variable that was removed.
UNSET = Value(None, '(unset)')


def known(text: str) -> Value:
    """Return the value of a text that stands in a launch file."""
    return Value(text, text)


def unknown(key: str, sources: Iterable[str] = ()) -> Value:
    """
    Return a value that is not known before the launch.

    :param sources: What it depends on; when empty, what the key names
    """
    key = shortened(key)
    return Value(None, key, frozenset(sources) or frozenset((key,)))


def derived(text: str | None, key: str, values: Iterable[Value]) -> Value:
    """
    Return the value that is made of others.

    :param text: The text, or None when it is not known
    :param key: How it is made, for when others may come out
    """
    sources = _NO_SOURCES
    origins: tuple[Position, ...] = ()
    for _, _, own_sources, own_origins, _ in values:
        if own_sources:
            sources |= own_sources
        origins = origins or own_origins
    if text is None:
        return unknown(key, sources)
    return Value(text, shortened(key) if sources else text, sources, origins)


def joined(pieces: Sequence[Value | str]) -> Value:
    """Return values and texts one behind the other."""
    texts: list[str] = []
    origins: tuple[Position, ...] = ()
    for piece in pieces:
        if isinstance(piece, str):
            texts.append(piece)
        elif piece.text is None or piece.sources:
            return _possible(pieces)
        else:
            texts.append(piece.text)
            origins = origins or piece.origins
    text = ''.join(texts)
    return Value(text, text, _NO_SOURCES, origins)


def _possible(pieces: Sequence[Value | str]) -> Value:
    values = [known(p) if isinstance(p, str) else p for p in pieces]
    texts = [value.text for value in values if value.text is not None]
    text = ''.join(texts)
    is_known = len(texts) == len(values) and len(text) <= MAXIMUM_TEXT_LENGTH
    key = ''.join([value.key for value in values])
    return derived(text if is_known else None, key, values)


def shortened(key: str) -> str:
    """Return a key of bounded length."""
    if len(key) <= MAXIMUM_KEY_LENGTH:
        return key
    return f'{key[:MAXIMUM_KEY_LENGTH]}…{hash(key)}'
