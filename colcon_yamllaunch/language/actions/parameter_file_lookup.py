# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The files with parameters that a launch file names."""

import os

from colcon_yamllaunch.common.suggestions import did_you_mean
from colcon_yamllaunch.language.evaluation.attributes import Attributes
from colcon_yamllaunch.language.evaluation.findings import SectionUse
from colcon_yamllaunch.language.evaluation.request import FindExposed
from colcon_yamllaunch.language.evaluation.values import Place
from colcon_yamllaunch.language.evaluation.values import Value
from colcon_yamllaunch.language.evaluation.walk import Walk
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.source_text import read_source
from colcon_yamllaunch.language.syntax.text import Text
from colcon_yamllaunch.language.syntax.yaml_reader import load_yaml
from colcon_yamllaunch.language.syntax.yaml_reader import Scalar
from colcon_yamllaunch.language.syntax.yaml_reader import UnusableYamlError
from colcon_yamllaunch.language.vocabulary.parameter_sections import (
    ParameterSections,
)
from colcon_yamllaunch.language.vocabulary.parameter_sections import (
    read_sections,
)
from colcon_yamllaunch.plan.plan import ParameterFile


def file_of(
    walk: Walk, entry: Attributes, *, is_needed: bool = False
) -> str | ParameterFile | None:
    """
    Return the file of an item of `param`, None when it is not known.

    :param is_needed: Whether the launch cannot go on without it
    """
    text, written = entry.item.texts['from'], entry.text('from')
    file = None
    if written is not None:
        path = os.path.join(walk.cwd, written)
        file = walk.parameter_file(path)
        if file is None and is_needed:
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
    Say that there is no such file with parameters.

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


def note_sections(
    walk: Walk, written: str, entry: Attributes, node: Value | None
) -> None:
    """
    Take note that a node is given a file with parameters.

    :param written: The file
    :param entry: The item of `param` that names it
    :param node: The full name of the node, None when it names itself
    """
    path = os.path.join(walk.cwd, written)
    place = walk.place_of(entry.item.texts['from'])
    _note(walk, path, place, node, is_own=True)


def note_sections_of_scope(walk: Walk, node: Value | None) -> None:
    """Take note of the files that a node is given with all of its scope."""
    for path in walk.scope.parameters:
        if isinstance(path, str):
            _note(walk, path, walk.file_places[path], node, is_own=False)


def _note(
    walk: Walk, path: str, place: Place, node: Value | None, *, is_own: bool
) -> None:
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
        text = whole_file(path, walk.exposed)
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


def whole_file(path: str, exposed: FindExposed) -> Text:
    """
    Return the content of a file with substitutions in it.

    :param exposed: Gives the substitutions that packages bring
    :raises LaunchError: when it cannot be read, or one of them is malformed
    """
    source = read_source(path, path)
    end = source.position_at(len(source.text))
    scalar = Scalar(source, 0, 0, source.text, '', None, (end.line, 0))
    return Text(scalar, exposed=exposed)
