# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Which launch arguments the launch files declare, and which they use."""

from collections.abc import Iterator
from collections.abc import Mapping
from dataclasses import dataclass
from dataclasses import field

from colcon_yamllaunch.language.policies.launch_arguments import (
    ARGUMENT_ACTIONS,
)
from colcon_yamllaunch.language.policies.launch_arguments import (
    PROCESS_ARGUMENTS,
)
from colcon_yamllaunch.language.policies.launch_arguments import (
    undeclared_argument,
)
from colcon_yamllaunch.language.policies.launch_arguments import (
    undeclared_hint,
)
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.template import Template
from colcon_yamllaunch.language.tree.launch_tree import LaunchFile
from colcon_yamllaunch.language.tree.launch_tree import UNREADABLE
from colcon_yamllaunch.language.tree.text import Text

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


class ArgumentUse:
    """The launch arguments of all launch files that are reached."""

    def __init__(self) -> None:
        self._files: dict[str, FileUse] = {}

    def __getitem__(self, path: str) -> FileUse:
        return self._files[path]

    def add(self, path: str, file: LaunchFile) -> None:
        """Note what a launch file does."""
        use = self._files[path] = FileUse()
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

    def reached(self, path: str) -> dict[str, FileUse]:
        """Return a launch file and all that it includes, directly or not."""
        found: dict[str, FileUse] = {}
        pending = [path]
        while pending:
            path = pending.pop()
            if path not in found and path in self._files:
                found[path] = self._files[path]
                pending.extend(found[path].includes)
        return found

    def unknown_argument(self, path: str, name: str) -> str | None:
        """Return a hint when a launch file does not use an argument."""
        if name in PROCESS_ARGUMENTS or path not in self._files:
            return None
        declared: set[str] = set()
        for use in self.reached(path).values():
            if use.is_open or name in use.declared or name in use.read:
                return None
            declared.update(use.declared)
        return undeclared_hint(name, declared)

    def unknown_given(
        self, path: str, arguments: Mapping[str, str]
    ) -> Iterator[LaunchError]:
        """Report the given arguments that no launch file has a use for."""
        for name in arguments:
            hint = self.unknown_argument(path, name)
            if hint is not None:
                yield undeclared_argument(name, hint)

    def unused(self) -> Iterator[LaunchError]:
        """Report the arguments that are declared and not used."""
        users = self._readers_without_declaration()
        for path, use in self._files.items():
            reached = self.reached(path) if use.declared else {}
            if use.is_for_others or any(
                other.is_open for other in reached.values()
            ):
                continue
            for name, text in use.declared.items():
                if name in users or name in PROCESS_ARGUMENTS:
                    continue
                if not _is_used(name, path, reached):
                    yield error(
                        f"the launch argument '{name}' is never used",
                        text,
                        hint=f'use it as $(var {name}), or remove it',
                    ).as_warning()

    def _readers_without_declaration(self) -> set[str]:
        # what an include sets, the file that includes it sees too
        return {
            name
            for use in self._files.values()
            for name in use.read - use.declared.keys()
        }


def _is_used(name: str, path: str, reached: Mapping[str, FileUse]) -> bool:
    return any(
        name in use.read or (other != path and name in use.declared)
        for other, use in reached.items()
    )
