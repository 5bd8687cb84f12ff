# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The sections of a file with parameters, each for some nodes.

A node reads such a file itself; for a component, whoever loads it does.
"""

from collections.abc import Iterable
from collections.abc import Iterator
import math
import os
import stat
import sys

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.source_text import read_source
from colcon_yamllaunch.language.syntax.source_text import Source
from colcon_yamllaunch.language.syntax.yaml_reader import load_yaml
from colcon_yamllaunch.language.syntax.yaml_reader import Mapping
from colcon_yamllaunch.language.syntax.yaml_reader import read_yaml
from colcon_yamllaunch.language.syntax.yaml_reader import Scalar
from colcon_yamllaunch.language.syntax.yaml_reader import Sequence
from colcon_yamllaunch.language.syntax.yaml_reader import UnusableYamlError
from colcon_yamllaunch.language.vocabulary.parameter import Parameter
from colcon_yamllaunch.language.vocabulary.parameter import ParameterContent
from colcon_yamllaunch.language.vocabulary.parameter import ScalarValue
from colcon_yamllaunch.plan.plan import ParameterFile
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.plan.plan import SetParameter
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
        Say whether it is for a node.

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
        found = tuple(_flattened(document, '', start))
        sections = (Section(f'/{_EVERY_NODE}', found, start),)
    return ParameterSections(sections, warnings)


def uniform_list(
    values: Iterable[ScalarValue],
) -> tuple[ScalarValue, ...] | None:
    """
    Return values as a list of one type, None when they have several.

    Whole numbers among others become such, as ROS 2's launcher has it.
    """
    items = tuple(values)
    kinds = {type(item) for item in items}
    if kinds == {int, float}:
        return tuple(float(item) for item in items)
    return items if len(kinds) <= 1 else None


def _parts(name: str) -> list[str]:
    return [part for part in name.split('/') if part]


def _sections(
    value: object, outer: tuple[str, ...], at: Position
) -> Iterator[Section]:
    for name, position, inner in _pairs(value, at):
        if name == PARAMETERS:
            pattern = '/' + '/'.join(outer)
            parameters = tuple(_flattened(inner, '', position))
            yield Section(pattern, parameters, at)
        elif isinstance(inner, Mapping | dict):
            yield from _sections(inner, (*outer, *_parts(name)), position)


def _flattened(
    value: object, prefix: str, at: Position
) -> Iterator[Parameter]:
    for name, position, inner in _pairs(value, at):
        full_name = prefix + name
        if isinstance(inner, Mapping | dict):
            yield from _flattened(inner, f'{full_name}.', position)
        else:
            content = _content(inner, full_name, position)
            yield Parameter(full_name, content, position)


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
    found = uniform_list(_scalar(item, name, at) for item in items)
    if found is None:
        raise error(
            f"the list '{name}' has values of several types",
            at,
            hint='quote the values that are texts',
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
                yield from _as_written(values, '', at)


def _as_written(
    value: object, prefix: str, at: Position
) -> Iterator[SetParameter]:
    for name, position, inner in _pairs(value, at):
        if isinstance(inner, Mapping):
            yield from _as_written(inner, f'{prefix}{name}.', position)
        else:
            yield SetParameter(prefix + name, _shown(inner), position)


def _shown(value: object) -> str:
    if isinstance(value, Sequence):
        return f'[{", ".join(_shown(item) for item in value.items)}]'
    return value.text if isinstance(value, Scalar) else '{…}'
