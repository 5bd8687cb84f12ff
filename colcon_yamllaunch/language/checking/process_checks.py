# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Whether there are the programs that a launch file runs, and their names."""

import os
import re
import shutil

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.suggestions import did_you_mean
from colcon_yamllaunch.language.checking.attributes import check_command
from colcon_yamllaunch.language.checking.attributes import check_pairs
from colcon_yamllaunch.language.checking.attributes import truth
from colcon_yamllaunch.language.checking.check_state import Checking
from colcon_yamllaunch.language.checking.parameter_checks import (
    check_parameter,
)
from colcon_yamllaunch.language.checking.possible_scope import Guard
from colcon_yamllaunch.language.checking.possible_scope import Value
from colcon_yamllaunch.language.checking.possible_values import value_of
from colcon_yamllaunch.language.evaluation.evaluation_state import (
    ExecutableUse,
)
from colcon_yamllaunch.language.syntax.position import Position
from colcon_yamllaunch.language.syntax.ros_names import join_namespace
from colcon_yamllaunch.language.syntax.ros_names import namespace_problem
from colcon_yamllaunch.language.syntax.ros_names import node_name_problem
from colcon_yamllaunch.language.tree.launch_tree import Item
from colcon_yamllaunch.language.tree.text import Text

#: How many nodes of one name are compared with another one.
MAXIMUM_NAMESAKES = 8

# where a package's programs are (ament, REP 122): PREFIX/lib/PACKAGE/PROGRAM
_PROGRAM_PATH = re.compile(r'(.+)/lib/([^/]+)/([^/]+)')


@dataclass(frozen=True, slots=True)
class _NamedNode:
    """A node that has a name, and when there is one."""

    position: Position
    guards: tuple[Guard, ...]

    def may_meet(self, other: '_NamedNode') -> bool:
        """Say whether one launch may evidently have both."""
        return not any(
            mine.excludes(its) for mine in self.guards for its in other.guards
        )


