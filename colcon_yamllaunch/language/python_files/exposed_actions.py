# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Actions and substitutions of other packages in YAML and XML launch files.

ROS 2's own `launch` has to run them: the worker for Python launch files does.
"""

from collections.abc import Iterable, Iterator
from contextlib import suppress
import re
from typing import Any, TypeGuard

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.language.evaluation.attributes import Attributes
from colcon_yamllaunch.language.evaluation.request import (
    FindExposed,
    WorkerMessage,
)
from colcon_yamllaunch.language.evaluation.scope import AlreadyReportedError
from colcon_yamllaunch.language.evaluation.walk import Walk
from colcon_yamllaunch.language.python_files.python_visit import (
    ask_worker,
    NotTakenOverError,
)
from colcon_yamllaunch.language.syntax.diagnostics import error, LaunchError
from colcon_yamllaunch.language.syntax.text import (
    parse_template,
    Substitution,
    Template,
    TemplateSyntaxError,
    Text,
)
from colcon_yamllaunch.language.syntax.yaml_reader import (
    Mapping,
    Scalar,
    Sequence,
    Value,
)
from colcon_yamllaunch.plan.position import Position, Span

_CHILDREN = 'children'


@dataclass(frozen=True, slots=True)
class RawEntity:
    """
    An action of another package, with nothing evaluated.

    :param package: The package that has it
    :param message: The action as the worker takes it, see
      `python_launch/worker/channel.py`
    :param texts: Its texts as far as they are well-formed, those inside too
    """

    package: str
    message: dict[str, Any]
    texts: tuple[Text, ...]


def read_exposed(
    package: str, name: str, at: Position, value: Value, exposed: FindExposed
) -> RawEntity:
    """
    Read an action of another package.

    :param name: The name of the action
    :param at: Where it starts
    :param value: What stands behind its name
    :param exposed: Returns the substitutions of packages
    :raises LaunchError: when no attribute can be like that
    """
    texts: list[Text] = []
    message = _Reader(exposed, texts).read(name, at, value)
    return RawEntity(package, message, tuple(texts))


class _Reader:
    """
    Reads an action with all that is inside it.

    :param texts: The list to add its texts to
    """

    def __init__(self, exposed: FindExposed, texts: list[Text]) -> None:
        self._exposed = exposed
        self._texts = texts

    def read(self, name: str, at: Position, value: Value) -> dict[str, Any]:
        """Read an action, or an item of a list."""
        attributes: dict[str, Any] = {}
        children: Value | None = value if isinstance(value, Sequence) else None
        pairs = value.pairs if isinstance(value, Mapping) else {}
        if isinstance(value, Scalar) and value.kind != 'null':
            raise error(
                f"'{name}' has attributes or a list of actions, and no text",
                value.position,
                hint='write its attributes below it, indented deeper',
            )
        for key, (_, written) in pairs.items():
            if key == _CHILDREN:
                children = written
            else:
                attributes[key] = self._attribute(key, written)
        return {
            'type': name,
            'attributes': attributes,
            'texts': {
                key: written.text
                for key, (_, written) in pairs.items()
                if key != _CHILDREN and _is_of_yaml(written)
            },
            'children': None
            if children is None
            else list(self._children(name, children)),
            'position': [at.path, at.line, at.column],
        }

    def _attribute(self, name: str, value: Value) -> Any:
        if isinstance(value, Sequence):
            return [
                self._scalar(item)
                if isinstance(item, Scalar)
                else self.read(name, item.position, item)
                for item in value.items
            ]
        if not isinstance(value, Scalar):
            raise error(
                f"'{name}' cannot be a mapping",
                value.position,
                hint='quote a text that starts with {, or put "- " before '
                'each item of a list',
            )
        return self._scalar(value)

    def _scalar(self, value: Scalar) -> Any:
        is_null = value.kind == 'null' and not value.is_of_xml
        if is_null or _is_of_yaml(value):
            return value.value
        with suppress(LaunchError):
            # it may be a text that no substitutions are made in
            self._texts.append(Text(value, exposed=self._exposed))
        return value.text

    def _children(self, name: str, value: Value) -> Iterator[dict[str, Any]]:
        items = value.items if isinstance(value, Sequence) else [value]
        for item in items:
            if not isinstance(item, Mapping) or len(item.pairs) != 1:
                raise error(
                    f"what stands in '{name}' is a list of names with "
                    'attributes',
                    item.position,
                    hint='put "- " before each',
                )
            for inner, (key, attributes) in item.pairs.items():
                yield self.read(inner, key.position, attributes)


def _is_of_yaml(value: Value) -> TypeGuard[Scalar]:
    """Return whether YAML reads a value as something other than text."""
    return (
        isinstance(value, Scalar)
        and not value.is_of_xml
        and value.kind not in ('str', 'timestamp', 'null')
    )


# the substitutions that name a package or a launch configuration, and which
# argument does
_NAMING = {
    'find-pkg-prefix': 0,
    'find-pkg-share': 0,
    'exec-in-pkg': 1,
    'var': 0,
}
# those that depend on where they are written, which the worker does not know
# once an action has included another launch file
_LOCAL = ('dirname', 'filename', 'for-var', 'index')
_SPECIAL = re.compile(r'[\\$()"\']')


class NotAskedError(LaunchError):
    """The worker cannot do it, or is not there."""


def do(walk: Walk, attributes: Attributes) -> None:
    """
    Make the worker execute an action.

    :raises NotAskedError: when the worker cannot, or is not there
    :raises LaunchError: when the action fails
    """
    raw, at = attributes.item.raw, attributes.position
    assert raw is not None
    what = f"the action '{attributes.name}'"
    try:
        _need(walk, raw.package, what, attributes)
        _note_uses(walk, raw.texts)
        request = {
            'do': 'action',
            'entity': _prepared_entity(walk, raw.message, at),
            'position': [at.path, at.line, at.column],
            'file': walk.source.name,
            'frontend': 'xml' if walk.source.is_xml else 'yaml',
        }
        _ask(walk, request, attributes, what, raw.package)
    except (AlreadyReportedError, LaunchError):
        # what it would have set is not known
        walk.scope.configurations.is_open = True
        raise


def make(
    walk: Walk, name: str, texts: tuple[str, ...], at: Span
) -> str | None:
    """
    Make the worker evaluate a substitution.

    :param texts: Its arguments
    :param at: Where it is written
    :raises NotAskedError: when the worker cannot, or is not there
    :raises LaunchError: when the substitution fails
    """
    package, place = walk.exposed().substitution(name), at.position
    assert package is not None
    what = f"the substitution '{name}'"
    _need(walk, package, what, at)
    request = {
        'do': 'substitute',
        'name': name,
        'arguments': [*texts],
        'position': [place.path, place.line, place.column],
        'file': walk.source.name,
    }
    return _ask(walk, request, at, what, package)


def _ask(
    walk: Walk, request: WorkerMessage, at: Span, what: str, package: str
) -> str | None:
    try:
        return ask_worker(walk, request, at)
    except NotTakenOverError as e:
        if e.reason is not None:
            message = f'{what} cannot be a part of the plan: {e.reason}'
            hint = "run the launch file by 'ros2 launch'"
        else:
            message = (
                f"{what} of the package '{package}' is run by ROS 2's "
                "'launch', which is not among the Python packages of the "
                'environment'
            )
            hint = 'source a ROS 2 installation that has launch_ros'
        raise NotAskedError(*error(message, at, hint=hint).diagnostics) from e


def _need(walk: Walk, package: str, what: str, at: Span) -> None:
    walk.use_package(package, at.position)
    if not walk.exposed().is_installed(package):
        problem = error(
            f"the package '{package}', which has {what}, is not built, or "
            'does not install it',
            at,
            hint='build it; a package of ament_cmake installs its Python '
            'module by ament_python_install_package(${PROJECT_NAME})',
            may_pass_after_build=True,
        )
        raise NotAskedError(*problem.diagnostics)


def _note_uses(walk: Walk, texts: Iterable[Text]) -> None:
    """Note what texts read, and their packages, which are built before."""
    for text in texts:
        for substitution in text.template.substitutions():
            index = _NAMING.get(substitution.name)
            if index is None or index >= len(substitution.arguments):
                continue
            name = substitution.arguments[index].literal
            if substitution.name == 'var':
                walk.read.add(name or '')
            elif name is not None and walk.packages.prefix(name) is not None:
                at = text.position_at(substitution.start)
                walk.use_package(name, at)


def _prepared_entity(
    walk: Walk, entity: dict[str, Any], at: Position
) -> dict[str, Any]:
    def prepared(value: Any) -> Any:
        if isinstance(value, dict):
            return _prepared_entity(walk, value, at)
        if isinstance(value, list):
            return [prepared(item) for item in value]
        return _prepared(walk, value, at) if isinstance(value, str) else value

    attributes = {n: prepared(v) for n, v in entity['attributes'].items()}
    children = prepared(entity['children'])
    return {**entity, 'attributes': attributes, 'children': children}


def _prepared(walk: Walk, text: str, at: Position) -> str:
    """Make what depends on the place where a text is written."""
    if '$(' not in text:
        return text
    try:
        found = list(_local(parse_template(text), is_inside=False))
    except TemplateSyntaxError:
        return text
    for substitution, is_inside in reversed(found):
        value = walk.template(Template((substitution,)), lambda _: at).text
        # no argument of a substitution has a space, unless it is quoted
        if value is not None and not (is_inside and ' ' in value):
            written = _SPECIAL.sub(r'\\\g<0>', value)
            start, end = substitution.start, substitution.end
            text = text[:start] + written + text[end:]
    return text


def _local(
    template: Template, *, is_inside: bool
) -> Iterator[tuple[Substitution, bool]]:
    """Iterate over local substitutions, and whether each is inside another."""
    for part in template.parts:
        if isinstance(part, str):
            continue
        if part.name in _LOCAL:
            yield part, is_inside
            continue
        for argument in part.arguments:
            yield from _local(argument, is_inside=True)
