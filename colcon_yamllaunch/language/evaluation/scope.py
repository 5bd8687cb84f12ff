# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What an action sees of the actions before it: names, and their values.

A value is a text that is known or not: a launch knows all; before it, a text
may depend on what the launch is given.

A scope within another one is a layer upon it, so that it ends by being left.
An action that may not be done gets a layer, too; what it has set is merged
into the scope around, as far as it is known then.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import field
from typing import NamedTuple

from colcon_yamllaunch.common.frozen import dataclass, mutable
from colcon_yamllaunch.language.vocabulary.parameter import Parameter
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
class ValuePlace:
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
    place: ValuePlace | None = None

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


#: Stands for all names, of variables or parameters, when they are not known.
ANY_NAME = ''


@dataclass(frozen=True, slots=True)
class Guard:
    """
    A condition around an action.

    :param key: The key of what is tested
    :param wanted: What it must be
    :param sources: What it depends on; empty when it is the same in every
      launch
    :param taken: Whether it holds with every launch argument at its default,
      None when that is not known
    """

    key: str
    wanted: bool
    sources: frozenset[str]
    taken: bool | None

    def excludes(self, other: 'Guard') -> bool:
        """
        Return whether the two can never hold together.

        Conditions that differ and depend on the same things, such as two
        tests of one argument, are taken for alternatives.
        """
        if self.key == other.key:
            return self.wanted is not other.wanted
        return not self.sources.isdisjoint(other.sources)


@mutable
class Names:
    """
    Names and what they stand for, seen from within a scope.

    :param outer: The names around; None when nothing of them is seen
    :param hides: Whether the values of those may be others here
    :param masked: Those of them whose values may be others here
    :param is_open: Whether there may be names that cannot be known
    :param is_given: Whether what the command line gives may be seen here;
      None when that is not known
    :param own: What was set in this scope
    """

    outer: 'Names | None' = None
    hides: bool = False
    masked: frozenset[str] = frozenset()
    is_open: bool = False
    is_given: bool | None = True
    own: dict[str, Value] = field(default_factory=dict)

    def inner(
        self, *, hides: bool = False, masked: frozenset[str] = frozenset()
    ) -> 'Names':
        """Return a layer upon these."""
        return Names(self, hides, masked, is_given=self.is_given)

    def get(self, name: str) -> Value | None:
        """Return what a name stands for, None when it is not set."""
        is_hidden = False
        for layer in self._layers():
            value = layer.own.get(name)
            if value is not None:
                return value.forgotten() if is_hidden else value
            if layer.hides or name in layer.masked:
                is_hidden = True
        return None

    def set(self, name: str | None, value: Value) -> None:
        """Set a name; one that is not known may be any."""
        if name is None:
            self.is_open = True
        else:
            self.own[name] = value

    def all(self) -> dict[str, Value]:
        """Return all names that are set, in the order they were first."""
        if self.outer is None:
            return dict(self.own)
        return self.outer.all() | self.own

    def may_have_others(self) -> bool:
        """Return whether unknown names may exist."""
        return any(layer.is_open for layer in self._layers())

    def clear(self) -> None:
        """Forget all names."""
        self.outer = None
        self.own = {}
        self.is_open = self.is_given = False

    def merge(self, inner: 'Names', guard: Guard | None) -> None:
        """
        Adopt what a layer above, which ends, has set.

        :param guard: The condition that it stood under, if a launch decides
        """
        self.is_open = self.is_open or inner.is_open
        if guard is None or guard.taken:
            if inner.outer is None:
                self.clear()
                self.is_open = inner.is_open
            for name, value in inner.own.items():
                self.own[name] = _guarded(value, guard)
        else:
            if inner.outer is None and guard.taken is None:
                for name, value in self.all().items():
                    self.own[name] = value.forgotten()
            for name, value in inner.own.items():
                self.own[name] = _either(self.get(name), value, guard)
        if guard is None or inner.is_given is self.is_given:
            self.is_given = inner.is_given
        else:
            self.is_given = None

    def _layers(self) -> Iterator['Names']:
        layer: Names | None = self
        while layer is not None:
            yield layer
            layer = layer.outer


