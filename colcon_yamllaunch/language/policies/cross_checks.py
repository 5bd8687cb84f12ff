# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What fits together only once all is read: launch arguments, node names."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
import os
from pathlib import Path
import re

from colcon_yamllaunch.common.files import text_of
from colcon_yamllaunch.common.suggestions import (
    did_you_mean,
    listing,
    question,
)
from colcon_yamllaunch.language.actions.parameter_files import Section
from colcon_yamllaunch.language.evaluation.findings import SectionUse
from colcon_yamllaunch.language.evaluation.walk import Walk
from colcon_yamllaunch.language.syntax.diagnostics import error, LaunchError
from colcon_yamllaunch.language.syntax.launch_tree import (
    LaunchFile,
    UNREADABLE,
)
from colcon_yamllaunch.language.syntax.text import Template, Text

#: The actions that declare one.
ARGUMENT_ACTIONS = ('arg', 'bool_arg')
#: Those that every process heeds, as in ROS 2.
PROCESS_ARGUMENTS = (
    'launch-prefix',
    'launch-prefix-filter',
    'emulate_tty',
    'sigterm_timeout',
    'sigkill_timeout',
)


def cross_check(walk: Walk) -> None:
    """Report what does not fit together in a launch."""
    if not walk.has_opaque:
        _warn_of_unknown_arguments(walk)
        for name, problem in walk.overwritten.items():
            if name not in walk.given_read:
                # the includes around are not those that led there
                walk.diagnostics.extend(problem.diagnostics)
    warn_of_shell_variables(walk)
    if not walk.error_count():
        # an action with an error is none of the launch's nodes
        warn_of_missing_containers(walk)
    warn_of_useless_sections(walk, in_full=False)


def _warn_of_unknown_arguments(walk: Walk) -> None:
    """Warn of given arguments that no launch file declares or reads."""
    files = walk.files.readable()
    declared = declared_arguments(files)
    if walk.dialogue is not None:
        # most launch files are not in Python
        from colcon_yamllaunch.language.python_files.python_source import (
            written_arguments,
        )

        texts = [text_of(Path(path)) for path in walk.files.python]
        for path in walk.files.python:
            declared.update(a.name for a in written_arguments(path))
        declared |= walk.dialogue.declared.keys()
        # they may have been read before they were set
        walk.given_read |= {
            name
            for name in walk.given
            if any(f"'{name}'" in t or f'"{name}"' in t for t in texts)
        }
    known = declared | walk.read | walk.given_read | {*PROCESS_ARGUMENTS}
    for name in walk.given:
        if name not in known:
            hint = undeclared_hint(name, declared)
            walk.report(undeclared_argument(name, hint))


def declared_arguments(files: Iterable[LaunchFile]) -> set[str]:
    """Return the launch arguments that some launch files declare."""
    return {
        entity.item.texts['name'].plain
        for file in files
        for entity in file.walk()
        if entity.action.name in ARGUMENT_ACTIONS
    }


def undeclared_argument(name: str, hint: str) -> LaunchError:
    """Return the warning of a given argument that no launch file knows."""
    message = f"no launch file declares the launch argument '{name}'"
    return error(message, hint=hint).as_warning()


def undeclared_hint(name: str, declared: Collection[str]) -> str:
    """Return what may be meant by an argument that is not declared."""
    listed = ', '.join(sorted(declared)) or 'none'
    return did_you_mean(name, declared) or f'it declares {listed}'


# the actions that do nothing but set launch configurations
_SETTING = (*ARGUMENT_ACTIONS, 'let')


@dataclass(slots=True)
class FileUse:
    """
    What one launch file does with launch arguments.

    :param declared: Those that it declares, and where first
    :param read: The launch configurations that it reads
    :param includes: The launch files that it includes
    :param is_open: Whether it may read others, as when it includes a file that
      cannot be looked into
    :param is_for_others: Whether all that it does is to declare and set what
      the launch files that include it may use
    """

    declared: dict[str, Text] = field(default_factory=dict)
    read: set[str] = field(default_factory=set)
    includes: set[str] = field(default_factory=set)
    is_open: bool = False
    is_for_others: bool = False

    @classmethod
    def of(cls, file: LaunchFile) -> 'FileUse':
        """Return what a launch file does."""
        use = cls()
        use.is_for_others = all(
            entity.action.name in _SETTING for entity in file.entities
        )
        for entity in file.walk():
            if entity.action is UNREADABLE:
                # it may declare or read any
                use.is_open = True
            elif entity.action.name in ARGUMENT_ACTIONS:
                text = entity.item.texts['name']
                use.declared.setdefault(text.plain, text)
            for written in entity.item.every_text():
                if written.literal is None:
                    use.add_text(written.template)
        return use

    def add_text(self, template: Template) -> None:
        """Note what a text reads."""
        for substitution in template.substitutions():
            if substitution.name != 'var':
                continue
            name = substitution.arguments[0].literal
            if name is None:
                self.is_open = True
            else:
                self.read.add(name)


