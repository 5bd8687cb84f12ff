# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Dataclasses that are defined fast: frozen ones, and mutable ones.

`dataclasses.dataclass(frozen=True, slots=True)` compiles six functions for
each class, at each start: before Python 3.13 that takes some 0.4 ms a class,
and with all classes of a launch a tenth of the time until its first process.
Here one function is compiled, for classes with many objects; the others are
the same for all classes. The fields that :mod:`dataclasses` works with are
made when they are first used.
"""

from collections.abc import Callable
import dataclasses
from operator import attrgetter
from typing import Any
from typing import ClassVar
from typing import get_origin
from typing import TYPE_CHECKING

__all__ = ['dataclass', 'mutable']

if TYPE_CHECKING:
    from dataclasses import dataclass
    from typing import dataclass_transform
    from typing import TypeVar

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


#: The attribute by which :mod:`dataclasses` finds the fields of a class.
_FIELDS = '__dataclass_fields__'
#: How many objects a class has before its initializer is compiled, which takes
#: as long as some fifty objects save.
_FEW = 50


class _Fields:
    """
    The fields of a class; as an attribute, what :mod:`dataclasses` expects.

    :param hints: The types by their names, those of base classes first
    :param values: The defaults, or what :func:`dataclasses.field` returned
    """

    def __init__(
        self, hints: dict[str, Any], values: dict[str, object]
    ) -> None:
        self.hints = hints
        self.values = values
        self._made: Any = None

    def __get__(self, instance: object, owner: type) -> Any:
        if self._made is None:
            contents = {'__annotations__': self.hints, **self.values}
            bare = dataclasses.dataclass(init=False, repr=False, eq=False)
            self._made = getattr(bare(type('', (), contents)), _FIELDS)
        return self._made


def _made(cls: type) -> tuple[Any, _Fields]:
    fields = _Fields({}, {})
    for base in reversed(cls.__mro__[1:]):
        inherited = base.__dict__.get(_FIELDS)
        if isinstance(inherited, _Fields):
            fields.hints |= inherited.hints
            fields.values |= inherited.values
    contents = dict(cls.__dict__)
    own = {
        name: hint
        for name, hint in cls.__annotations__.items()
        if not _is_class_variable(hint)
    }
    contents['__slots__'] = tuple(n for n in own if n not in fields.hints)
    fields.hints |= own
    fields.values |= {n: contents.pop(n) for n in own if n in contents}
    for name in ('__dict__', '__weakref__'):
        contents.pop(name, None)
    contents['__match_args__'] = tuple(fields.hints)
    contents[_FIELDS] = fields
    made: Any = type(cls)(cls.__name__, cls.__bases__, contents)
    made.__qualname__ = cls.__qualname__
    made.__init__ = _first_initializer(made, fields)
    made.__repr__ = _show
    return made, fields


def _is_class_variable(hint: Any) -> bool:
    origin: Any = get_origin(hint)
    return origin is ClassVar


def _define(cls: type) -> type:
    made, fields = _made(cls)
    values = _getter([*fields.hints])
    compared = _getter(
        [
            name
            for name in fields.hints
            if getattr(fields.values.get(name), 'compare', True)
        ]
    )

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


def _first_initializer(made: Any, fields: _Fields) -> Any:
    """Return the initializer of the first objects, which is not compiled."""
    count = 0
    assign = object.__setattr__

    def initialize(self: Any, *args: Any, **kwargs: Any) -> None:
        nonlocal count
        count += 1
        given = dict(zip(fields.hints, args, strict=False)) | kwargs
        if count <= _FEW and len(given) == len(args) + len(kwargs):
            missing = dataclasses.MISSING
            for name in fields.hints:
                value = given.pop(name, missing)
                if value is missing:
                    value = _default(fields.values.get(name, missing))
                if value is missing:
                    break
                assign(self, name, value)
            else:
                if not given:
                    return
        # also for the errors that Python finds in arguments
        made.__init__ = _initializer(dataclasses.fields(made))
        made.__init__(self, *args, **kwargs)

    return initialize


def _default(value: Any) -> Any:
    if not isinstance(value, dataclasses.Field):
        return value
    if value.default_factory is not dataclasses.MISSING:
        return value.default_factory()
    return value.default


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