def _guarded(value: Value, guard: Guard | None) -> Value:
    if guard is None:
        return value
    key = shortened(f'{guard.key}?{value.key}')
    return value._replace(key=key, sources=value.sources | guard.sources)


def _either(old: Value | None, new: Value, guard: Guard) -> Value:
    """Return what a name stands for when a condition may have set it."""
    if old is None:
        return _guarded(new, guard).forgotten()
    if old.key == new.key:
        return old
    keeps = guard.taken is False or old.text == new.text
    return old._replace(
        text=old.text if keeps else None,
        key=shortened(f'{guard.key}?{new.key}:{old.key}'),
        sources=old.sources | new.sources | guard.sources,
    )


@mutable
class Scope:
    """
    The state that actions leave to those behind them.

    ROS 2 keeps the last three among the launch configurations too; here each
    has its own place, and lists are never shared between scopes.

    :param configurations: The launch configurations
    :param environment: The environment variables that launch files change
    :param variables: The variables of the loops around
    :param namespace: The namespace of nodes, absolute, if one was pushed
    :param parameters: What nodes get before their own parameters: a parameter
      or the path of a file with parameters
    :param remaps: The remappings of nodes, as from and to
    :param uses_sim_time: Whether the timers of ROS time are on `/clock`
    :param container: The full name of the container whose components are
      gone through, None when it is not known
    """

    configurations: Names = field(default_factory=Names)
    environment: Names = field(default_factory=Names)
    variables: dict[str, Value] = field(default_factory=dict)
    namespace: Value | None = None
    parameters: tuple[Parameter | str, ...] = ()
    remaps: tuple[tuple[str, str], ...] = ()
    uses_sim_time: bool = False
    container: str | None = None

    def inner(
        self, *, hides: bool = False, masked: frozenset[str] = frozenset()
    ) -> 'Scope':
        """Return a scope within this one; see :class:`Names`."""
        return Scope(
            self.configurations.inner(hides=hides, masked=masked),
            self.environment.inner(hides=hides),
            self.variables,
            self.namespace,
            self.parameters,
            self.remaps,
            self.uses_sim_time,
            self.container,
        )

    def without_outer(self) -> 'Scope':
        """Return a scope within this one that sees none of what was set."""
        scope = Scope(variables=self.variables)
        scope.configurations.is_given = self.configurations.is_given
        return scope

    def reset(self) -> None:
        """Forget what ROS 2 keeps as launch configurations."""
        self.configurations.clear()
        self.namespace = None
        self.parameters = ()
        self.remaps = ()
        self.uses_sim_time = False

    def merge(self, inner: 'Scope', guard: Guard | None) -> None:
        """Adopt the changes of an inner scope; see :meth:`Names.merge`."""
        self.configurations.merge(inner.configurations, guard)
        self.environment.merge(inner.environment, guard)
        if guard is None or guard.taken:
            self.namespace = inner.namespace
            self.parameters = inner.parameters
            self.remaps = inner.remaps
            self.uses_sim_time = inner.uses_sim_time
            return
        if inner.parameters != self.parameters:
            both = (*self.parameters, *inner.parameters)
            self.parameters = tuple(dict.fromkeys(both))
        if guard.taken is None and inner.namespace != self.namespace:
            self.namespace = unknown(f'namespace {guard.key}', guard.sources)


def environment_changes(
    before: Mapping[str, str], changed: Names
) -> tuple[tuple[str, str | None], ...]:
    """
    Return the variables that differ from an environment, sorted by name.

    :param before: The environment to change
    :param changed: What launch files change; a variable without a text is
      unset, and None in the result
    """
    return tuple(
        [
            (name, value.text)
            for name, value in sorted(changed.all().items())
            if before.get(name) != value.text
        ]
    )
