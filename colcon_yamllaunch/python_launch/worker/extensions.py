# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Actions and substitutions of other packages in YAML and XML files.

The launcher has read the file; here its entities are what the packages get
from `launch_yaml` and `launch_xml` (`Entity` of each), which need not be
there.
"""

from __future__ import annotations

from difflib import get_close_matches
import importlib
import importlib.metadata
import sys
from typing import Any, TYPE_CHECKING

from .channel import Json
from .errors import described, did_you_mean, note_entity, PlainError

if TYPE_CHECKING:
    from .visit import Visitor


# as packages may expect them of `launch_yaml` and `launch_xml`
class _MissingError(PlainError, AttributeError):
    """An attribute is not there."""


class _TypeError(PlainError, TypeError):
    """An attribute is of another type."""


class _ValueError(PlainError, ValueError):
    """Something is there that the action does not know, or is lacking."""


class _Entity:
    """
    An action, or an item of one of its lists.

    :param written: What the protocol has of it
    """

    def __init__(self, written: Json) -> None:
        self.position = written['position']
        self._attributes: Json = written['attributes']
        self._children: list[Json] | None = written['children']
        self._type: str = written['type']
        #: The attributes that were asked for.
        self._asked: set[str] = set()

    @property
    def type_name(self) -> str:
        """Return the name of the action or list."""
        return self._type

    @property
    def parent(self) -> None:
        """Return nothing, as those of YAML and XML do."""
        return

    def get_attr(
        self,
        name: str,
        *,
        data_type: Any = str,
        optional: bool = False,
        can_be_str: bool = True,
    ) -> Any:
        """Return an attribute; see `launch.frontend.Entity.get_attr`."""
        types: Any = importlib.import_module('launch.frontend.type_utils')
        is_of_entities = types.check_is_list_entity(data_type)
        if is_of_entities:
            value = self._items(name)
        else:
            self._asked.add(name)
            value = self._attributes.get(name)
        if value is None:
            if not optional:
                raise self._missing(name)
            return None if is_of_entities else _left_out(name)
        if is_of_entities:
            return [type(self)(item) for item in value]
        return self._typed(name, value, data_type, can_be_str)

    def _items(self, name: str) -> Any:
        """Return what is written of a list of mappings, None for nothing."""
        raise NotImplementedError

    def _typed(
        self, name: str, value: Any, data_type: Any, can_be_str: bool
    ) -> Any:
        """Return an attribute as the type that an action wants."""
        raise NotImplementedError

    def _wrong(self, kind: Any, message: str) -> Any:
        """Return an error about it."""
        return kind(message, self.position, len(self._type))

    def _missing(self, name: str) -> Any:
        """Return the error that an attribute is not there."""
        message = f"'{self._type}' needs the attribute '{name}'"
        near = get_close_matches(name, set(self._attributes) - self._asked, 1)
        if near:
            message += f"; is '{near[0]}' meant for it?"
        return self._wrong(_MissingError, message)

    def _unknown(self, what: str, names: set[str]) -> None:
        """
        Refuse what the action does not ask for.

        :raises ValueError: when there are any
        """
        for name in sorted(names):
            message = f"'{self._type}' has no {what} '{name}'"
            known = sorted(self._asked - set(self._attributes))
            if hint := did_you_mean(name, known):
                message += f'; {hint}'
            elif known:
                message += f'; there are {", ".join(known)}'
            raise self._wrong(_ValueError, message)


class _YamlEntity(_Entity):
    """What `launch_yaml` gives: values have the types that YAML has."""

    def __init__(self, written: Json) -> None:
        super().__init__(written)
        self._asked_for_children = False
        self._texts: Json = written['texts']

    @property
    def children(self) -> list[Any]:
        """Return the actions inside."""
        self._asked_for_children = True
        if self._children is None:
            raise self._wrong(
                _ValueError,
                f"'{self._type}' needs actions inside: a list, or 'children' "
                'with one',
            )
        return [type(self)(child) for child in self._children]

    def assert_entity_completely_parsed(self) -> None:
        """Refuse what the action did not ask for."""
        self._unknown('attribute', set(self._attributes) - self._asked)
        if self._children is not None and not self._asked_for_children:
            raise self._wrong(
                _ValueError, f"no actions stand inside of '{self._type}'"
            )

    def _items(self, name: str) -> Any:
        self._asked.add(name)
        value = self._attributes.get(name)
        if value is not None and not (
            isinstance(value, list) and all(isinstance(v, dict) for v in value)
        ):
            raise self._wrong(
                _TypeError, f"'{name}' of '{self._type}' is a list of mappings"
            )
        return value

    def _typed(
        self, name: str, value: Any, data_type: Any, can_be_str: bool
    ) -> Any:
        if data_type is str and name in self._texts:
            # as with the other actions, whatever YAML takes a text for
            return self._texts[name]
        utilities: Any = importlib.import_module('launch.utilities.type_utils')
        if not utilities.is_instance_of(
            value, data_type, can_be_str=can_be_str
        ):
            raise self._wrong(
                _TypeError,
                f"'{name}' of '{self._type}' wants {_shown(data_type)}, not "
                f'{_shown(type(value))}',
            )
        return value


class _XmlEntity(_Entity):
    """What `launch_xml` gives: texts become what the action wants."""

    def __init__(self, written: Json) -> None:
        super().__init__(written)
        self._read: set[str] = set()

    @property
    def children(self) -> list[Any]:
        """Return all elements inside."""
        self._read.update(child['type'] for child in self._children or ())
        return [type(self)(child) for child in self._children or ()]

    def assert_entity_completely_parsed(self) -> None:
        """Refuse what the action did not ask for."""
        elements = {child['type'] for child in self._children or ()}
        self._unknown('element', elements - self._read)
        self._unknown('attribute', set(self._attributes) - self._asked)

    def _items(self, name: str) -> Any:
        self._read.add(name)
        return [c for c in self._children or () if c['type'] == name] or None

    def _typed(
        self, name: str, value: Any, data_type: Any, can_be_str: bool
    ) -> Any:
        separator = f'{name}-sep'
        if separator in self._attributes:
            self._asked.add(separator)
            value = value.split(self._attributes[separator])
        utilities: Any = importlib.import_module('launch.utilities.type_utils')
        try:
            return utilities.get_typed_value(
                value, data_type, can_be_str=can_be_str
            )
        except ValueError:
            raise self._wrong(
                _TypeError,
                f"'{name}' of '{self._type}' wants {_shown(data_type)}, and "
                f"'{value}' is none",
            ) from None


#: The entry points of the actions of other packages.
_GROUP = 'launch.frontend.launch_extension'
_ENTITIES = {'yaml': _YamlEntity, 'xml': _XmlEntity}


class Extensions:
    """
    Does what other packages expose to YAML and XML files.

    :param visitor: Visits what comes of it
    """

    def __init__(self, visitor: Visitor) -> None:
        self._visitor = visitor
        self._parser: Any = None
        # the extensions that could not be imported, and why
        self._failures: dict[str, Exception] = {}
        # what was made: with it, packages remove the files that it names
        self._made: list[object] = []
        visitor.requests['action'] = self.act
        visitor.requests['substitute'] = self.make

    def act(self, request: Json) -> None:
        """Do an action, with what it starts and includes."""
        visitor = self._visitor
        visitor.positions.otherwise = request['position']
        parser = self._loaded()
        frontend = importlib.import_module('launch.frontend')
        # packages may ask whether it is one
        bases = _ENTITIES[request['frontend']], frontend.Entity
        kind: Any = type('Entity', bases, {})
        action = parser.parse_action(kind(request['entity']))
        self._made.append(action)
        visitor.within_file(request['file'], action)

    def make(self, request: Json) -> None:
        """Make a substitution, and tell its value."""
        visitor, name = self._visitor, request['name']
        visitor.positions.otherwise = request['position']
        self._loaded()
        expose: Any = importlib.import_module('launch.frontend.expose')
        known, at = expose.substitution_parse_methods, request['position']
        self._need(name, known, 'substitution', at)
        substitutions = importlib.import_module('launch.substitutions')
        arguments = [
            [substitutions.TextSubstitution(text=text)]
            for text in request['arguments']
        ]
        made = expose.instantiate_substitution(name, arguments)
        self._made.append(made)
        visitor.positions.put(made, at)
        try:
            with visitor.file(request['file']):
                value = made.perform(visitor.context)
        except Exception as e:
            note_entity(e, made)
            raise
        visitor.say('value', text=str(value))

    def _loaded(self) -> Any:
        """Return a parser, with all extensions imported."""
        if self._parser is None:
            frontend = importlib.import_module('launch.frontend')
            self._load(frontend)
            methods = {'parse_action': self._parse_action}
            self._parser = type('Parser', (frontend.Parser,), methods)()
        return self._parser

    def _parse_action(self, entity: Any) -> Any:
        expose: Any = importlib.import_module('launch.frontend.expose')
        try:
            name, known = entity.type_name, expose.action_parse_methods
            self._need(name, known, 'action', entity.position)
            action = expose.instantiate_action(entity, self._parser)
        except Exception as e:
            self._visitor.positions.put(entity, entity.position)
            note_entity(e, entity)
            raise
        # not where its package makes it
        self._visitor.positions.put(action, entity.position)
        return action

    def _need(
        self, name: str, known: Any, what: str, position: list[object]
    ) -> None:
        """
        Check that a name is there.

        :raises PlainError: when it is not
        """
        if name in known:
            return
        message = f"no package here has the {what} '{name}'"
        for extension, failure in self._failures.items():
            message += f'; {_not_imported(extension, failure)}'
            error = PlainError(message)
            # where it fails
            raise error.with_traceback(failure.__traceback__)
        raise PlainError(message, position, len(name))

    def _load(self, frontend: Any) -> None:
        """Import all extensions, as `Parser.load_launch_extensions` does."""
        found: Any = importlib.metadata.entry_points()
        if hasattr(found, 'select'):
            found = found.select(group=_GROUP)
        else:
            found = found.get(_GROUP, ())
        for entry in found:
            try:
                entry.load()
            except Exception as e:  # noqa: BLE001 - it may be anyone's
                self._failures[entry.name] = e
        frontend.Parser.extensions_loaded = True
        for name, failure in self._failures.items():
            visitor = self._visitor
            frames = described(failure, visitor.positions, visitor.packages)
            places = [frame['position'] for frame in frames['frames']]
            visitor.say(
                'warning',
                text=_not_imported(name, failure),
                position=places[-1] if places else visitor.position(),
            )


def _not_imported(name: str, failure: Exception) -> str:
    reason = f'{type(failure).__name__}: {failure}'.partition('\n')[0]
    return f"the launch extension '{name}' cannot be imported: {reason}"


def _left_out(name: str) -> str | None:
    """Return what an attribute is that is left out, None for nothing."""
    asking = sys._getframe(2).f_globals.get('__name__', '')
    # as with the other processes of YAML and XML files, output is shown
    is_of_process = name == 'output' and asking.startswith('launch.actions.')
    return 'both' if is_of_process else None


def _shown(data_type: Any) -> str:
    name = getattr(data_type, '__name__', None)
    return {
        'str': 'a text',
        'bool': 'a boolean',
        'int': 'a whole number',
        'float': 'a number with a decimal point',
        'list': 'a list',
        'NoneType': 'nothing',
    }.get(name or '', str(data_type).replace('typing.', ''))
