# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The files with parameters that a launch file names."""

from collections.abc import Iterator
import math
import os
import stat
import sys

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.suggestions import did_you_mean
from colcon_yamllaunch.language.evaluation.attributes import Attributes
from colcon_yamllaunch.language.evaluation.findings import SectionUse
from colcon_yamllaunch.language.evaluation.scope import Value, ValuePlace
from colcon_yamllaunch.language.evaluation.walk import Walk
from colcon_yamllaunch.language.syntax.diagnostics import (
    Diagnostic,
    error,
    LaunchError,
)
from colcon_yamllaunch.language.syntax.source_text import read_source, Source
from colcon_yamllaunch.language.syntax.text import Text
from colcon_yamllaunch.language.syntax.yaml_reader import (
    load_yaml,
    Mapping,
    read_yaml,
    Scalar,
    Sequence,
    UnusableYamlError,
)
from colcon_yamllaunch.language.vocabulary.parameter import (
    Parameter,
    ParameterContent,
    ScalarValue,
)
from colcon_yamllaunch.plan.plan import ParameterFile, Process, SetParameter
from colcon_yamllaunch.plan.position import Position

#: What stands above the parameters of a section.
PARAMETERS = 'ros__parameters'

_EVERY_NODE = '**'
_ANY_PART = '*'


@dataclass(frozen=True, slots=True)
class Section:
    """
    The parameters for some nodes.

    :param pattern: The full name of a node, in whose parts `*` stands for any
      and `**` for any number of any
    :param parameters: The parameters, in the order of the file
    :param position: Where its name is written
    """

    pattern: str
    parameters: tuple[Parameter, ...]
    position: Position

    @property
    def is_exact(self) -> bool:
        """Whether it can be for one node only."""
        return _ANY_PART not in self.pattern

    def applies_to(self, node: str | None) -> bool:
        """
        Return whether the section applies to a node.

        :param node: The full name, None when the node names itself
        """
        parts = _parts(self.pattern)
        if node is None:
            return parts == [_EVERY_NODE]
        names = _parts(node)
        # how many parts of the name the parts of the pattern so far may take
        taken = {0}
        for part in parts:
            if part == _EVERY_NODE:
                taken = set(range(min(taken), len(names) + 1))
            else:
                taken = {
                    count + 1
                    for count in taken
                    if count < len(names) and part in (_ANY_PART, names[count])
                }
            if not taken:
                return False
        return len(names) in taken


@dataclass(frozen=True, slots=True)
class ParameterSections:
    """
    What a file with parameters says.

    :param sections: Its sections, in order
    :param warnings: What is no mistake in ROS 2, but hardly meant
    """

    sections: tuple[Section, ...]
    warnings: tuple[Diagnostic, ...] = ()

    def parameters_of(self, node: str | None) -> Iterator[Parameter]:
        """
        Iterate over the parameters for a node; the last of a name counts.

        What is for this node alone comes last, as in ROS 2's launcher.

        :param node: The full name, None when the node names itself
        """
        own = [s for s in self.sections if s.applies_to(node)]
        for section in sorted(own, key=lambda section: section.is_exact):
            yield from section.parameters


def read_sections(source: Source) -> ParameterSections:
    """
    Read a file with parameters as ROS 2's launcher does.

    A file without sections is for every node.

    :raises LaunchError: when it is no such file
    """
    document: object
    warnings: tuple[Diagnostic, ...] = ()
    start = source.position(0, 0)
    try:
        document = read_yaml(source)
    except LaunchError as e:
        try:
            document = load_yaml(source.text)
        except UnusableYamlError:
            raise e from None
        # PyYAML takes more, such as two keys of one name
        warnings = e.as_warning().diagnostics
    if document is None:
        return ParameterSections((), warnings)
    if not isinstance(document, Mapping | dict):
        raise error(
            'a parameter file is a mapping of nodes to parameters', start
        )
    sections = tuple(_sections(document, (), start))
    if not sections:
        found = _parameters(document, start)
        sections = (Section(f'/{_EVERY_NODE}', found, start),)
    return ParameterSections(sections, warnings)


