# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Dataclasses that are defined fast: frozen ones, and mutable ones.

`dataclasses.dataclass(frozen=True, slots=True)` compiles six functions for
each class, at each start: before Python 3.13 that is some 0.4 ms a class, and
with all classes of a launch a tenth of the time until its first process. Here
it is one function, made when the first object is; the others are the same for
all classes.
"""

from collections.abc import Callable
import dataclasses
from operator import attrgetter
from typing import Any, TYPE_CHECKING

__all__ = ['dataclass', 'mutable']

if TYPE_CHECKING:
    from dataclasses import dataclass
    from typing import dataclass_transform, TypeVar

    _Class = TypeVar('_Class')

    @dataclass_transform(field_specifiers=(dataclasses.field,))
    def mutable(cls: type[_Class]) -> type[_Class]:
        """Make a dataclass with slots that is compared by identity."""

else:

    def mutable(cls: type) -> type:
        """
        Make a dataclass with slots that is compared by identity.

        What is said of fields in :func:`dataclass` holds for these.
        """
        return _made(cls)[0]

    def dataclass(*, frozen: bool, slots: bool) -> Callable[[type], type]:
        """
        Make dataclasses as the decorator of the standard library does.

        They are equal, hashable, shown, copied and replaced as those are, and
        as immutable. Fields may have a default or a factory of it; those of
        other kinds, `__post_init__` and other options are left to the
        standard library.

        :param frozen: Must be True
        :param slots: Must be True
        """
        assert frozen and slots
        return _define


def _made(cls: type) -> tuple[Any, tuple[dataclasses.Field[Any], ...]]:
    # for a class without one the standard library makes up a text, which takes
    # longer than all else
    cls.__doc__ = cls.__doc__ or cls.__name__
    bare = dataclasses.dataclass(init=False, repr=False, eq=False, slots=True)
    made: Any = bare(cls)
    fields = dataclasses.fields(made)
    made.__init__ = _late_initializer(made, fields)
    made.__repr__ = _show
    return made, fields


def _define(cls: type) -> type:
    made, fields = _made(cls)
    values = _getter([field.name for field in fields])
    compared = _getter([field.name for field in fields if field.compare])

    def is_equal(self: Any, other: object) -> Any:
        if other.__class__ is not self.__class__:
            return NotImplemented
        return compared(self) == compared(other)

    made.__eq__ = is_equal
    made.__hash__ = lambda self: hash(compared(self))
    made.__setattr__ = made.__delattr__ = _refuse
    made.__reduce__ = lambda self: (self.__class__, values(self))
    defined: type = made
    return defined


def _getter(names: list[str]) -> Callable[[Any], tuple[Any, ...]]:
    if len(names) > 1:
        return attrgetter(*names)
    return lambda self: tuple(getattr(self, name) for name in names)


def _late_initializer(
    made: Any, fields: tuple[dataclasses.Field[Any], ...]
) -> Any:
    # most launches make objects of half of the classes only
    def initialize(self: Any, *args: Any, **kwargs: Any) -> None:
        made.__init__ = _initializer(fields)
        made.__init__(self, *args, **kwargs)

    return initialize


def _initializer(fields: tuple[dataclasses.Field[Any], ...]) -> Any:
    names: dict[str, Any] = {
        '_missing': dataclasses.MISSING,
        '_set': object.__setattr__,
    }
    parameters, lines = ['self'], ['pass']
    for field in fields:
        name = value = parameter = field.name
        if field.default is not dataclasses.MISSING:
            names[f'_default_{name}'] = field.default
            parameter = f'{name}=_default_{name}'
        elif field.default_factory is not dataclasses.MISSING:
            names[f'_make_{name}'] = field.default_factory
            parameter = f'{name}=_missing'
            value = f'_make_{name}() if {name} is _missing else {name}'
        parameters.append(parameter)
        lines.append(f'_set(self, {name!r}, {value})')
    body = '\n '.join(lines)
    exec(f'def __init__({", ".join(parameters)}):\n {body}', names)
    return names['__init__']


def _show(self: Any) -> str:
    shown = ', '.join(
        f'{field.name}={getattr(self, field.name)!r}'
        for field in dataclasses.fields(self)
        if field.repr
    )
    return f'{self.__class__.__qualname__}({shown})'


def _refuse(*given: object) -> None:
    raise dataclasses.FrozenInstanceError(f'cannot change field {given[1]!r}')
