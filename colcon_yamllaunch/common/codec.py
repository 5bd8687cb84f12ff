# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Dataclasses to JSON and back.

A dataclass becomes an object with the names of its fields, in their order; a
named tuple, tuple or set becomes a list. Reading is strict, as the data may
come from another machine: each value must have the annotated type, and
:class:`CodecError` names the field that has not.

The functions that write and read a class are made when its first object is
written or read.
"""

from collections.abc import Callable, Iterable, Mapping
import dataclasses
from functools import partial
from itertools import repeat
import math
import re
import types
import typing
from typing import Any, TypeVar

#: Writes a value.
Write = Callable[[Any], Any]
#: Reads a value; raises :class:`CodecError` when it cannot.
Read = Callable[[Any], Any]

_T = TypeVar('_T')
_JSON_NAMES: dict[type[Any], str] = {dict: 'an object', list: 'a list'}
#: What no whole number may exceed (64 bits with a sign).
_LARGEST = (1 << 63) - 1
_SHOWN_NAME = 60
_MAPPINGS = (dict, Mapping)
_UNIONS = (typing.Union, types.UnionType)


class CodecError(ValueError):
    """
    Data does not have the form of a type.

    :param problem: What is wrong, such as `is not a list`
    :param path: The field, such as `.entries[0].label`
    """

    def __init__(self, problem: str, path: str = '') -> None:
        super().__init__(problem, path)
        self.problem = problem
        self.path = path

    def __str__(self) -> str:
        return f'{self.path.lstrip(".") or "it"} {self.problem}'

    def within(self, path: str) -> 'CodecError':
        """Return the same error for a field below `path`."""
        return CodecError(self.problem, path + self.path)


class Codec:
    """
    One JSON format.

    :param tags: The names of dataclasses of which one of several is written;
      an object has it under `tag`
    :param tag: The name of that field
    :param special: How values of some types are written and read; None where
      they are written as they are
    :param accept_unknown: Whether to ignore fields that a class does not
      have, such as those of a later version
    """

    def __init__(
        self,
        tags: Mapping[type, str] | None = None,
        *,
        tag: str = 'type',
        special: Mapping[Any, tuple[Write | None, Read]] | None = None,
        accept_unknown: bool = False,
    ) -> None:
        self._tags = tags or {}
        self._tag = tag
        self._special = special or {}
        self._accept_unknown = accept_unknown
        self._writers: dict[Any, Write] = {}
        self._readers: dict[Any, Read] = {}

    def to_json(self, value: Any, kind: Any = None) -> Any:
        """
        Return `value` for :func:`json.dumps`.

        :param kind: Its type; None for a dataclass or named tuple
        """
        return self._writer(kind or type(value))(value)

    def from_json(self, kind: type[_T], data: object, where: str = '') -> _T:
        """
        Return the value that `data` stands for.

        :param kind: Its type: a dataclass, or a union of tagged ones
        :param where: What to call it in errors, such as `plan`
        :raises CodecError: when the data is not of that type
        """
        try:
            value: _T = self._reader(kind)(data)
        except CodecError as e:
            raise e.within(where) from None
        except RecursionError as e:
            raise CodecError('is nested too deeply', where) from e
        return value

    def _writer(self, hint: Any) -> Write:
        if hint not in self._writers:
            # a field of a class may be of that class again
            self._writers[hint] = lambda value: self._writers[hint](value)
            self._writers[hint] = self._make_writer(hint)
        return self._writers[hint]

    def _make_writer(self, hint: Any) -> Write:
        if hint in self._special:
            return self._special[hint][0] or _same
        arguments = typing.get_args(hint)
        origin = typing.get_origin(hint) or hint
        if dataclasses.is_dataclass(hint):
            return self._object_writer(hint)
        if origin in _UNIONS:
            return self._union_writer(arguments)
        if origin is typing.Literal:
            return _same
        if origin is frozenset:
            return sorted
        if items := _item_types(hint):
            writers = [self._writer(item) for item in items]
            return lambda value: [
                write(one) for write, one in zip(writers, value, strict=True)
            ]
        if origin in _MAPPINGS:
            write = self._writer(arguments[1] if arguments else Any)
            return lambda value: {k: write(v) for k, v in value.items()}
        if origin in (tuple, list):
            write = self._writer(arguments[0] if arguments else Any)
            return lambda value: [write(one) for one in value]
        return _same

    def _object_writer(self, kind: Any) -> Write:
        start = {self._tag: self._tags[kind]} if kind in self._tags else {}
        writers = [
            (field.name, field.name.rstrip('_'), self._writer(hint))
            for field, hint in _fields(kind)
        ]
        return lambda value: (
            start
            | {
                key: write(getattr(value, name))
                for name, key, write in writers
            }
        )

    def _union_writer(self, hints: tuple[Any, ...]) -> Write:
        writers = {
            typing.get_origin(hint) or hint: write
            for hint in hints
            if (write := self._writer(hint)) is not _same
        }

        def write_one(value: Any) -> Any:
            for kind, write in writers.items():
                if isinstance(value, kind):
                    return write(value)
            return value

        return write_one if writers else _same

    def _reader(self, hint: Any) -> Read:
        if hint not in self._readers:
            self._readers[hint] = lambda data: self._readers[hint](data)
            self._readers[hint] = self._make_reader(hint)
        return self._readers[hint]

    def _make_reader(self, hint: Any) -> Read:
        if hint in self._special:
            return self._special[hint][1]
        arguments = typing.get_args(hint)
        origin = typing.get_origin(hint) or hint
        if dataclasses.is_dataclass(hint):
            return self._object_reader(hint)
        if origin in _UNIONS:
            return self._union_reader(arguments)
        if origin is typing.Literal:
            return _literal_reader(arguments)
        if origin in _MAPPINGS:
            return self._mapping_reader(arguments)
        items = _item_types(hint)
        if items or origin in (tuple, list, frozenset):
            return self._list_reader(origin, items, arguments)
        if hint in (Any, object):
            return _same
        if hint in (str, bool, types.NoneType):
            return partial(only, hint)
        if hint in (float, int):
            return read_float if hint is float else _read_int
        raise TypeError(f'{hint} has no form in JSON')

    def _object_reader(self, kind: Any) -> Read:
        fields = {
            field.name.rstrip('_'): (
                field.name,
                self._reader(hint),
                field.default is dataclasses.MISSING
                and field.default_factory is dataclasses.MISSING,
            )
            for field, hint in _fields(kind)
        }
        known = {*fields, self._tag} if kind in self._tags else {*fields}

        def read_object(data: Any) -> Any:
            data = only(dict, data)
            if not (self._accept_unknown or data.keys() <= known):
                name = min(data.keys() - known)
                raise CodecError(f"has an unknown field '{_shown(name)}'")
            values = {}
            try:
                for key, (name, read, is_required) in fields.items():
                    if key in data:
                        values[name] = read(data[key])
                    elif is_required:
                        raise CodecError('is missing')
            except CodecError as e:
                raise e.within(f'.{key}') from None
            return kind(**values)

        return read_object

    def _union_reader(self, hints: tuple[Any, ...]) -> Read:
        tagged = {
            self._tags[hint]: self._reader(hint)
            for hint in hints
            if hint in self._tags
        }
        others: dict[type, Read] = {}
        for hint in hints:
            for kind in () if hint in self._tags else _json_types(hint):
                if kind in others and kind in _JSON_NAMES:
                    raise TypeError(f'{hint} is one of several: give tags')
                others.setdefault(kind, self._reader(hint))
        rest = [h for h in hints if h is not types.NoneType]
        only_one = self._reader(rest[0]) if len(rest) == 1 else None
        names = ' or '.join(map(_name, rest))

        def read_one(data: Any) -> Any:
            read = only_one
            if data is None:
                read = others.get(types.NoneType, read)
            elif only_one is None:
                tag = data.get(self._tag) if isinstance(data, dict) else None
                read = tagged.get(tag) if isinstance(tag, str) else None
                read = read or others.get(type(data))
            if read is None:
                raise CodecError(f'is not {names}')
            return read(data)

        return read_one

    def _mapping_reader(self, arguments: tuple[Any, ...]) -> Read:
        read = self._reader(arguments[1] if arguments else Any)

        def read_mapping(data: Any) -> Any:
            found = {}
            data = only(dict, data)
            try:
                for name, one in data.items():
                    found[name] = read(one)
            except CodecError as e:
                raise e.within(f'.{_shown(name)}') from None
            return found

        return read_mapping

    def _list_reader(
        self, kind: Any, items: tuple[Any, ...], arguments: tuple[Any, ...]
    ) -> Read:
        """
        Return what reads a list.

        :param items: The types of a named tuple, or of a tuple of a fixed
          length; else all are of the first type of the arguments
        """
        readers: Iterable[Read] = [self._reader(hint) for hint in items]
        required = len(items) - len(getattr(kind, '_field_defaults', ()))
        if not items:
            readers = repeat(self._reader(arguments[0] if arguments else Any))

        def read_list(data: Any) -> Any:
            found: list[Any] = []
            data = only(list, data)
            if items and not required <= len(data) <= len(items):
                raise CodecError(f'does not have {len(items)} values')
            try:
                for read, one in zip(readers, data, strict=False):
                    found.append(read(one))
            except CodecError as e:
                raise e.within(f'[{len(found)}]') from None
            return kind(*found) if hasattr(kind, '_fields') else kind(found)

        return read_list


def only(kind: type[_T], data: Any) -> _T:
    """
    Return `data` if it is of a type of JSON.

    :raises CodecError: when it is not; True is not a number
    """
    if type(data) is not kind:
        name = _JSON_NAMES.get(kind, f'of the type {kind.__name__}')
        raise CodecError(f'is not {name}')
    return data


def read_float(data: Any) -> float:
    """
    Return a number as a float.

    :raises CodecError: when it is none, or not finite
    """
    if type(data) not in (int, float):
        raise CodecError('is not of the type float')
    try:
        value = float(data)
    except OverflowError:
        value = math.inf
    if not math.isfinite(value):
        raise CodecError('is not a finite number')
    return value


def _read_int(data: Any) -> int:
    number = only(int, data)
    if abs(number) > _LARGEST:
        raise CodecError('is too large a number')
    return number


def _same(value: Any) -> Any:
    return value


def _literal_reader(values: tuple[Any, ...]) -> Read:
    def read_literal(data: Any) -> Any:
        # True equals 1, and lists have no hash
        if any(data == v and type(data) is type(v) for v in values):
            return data
        raise CodecError(f'is not {" or ".join(map(repr, values))}')

    return read_literal


def _fields(kind: Any) -> list[tuple[dataclasses.Field[Any], Any]]:
    hints = typing.get_type_hints(kind)
    return [(field, hints[field.name]) for field in dataclasses.fields(kind)]


def _item_types(hint: Any) -> tuple[Any, ...]:
    """Return the types in a named tuple or a tuple of a fixed length."""
    if hasattr(hint, '_field_defaults'):
        return tuple(typing.get_type_hints(hint).values())
    arguments = typing.get_args(hint)
    is_fixed = typing.get_origin(hint) is tuple and ... not in arguments
    return arguments if is_fixed else ()


def _json_types(hint: Any) -> tuple[type, ...]:
    """Return the types that JSON may have for a type."""
    origin = typing.get_origin(hint) or hint
    if origin is typing.Literal:
        return tuple({type(value) for value in typing.get_args(hint)})
    if dataclasses.is_dataclass(hint) or origin in _MAPPINGS:
        return (dict,)
    if isinstance(origin, type) and issubclass(
        origin, tuple | list | frozenset
    ):
        return (list,)
    return (int, float) if hint is float else (hint,)


def _name(hint: Any) -> str:
    name = getattr(hint, '__name__', str(hint))
    words = re.sub('(?<!^)([A-Z])', r' \1', name).lower()
    return f'a {words}'


def _shown(name: str) -> str:
    """Return the name of a field that others chose, fit for a message."""
    from colcon_yamllaunch.common.printable import one_line

    return one_line(name[:_SHOWN_NAME])


_STRICT = Codec()
#: Returns a value of untagged dataclasses for :func:`json.dumps`.
to_json = _STRICT.to_json
#: Reads what `to_json` wrote, see :meth:`Codec.from_json`.
from_json = _STRICT.from_json