def _parts(name: str) -> list[str]:
    return [part for part in name.split('/') if part]


def _sections(
    value: object, outer: tuple[str, ...], at: Position
) -> Iterator[Section]:
    for name, position, inner in _pairs(value, at):
        if name == PARAMETERS:
            pattern = '/' + '/'.join(outer)
            yield Section(pattern, _parameters(inner, position), at)
        elif isinstance(inner, Mapping | dict):
            yield from _sections(inner, (*outer, *_parts(name)), position)


def _parameters(value: object, at: Position) -> tuple[Parameter, ...]:
    return tuple(
        Parameter(name, _content(inner, name, position), position)
        for name, position, inner in _leaves(value, '', at)
    )


def _leaves(
    value: object, prefix: str, at: Position
) -> Iterator[tuple[str, Position, object]]:
    """Iterate over the full names, places and values in nested mappings."""
    for name, position, inner in _pairs(value, at):
        if isinstance(inner, Mapping | dict):
            yield from _leaves(inner, f'{prefix}{name}.', position)
        else:
            yield prefix + name, position, inner


def _pairs(
    value: object, at: Position
) -> Iterator[tuple[str, Position, object]]:
    if isinstance(value, Mapping):
        for name, (key, inner) in value.pairs.items():
            yield name, key.position, inner
    elif isinstance(value, dict):
        for key, inner in value.items():
            yield str(key), at, inner


def _content(value: object, name: str, at: Position) -> ParameterContent:
    items = value.items if isinstance(value, Sequence) else value
    if not isinstance(items, list):
        return _scalar(items, name, at)
    found = tuple(_scalar(item, name, at) for item in items)
    kinds = {type(item) for item in found}
    if kinds == {int, float}:
        # as ROS 2's launcher has it
        return tuple(float(item) for item in found)
    if len(kinds) > 1:
        raise error(
            f"the list '{name}' has values of several types",
            at,
            hint='quote all of them if one is a text',
        )
    return found


def _scalar(value: object, name: str, at: Position) -> ScalarValue:
    if isinstance(value, Scalar):
        is_date = value.kind == 'timestamp'
        value = None if is_date else value.value
    if isinstance(value, str | int | float | bool):
        return value
    raise error(
        f"the parameter '{name}' is nothing that a parameter can be",
        at,
        hint='quote it if it is a text',
    )


def parameters_of(
    process: Process, limit: float = math.inf
) -> Iterator[SetParameter]:
    """
    Iterate over all parameters in the order of the command line.

    :param limit: Bytes of files that are read at most. Larger ones, and what
      is no ordinary file, are passed over
    """
    given = {f'{p.name}:={p.value}': p for p in process.parameters}
    arguments = zip(process.argv, process.argv[1:], strict=False)
    for option, value in arguments:
        if option == '-p' and isinstance(value, str) and value in given:
            yield given[value]
        elif option == '--params-file' and isinstance(value, str):
            size = _size_of(os.path.join(process.cwd, value))
            if size <= limit:
                limit -= size
                yield from _parameters_in_file(value, process.cwd)
        elif isinstance(value, ParameterFile):
            yield from value.parameters


def _size_of(path: str) -> int:
    """Return the bytes of a file, very many for what may have no end."""
    try:
        status = os.stat(path)
    except (OSError, ValueError):
        return 0
    return status.st_size if stat.S_ISREG(status.st_mode) else sys.maxsize


def _parameters_in_file(path: str, cwd: str) -> Iterator[SetParameter]:
    """
    Iterate over the parameters in a file, none if it is no parameter file.

    :param cwd: The folder that a relative path starts from
    """
    absolute = path if path.startswith('/') else f'{cwd}/{path}'
    try:
        document = read_yaml(read_source(absolute, absolute))
    except LaunchError:
        return
    start = Position(absolute, 1, 1)
    for _, at, body in _pairs(document, start):
        for name, _, values in _pairs(body, at):
            if name == PARAMETERS:
                for full_name, position, value in _leaves(values, '', at):
                    yield SetParameter(full_name, _shown(value), position)