def _reached(uses: Mapping[str, FileUse], path: str) -> dict[str, FileUse]:
    """Return a launch file and all that it includes, directly or not."""
    found: dict[str, FileUse] = {}
    pending = [path]
    while pending:
        path = pending.pop()
        if path not in found and path in uses:
            found[path] = uses[path]
            pending.extend(found[path].includes)
    return found


def unknown_argument(
    uses: Mapping[str, FileUse], path: str, name: str
) -> str | None:
    """Return a hint when a launch file does not use an argument."""
    if name in PROCESS_ARGUMENTS or path not in uses:
        return None
    declared: set[str] = set()
    for use in _reached(uses, path).values():
        if use.is_open or name in use.declared or name in use.read:
            return None
        declared.update(use.declared)
    return undeclared_hint(name, declared)


def warn_of_useless_arguments(
    walk: Walk, uses: Mapping[str, FileUse], path: str
) -> None:
    """
    Warn of arguments that are declared or given, and not used.

    :param uses: What each launch file does, by its path
    :param path: The outermost launch file
    """
    # what an include sets, the file that includes it sees too
    users = set(PROCESS_ARGUMENTS).union(
        *(use.read - use.declared.keys() for use in uses.values())
    )
    for own, use in uses.items():
        reached = _reached(uses, own) if use.declared else {}
        if use.is_for_others or any(u.is_open for u in reached.values()):
            continue
        for name, text in use.declared.items():
            if name not in users and not any(
                name in other.read or (file != own and name in other.declared)
                for file, other in reached.items()
            ):
                walk.warn(
                    f"the launch argument '{name}' is never used",
                    text,
                    f'use it as $(var {name}), or remove it',
                )
    for name in walk.given:
        hint = unknown_argument(uses, path, name)
        if hint is not None:
            walk.report(undeclared_argument(name, hint))


_VARIABLE = re.compile(r'\$\{(\w+)\}')


def warn_of_shell_variables(walk: Walk) -> None:
    """
    Warn where `${name}` is written for a launch argument.

    What a shell is to run may have variables of its own.
    """
    read = walk.files.readable()
    suspects = [file for file in read if '${' in file.source.text]
    declared = declared_arguments(read) if suspects else set()
    for file in suspects:
        for entity in file.walk():
            if 'shell' in entity.item.texts:
                continue
            for text in entity.item.every_text():
                for written in _VARIABLE.finditer(text.plain):
                    if written[1] in declared:
                        walk.warn(
                            f"'{written[0]}' is no substitution and stays as "
                            'it is',
                            text,
                            f'write $(var {written[1]})',
                        )


def warn_of_missing_containers(walk: Walk) -> None:
    """Warn of components whose container no node of the launch is."""
    if walk.may_have_others:
        return
    for name, place in walk.targets:
        if name in walk.nodes:
            continue
        last = name.rpartition('/')[2]
        same = [n for n in walk.nodes if n.rpartition('/')[2] == last]
        hint = did_you_mean(name, walk.nodes)
        if same:
            hint = question(same[0])
        walk.warn_at(
            place,
            f"nothing in this launch is the container '{name}'",
            hint or 'its components are loaded once it runs elsewhere',
        )


def warn_of_useless_sections(walk: Walk, *, in_full: bool) -> None:
    """
    Warn of files with parameters that say nothing to the nodes they are for.

    :param in_full: Whether to name also what may be for nodes of others
    """
    files: dict[str, list[SectionUse]] = {}
    for use in walk.section_uses:
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
            told |= _warn_of_useless(walk, use, useless)
        rest = [section for section in useless if section not in told]
        if in_full and rest:
            names = listing(f"'{section.pattern}'" for section in rest)
            walk.report(
                error(
                    'no node of this launch that gets '
                    f"'{os.path.basename(path)}' is {names}",
                    rest[0].position,
                ).as_warning()
            )


def _warn_of_useless(
    walk: Walk, use: SectionUse, useless: list[Section]
) -> set[Section]:
    """Warn of a node without a section; return sections with similar names."""
    node = use.node or ''
    file = os.path.basename(use.path)
    last = node.rpartition('/')[2]
    own = [s for s in use.sections if s.applies_to(node)]
    if any(section.is_exact for section in own):
        return set()
    same = [s for s in useless if s.pattern.rpartition('/')[2] == last]
    if same:
        walk.warn_at(
            use.place,
            f"the section '{same[0].pattern}' of '{file}' is not for the node "
            f"'{node}'",
            f"name it '{node}', or '/**/{last}' for any namespace",
        )
    elif use.is_own and not own:
        patterns = [section.pattern for section in useless]
        walk.warn_at(
            use.place,
            f"no section of '{file}' is for the node '{node}'",
            did_you_mean(node, patterns) or f'it has {listing(patterns)}',
        )
        return set(useless)
    return set(same)
