# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a check knows of the scope that an action stands in."""

from collections.abc import Iterator
from dataclasses import dataclass
from dataclasses import field
from dataclasses import replace

from colcon_yamllaunch.language.syntax.position import Position

#: The longest key of a value, in characters; a longer one is cut.
MAXIMUM_KEY_LENGTH = 400


@dataclass(frozen=True, slots=True)
class Value:
    """
    A text that is known or not.

    :param text: The text, with every launch argument at its default; None when
      it is not known before the launch
    :param key: How it was made; two values of the same key are always equal
    :param sources: What it depends on that is not the launch files' own: the
      launch arguments, environment variables and commands. A value without
      any is the same in every launch.
    """

    text: str | None
    key: str
    sources: frozenset[str] = frozenset()

    @property
    def is_sure(self) -> bool:
        """Whether it has this text in every launch."""
        return self.text is not None and not self.sources


@dataclass(frozen=True, slots=True)
class Binding:
    """
    What a name stands for.

    :param value: Its value
    :param position: Where a launch file writes the value, None when none does
    :param length: How many characters it takes there
    :param includes: The includes that led to that file, innermost first
    """

    value: Value
    position: Position | None = None
    length: int = 1
    includes: tuple[Position, ...] = ()

    def forgotten(self) -> 'Binding':
        """Return the same with a text that is not known."""
        value = self.value
        return replace(
            self, value=unknown(value.key, value.sources or {value.key})
        )


@dataclass(frozen=True, slots=True)
class Guard:
    """
    A condition around an action that only a launch decides.

    :param key: The key of what is tested
    :param wanted: What it must be
    :param sources: What it depends on
    :param taken: Whether it holds with every launch argument at its default,
      None when that is not known
    """

    key: str
    wanted: bool
    sources: frozenset[str]
    taken: bool | None

    def excludes(self, other: 'Guard') -> bool:
        """
        Say whether the two may never hold together.

        Conditions that differ and depend on the same things, such as two
        tests of one argument, are taken for alternatives.
        """
        if self.key == other.key:
            return self.wanted is not other.wanted
        return not self.sources.isdisjoint(other.sources)


def known(text: str) -> Value:
    """Return the value of a text that stands in a launch file."""
    return Value(text, text)


def unknown(key: str, sources: 'frozenset[str] | set[str]') -> Value:
    """Return a value that is not known before the launch."""
    return Value(None, shortened(key), frozenset(sources))


def shortened(key: str) -> str:
    """Return a key of bounded length."""
    if len(key) <= MAXIMUM_KEY_LENGTH:
        return key
    return f'{key[:MAXIMUM_KEY_LENGTH]}…{hash(key)}'


@dataclass(slots=True)
class Names:
    """
    Names and what they stand for, seen from within a scope.

    :param outer: The names around; None when nothing of them is seen
    :param hides: Whether the values of those may be others here
    :param masked: Those of them whose values may be others here
    :param is_open: Whether there may be names that the check cannot know
    :param own: What was set in this scope
    """

    outer: 'Names | None' = None
    hides: bool = False
    masked: frozenset[str] = frozenset()
    is_open: bool = False
    own: dict[str, Binding] = field(default_factory=dict)

    def get(self, name: str) -> Binding | None:
        """Return what a name stands for, None when it is not set."""
        layer: Names | None = self
        is_hidden = False
        while layer is not None:
            binding = layer.own.get(name)
            if binding is not None:
                return binding.forgotten() if is_hidden else binding
            is_hidden = is_hidden or layer.hides or name in layer.masked
            layer = layer.outer
        return None

    def names(self) -> set[str]:
        """Return all names that are set."""
        return {name for layer in self._layers() for name in layer.own}

    def may_have_others(self) -> bool:
        """Say whether there may be names that are not known here."""
        return any(layer.is_open for layer in self._layers())

    def clear(self) -> None:
        """Forget all names."""
        self.outer = None
        self.own = {}
        self.is_open = False

    def merge(self, inner: 'Names', guard: Guard | None) -> None:
        """
        Take over what was set within a scope that ends.

        :param guard: The condition that it stood under, if a launch decides
        """
        self.is_open = self.is_open or inner.is_open
        if guard is None or guard.taken:
            if inner.outer is None:
                self.clear()
                self.is_open = inner.is_open
            for name, binding in inner.own.items():
                self.own[name] = _guarded(binding, guard)
            return
        for name, binding in inner.own.items():
            self.own[name] = _either(self.get(name), binding, guard)

    def _layers(self) -> Iterator['Names']:
        layer: Names | None = self
        while layer is not None:
            yield layer
            layer = layer.outer


def _guarded(binding: Binding, guard: Guard | None) -> Binding:
    if guard is None:
        return binding
    value = binding.value
    key = shortened(f'{guard.key}?{value.key}')
    sources = value.sources | guard.sources
    return replace(binding, value=Value(value.text, key, sources))


def _either(before: Binding | None, after: Binding, guard: Guard) -> Binding:
    """Return what a name stands for when a condition may have set it."""
    if before is None:
        return _guarded(after, guard).forgotten()
    old, new = before.value, after.value
    if old.key == new.key:
        return before
    keeps = guard.taken is False or old.text == new.text
    key = shortened(f'{guard.key}?{new.key}:{old.key}')
    sources = old.sources | new.sources | guard.sources
    return replace(
        before, value=Value(old.text if keeps else None, key, sources)
    )


@dataclass(slots=True)
class Scope:
    """
    What actions leave to those behind them.

    :param configurations: The launch configurations
    :param environment: The environment variables that launch files set
    :param variables: The variables of the loops around
    :param namespace: The namespace of nodes, if one was pushed
    :param parameters: The parameters that 'set_parameter' sets
    :param remaps: The names that 'set_remap' surely remaps
    """

    configurations: Names = field(default_factory=Names)
    environment: Names = field(default_factory=Names)
    variables: dict[str, Value] = field(default_factory=dict)
    namespace: Value | None = None
    parameters: frozenset[str] = frozenset()
    remaps: frozenset[str] = frozenset()

    def inner(
        self, *, hides: bool = False, masked: frozenset[str] = frozenset()
    ) -> 'Scope':
        """Return a scope within this one; see :class:`Names`."""
        return Scope(
            Names(self.configurations, hides, masked),
            Names(self.environment, hides),
            self.variables,
            self.namespace,
            self.parameters,
            self.remaps,
        )

    def reset(self) -> None:
        """Forget what ROS 2 keeps as launch configurations."""
        self.configurations.clear()
        self.namespace = None
        self.parameters = self.remaps = frozenset()

    def merge(self, inner: 'Scope', guard: Guard | None) -> None:
        """Take over what an inner scope leaves; see :meth:`Names.merge`."""
        self.configurations.merge(inner.configurations, guard)
        self.environment.merge(inner.environment, guard)
        if guard is None or guard.taken:
            self.namespace = inner.namespace
            self.parameters = inner.parameters
            self.remaps = inner.remaps
            return
        self.parameters |= inner.parameters
        if guard.taken is None and inner.namespace != self.namespace:
            self.namespace = unknown(f'namespace {guard.key}', guard.sources)