class ProcessChecks:
    """
    The checks of the actions that run a process.

    :param checking: The state of the check
    """

    def __init__(self, checking: Checking) -> None:
        self._checking = checking
        self._nodes: dict[str, list[_NamedNode]] = {}

    def executable(self, item: Item, values: dict[str, Value]) -> None:
        """Check an 'executable'."""
        arguments = check_command(self._checking, item, 'cmd')
        self._process(item)
        if not arguments:
            self._checking.error("'cmd' is empty", item.position)
        elif not self._has_other_program(item, values):
            self._check_program(*arguments[0], 'install it, or name its path')

    def node(self, item: Item, values: dict[str, Value]) -> None:
        """Check a 'node'."""
        checking = self._checking
        self._process(item)
        for name in ('args', 'ros_args'):
            check_command(checking, item, name)
        for entry in item.items.get('param', ()):
            check_parameter(checking, entry)
        self._check_remaps(item)
        package = values.get('pkg')
        if package is not None:
            self._check_package_program(item, package, values['exec'])
        elif not self._has_other_program(item, values):
            text = item.texts['exec']
            hint = "name its package with 'pkg'"
            self._check_program(text, values['exec'], hint)
        self._check_name(item, values)

    def _process(self, item: Item) -> None:
        check_pairs(self._checking, item.items.get('env', ()))

    def _has_other_program(self, item: Item, values: dict[str, Value]) -> bool:
        """Say whether a shell or prefix finds the program."""
        prefix = self._checking.scope.configurations.get('launch-prefix')
        return (
            'launch-prefix' in item.texts
            or prefix is not None
            or truth(values.get('shell'), False) is not False
        )

    def _check_package_program(
        self, item: Item, package: Value, program: Value
    ) -> None:
        if package.text is None:
            return
        checking, text = self._checking, item.texts['pkg']
        packages = checking.packages
        if packages.prefix(package.text) is None:
            checking.error(
                f"there is no package '{package.text}' in the workspace or an "
                'underlay',
                text.position,
                hint=did_you_mean(package.text, packages.names()),
                length=text.length,
            )
            return
        checking.state.use_package(package.text, text.position)
        if program.text is None:
            return
        text = item.texts['exec']
        path = packages.executable(package.text, program.text)
        if path is None:
            checking.error(
                f"package '{package.text}' has no executable '{program.text}'",
                text.position,
                hint=packages.explain_executable(package.text, program.text),
                length=text.length,
            )
            return
        checking.state.executables.append(
            ExecutableUse(package.text, program.text, path, text.position)
        )

    def _check_program(self, text: Text, program: Value, hint: str) -> None:
        checking = self._checking
        if program.text is None:
            return
        name = program.text
        if '/' in name:
            is_there = self._is_program(checking.absolute(name))
        elif checking.scope.environment.get('PATH') is not None:
            return
        else:
            path = checking.environment.get('PATH', os.defpath)
            is_there = shutil.which(name, path=path) is not None
        if is_there:
            return
        where = '' if '/' in name else ' on the PATH'
        checking.error(
            f"there is no executable '{name}'{where}",
            text.position,
            hint=None if '/' in name else hint,
            length=text.length,
        )

    def _is_program(self, path: str) -> bool:
        packages = self._checking.packages
        found = _PROGRAM_PATH.fullmatch(path)
        if found:
            prefix, package, name = found.groups()
            if packages.prefix(package) == prefix:
                return packages.executable(package, name) is not None
        if os.path.isfile(path) and os.access(path, os.X_OK):
            return True
        return packages.locate(path) is not None or packages.may_appear(path)

    def _check_remaps(self, item: Item) -> None:
        checking = self._checking
        seen: set[str] = set()
        for remap in item.items.get('remap', ()):
            text = remap.texts['from']
            old = value_of(checking, text).text
            value_of(checking, remap.texts['to'])
            if old is None:
                continue
            # the first rule that matches counts (rcl_remap)
            if old in seen or old in checking.scope.remaps:
                by = 'before' if old in seen else "by 'set_remap'"
                checking.warn(
                    f"'{old}' is remapped {by} already, so this has no effect",
                    text.position,
                    hint='remove one of the two',
                    length=text.length,
                )
            seen.add(old)

    def _check_name(self, item: Item, values: dict[str, Value]) -> None:
        name, namespace = values.get('name'), values.get('namespace')
        problem = None
        if name is not None and name.text is not None:
            problem = node_name_problem(name.text)
            self._report_name(problem, item, 'name')
        if namespace is not None and namespace.text is not None:
            base = self._checking.scope.namespace
            known = base.text if base is not None else None
            full = join_namespace(known, namespace.text)
            problem = namespace_problem(full) or problem
            self._report_name(namespace_problem(full), item, 'namespace')
        if name is not None and problem is None:
            self._check_unique(item, name, namespace)

    def _report_name(
        self, problem: str | None, item: Item, attribute: str
    ) -> None:
        if problem is not None:
            text = item.texts[attribute]
            self._checking.error(problem, text.position, length=text.length)

    def _check_unique(
        self, item: Item, name: Value, namespace: Value | None
    ) -> None:
        full = self._full_name(name, namespace)
        if full is None or self._checking.never:
            return
        text = item.texts['name']
        node = _NamedNode(text.position, tuple(self._checking.guards))
        others = self._nodes.setdefault(full, [])
        for other in others:
            if node.may_meet(other):
                again = other.position == node.position
                self._checking.warn(
                    f"another node of this launch has the name '{full}' too",
                    text.position,
                    hint='this node is launched more than once'
                    if again
                    else f'the other one is in line {other.position.line} of '
                    + os.path.basename(other.position.path),
                    length=text.length,
                )
                break
        if len(others) < MAXIMUM_NAMESAKES:
            others.append(node)

    def _full_name(self, name: Value, namespace: Value | None) -> str | None:
        """Return the full name of a node, None when it is not known."""
        base = self._checking.scope.namespace
        if name.text is None:
            return None
        if namespace is None:
            if base is not None and base.text is None:
                return None
            full = base.text if base is not None else ''
        else:
            if namespace.text is None:
                return None
            is_absolute = namespace.text.startswith('/')
            if base is not None and base.text is None and not is_absolute:
                return None
            full = join_namespace(base.text if base else None, namespace.text)
        return f'{(full or "").rstrip("/")}/{name.text}'