def _shown(value: object) -> str:
    if isinstance(value, Sequence):
        return f'[{", ".join(_shown(item) for item in value.items)}]'
    return value.text if isinstance(value, Scalar) else '{…}'


def file_of(
    walk: Walk, entry: Attributes, *, needed: bool = False
) -> str | ParameterFile | None:
    """
    Return the file of an item of `param`, None when it is not known.

    :param needed: Whether the launch cannot go on without it
    """
    text, written = entry.item.texts['from'], entry.text('from')
    file = None
    if written is not None:
        path = os.path.join(walk.cwd, written)
        file = walk.parameter_file(path)
        if file is None and needed:
            missing_file(walk, entry, 'from', path)
        elif file is None:
            walk.report(
                error(
                    f"the parameter file '{written}' does not exist; it is "
                    'skipped',
                    text,
                    hint=similar_file(walk, written),
                    may_pass_after_build=walk.packages.may_appear(path),
                ).as_warning()
            )
    has_substitutions = entry.boolean('allow_substs')
    if has_substitutions is False:
        return None if file is None else written
    if file is None or has_substitutions is None:
        walk.note_text(None)
        return None
    content = _substituted(walk, file, text)
    return None if content is None else ParameterFile(content)


def missing_file(
    walk: Walk, attributes: Attributes, name: str, path: str
) -> None:
    """
    Report that a parameter file does not exist.

    :param name: The attribute that names it
    :param path: The path that it means
    """
    written = attributes.text(name) or ''
    may_appear = walk.packages.may_appear(path)
    attributes.fail(
        name,
        f"the parameter file '{written}' does not exist",
        similar_file(walk, written),
        is_certain=not may_appear,
        may_pass_after_build=may_appear,
    )


def similar_file(walk: Walk, written: str) -> str | None:
    """Return what may be meant by a parameter file that is not there."""
    path = walk.absolute(written)
    return walk.packages.rule_for(path) or did_you_mean(
        os.path.basename(written), walk.packages.similar(path)
    )


def note_sections_of_scope(walk: Walk, node: Value | None) -> None:
    """Record the parameter files that a node gets from its scope."""
    for path in walk.scope.parameters:
        if isinstance(path, str):
            place = walk.file_places[path]
            note_sections(walk, path, place, node, is_own=False)


def note_sections(
    walk: Walk,
    path: str,
    place: ValuePlace,
    node: Value | None,
    *,
    is_own: bool,
) -> None:
    """
    Record that a node gets a parameter file; see :class:`SectionUse`.

    :param node: The full name of the node, None when it names itself
    """
    if walk.never:
        return
    try:
        sections = sections_in(walk, path).sections
    except LaunchError:
        # who reads it says so
        return
    name = node.text if node is not None and node.is_sure else None
    walk.section_uses.append(SectionUse(path, sections, name, place, is_own))


def sections_in(walk: Walk, path: str) -> ParameterSections:
    """
    Return what a file with parameters says.

    :raises LaunchError: when it cannot be read, or is no such file
    """
    read = walk.parameter_sections.get(path)
    if read is None:
        located = walk.parameter_file(path) or path
        read = read_sections(read_source(located, path))
        walk.parameter_sections[path] = read
    return read


def _substituted(walk: Walk, path: str, origin: Text) -> str | None:
    content = None
    with walk.within_text(origin):
        source = read_source(path, path)
        end = source.position_at(len(source.text))
        scalar = Scalar(source, 0, 0, source.text, '', None, (end.line, 0))
        text = Text(scalar, exposed=walk.exposed)
        walk.inputs[path] = None
        walk.note_text(text.template)
        content = walk.value(text).text
    if content is None:
        return None
    try:
        loaded = load_yaml(content)
    except UnusableYamlError as e:
        loaded = None
        reason = str(e)
    else:
        reason = 'it has no mapping of nodes to parameters'
    if not isinstance(loaded, dict):
        walk.fail(
            error(
                f"the parameter file '{os.path.basename(path)}' is no "
                f'parameter file once its substitutions are made: {reason}',
                origin,
                hint='it is a YAML mapping of nodes to parameters',
            )
        )
    return content
