# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Actions and substitutions of other packages in YAML and XML launch files.

ROS 2's own `launch` has to run them: the host of launch files in Python does.
"""

from collections.abc import Iterable
from collections.abc import Iterator
from collections.abc import Sequence
import re

from colcon_yamllaunch.language.evaluation.attributes import Attributes
from colcon_yamllaunch.language.evaluation.launch_worker import WorkerMessage
from colcon_yamllaunch.language.evaluation.values import AlreadyReportedError
from colcon_yamllaunch.language.evaluation.walk import Walk
from colcon_yamllaunch.language.python_files.python_visit import ask_worker
from colcon_yamllaunch.language.python_files.python_visit import (
    NotTakenOverError,
)
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.template import parse_template
from colcon_yamllaunch.language.syntax.template import Substitution
from colcon_yamllaunch.language.syntax.template import Template
from colcon_yamllaunch.language.syntax.template import TemplateSyntaxError
from colcon_yamllaunch.language.syntax.xml_scalar import is_xml
from colcon_yamllaunch.language.tree.text import Text
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.plan.position import Span

# the substitutions that name a package or a launch configuration, and which
# argument does
_NAMING = {
    'find-pkg-prefix': 0,
    'find-pkg-share': 0,
    'exec-in-pkg': 1,
    'var': 0,
}
# those that depend on where they are written, which the host does not know
# once an action has included another launch file
_LOCAL = ('dirname', 'filename', 'for-var', 'index')
_SPECIAL = re.compile(r'[\\$()"\']')


class NotAskedError(LaunchError):
    """The host cannot do it, or is not there."""


def do(walk: Walk, attributes: Attributes) -> None:
    """
    Let the host do an action.

    :raises NotAskedError: when the host cannot, or is not there
    :raises LaunchError: when the action fails
    """
    try:
        _do(walk, attributes)
    except (AlreadyReportedError, LaunchError):
        # what it would have set is not known
        walk.scope.configurations.is_open = True
        raise


def _do(walk: Walk, attributes: Attributes) -> None:
    raw, at = attributes.item.raw, attributes.position
    assert raw is not None
    what = f"the action '{raw.type}'"
    _need(walk, raw.package, what, attributes)
    _note_uses(walk, raw.texts)
    request = {
        'do': 'action',
        'entity': raw.message(lambda text: _prepared(walk, text, at)),
        'position': [at.path, at.line, at.column],
        'file': walk.source.name,
        'frontend': 'xml' if is_xml(walk.source) else 'yaml',
    }
    _ask(walk, request, attributes, what, raw.package)


def make(walk: Walk, name: str, texts: Sequence[str], at: Span) -> str | None:
    """
    Let the host make a substitution.

    :param texts: Its arguments
    :param at: Where it is written
    :raises NotAskedError: when the host cannot, or is not there
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
            text = (
                text[: substitution.start]
                + written
                + (text[substitution.end :])
            )
    return text


def _local(
    template: Template, *, is_inside: bool
) -> Iterator[tuple[Substitution, bool]]:
    """Find such substitutions, and say which are inside of others."""
    for part in template.parts:
        if isinstance(part, str):
            continue
        if part.name in _LOCAL:
            yield part, is_inside
            continue
        for argument in part.arguments:
            yield from _local(argument, is_inside=True)
