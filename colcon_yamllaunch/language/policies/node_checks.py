# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Names of nodes that fit together only once all nodes are known."""

import os

from colcon_yamllaunch.common.suggestions import did_you_mean
from colcon_yamllaunch.common.suggestions import listing
from colcon_yamllaunch.language.evaluation.findings import Findings
from colcon_yamllaunch.language.evaluation.findings import SectionUse
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.vocabulary.parameter_sections import Section


def warn_of_missing_containers(findings: Findings) -> None:
    """Warn of components whose container no node of the launch is."""
    if findings.may_have_others:
        return
    for wanted in findings.targets:
        if wanted.name in findings.nodes:
            continue
        last = wanted.name.rpartition('/')[2]
        same = [n for n in findings.nodes if n.rpartition('/')[2] == last]
        hint = did_you_mean(wanted.name, same or findings.nodes)
        if same:
            hint = f"did you mean '{same[0]}'?"
        findings.warn_at(
            wanted.place,
            f"nothing in this launch is the container '{wanted.name}'",
            hint or 'its components are loaded once it runs elsewhere',
        )


def warn_of_useless_sections(findings: Findings, *, in_full: bool) -> None:
    """
    Warn of files with parameters that say nothing to the nodes they are for.

    :param in_full: Whether to name also what may be for nodes of others
    """
    files: dict[str, list[SectionUse]] = {}
    for use in findings.section_uses:
        files.setdefault(use.path, []).append(use)
    for path, uses in files.items():
        nodes = [use.node for use in uses]
        if None in nodes:
            continue
        useless = [
            section
            for section in uses[0].sections
            if not any(section.applies_to(node) for node in nodes)
        ]
        told: set[Section] = set()
        for use in uses if useless else ():
            told |= _warn_of_useless(findings, use, useless)
        rest = [section for section in useless if section not in told]
        if in_full and rest:
            names = listing(f"'{section.pattern}'" for section in rest)
            findings.report(
                error(
                    'no node of this launch that gets '
                    f"'{os.path.basename(path)}' is {names}",
                    rest[0].position,
                ).as_warning()
            )


def _warn_of_useless(
    findings: Findings, use: SectionUse, useless: list[Section]
) -> set[Section]:
    """Warn of a node that gets nothing; return what may be meant for it."""
    node = use.node or ''
    file = os.path.basename(use.path)
    last = node.rpartition('/')[2]
    own = [s for s in use.sections if s.applies_to(node)]
    if any(section.is_exact for section in own):
        return set()
    same = [s for s in useless if s.pattern.rpartition('/')[2] == last]
    if same:
        findings.warn_at(
            use.place,
            f"the section '{same[0].pattern}' of '{file}' is not for the node "
            f"'{node}'",
            f"name it '{node}', or '/**/{last}' for any namespace",
        )
    elif use.is_own and not own:
        patterns = [section.pattern for section in useless]
        findings.warn_at(
            use.place,
            f"no section of '{file}' is for the node '{node}'",
            did_you_mean(node, patterns) or f'it has {listing(patterns)}',
        )
        return set(useless)
    return set(same)
