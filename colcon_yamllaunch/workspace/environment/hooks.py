# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What the environment hooks of installed packages do.

They are described in dsv files, one `operation;argument;…` a line. The rules
are those of colcon's and ament's prefix scripts (colcon-core,
shell/template/prefix_util.py.em; ament_package, _local_setup_util.py).

:class:`Description` reads them, so that looking at a launch runs nothing of
the workspace. :func:`missing_packages` checks the sourced environment:
colcon's scripts return 0 even if one of their files is broken, or if installed
packages depend on each other in a circle (colcon-core issue 734).
"""

from collections.abc import Mapping, Sequence
from dataclasses import field
from heapq import heappop, heappush
import os
from pathlib import Path
import re

from colcon_yamllaunch.common.files import (
    content_of,
    names_in,
    split_path,
    text_of,
)
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.workspace.environment.sourcing import (
    chained_underlays,
    Environment,
    gone_notes,
    shown_messages,
    sourced_underlays,
)
from colcon_yamllaunch.workspace.packages.package import prefix_of

_SET = ('set', 'set-if-unset')
_IF_EXISTS = 'prepend-non-duplicate-if-exists'
_APPEND = 'append-non-duplicate'
_EXTEND = (_APPEND, 'prepend-non-duplicate', _IF_EXISTS)
#: The extensions that count when bash sources, in ascending priority.
_SHELLS = ('.sh', '.bash')
#: How package.sh names its hooks (colcon-core, shell/template/package.sh.em).
_SH_HOOK = re.compile(
    r'^_colcon_package_sh_source_script "\$COLCON_CURRENT_PREFIX/([^"\n]+)"',
    re.M,
)


#: How many scripts are named that are left out.
SHOWN_SCRIPTS = 3
#: The part of colcon's prefix script that is written in Python.
UTIL = '_local_setup_util_sh.py'
#: What a prefix is sourced by, in colcon's and in ament's.
_SCRIPTS = ('local_setup.bash', 'local_setup.sh', UTIL, '_local_setup_util.py')
#: Where colcon and ament list the packages of a prefix.
_COLCON_INDEX = 'share/colcon-core/packages'
_AMENT_INDEX = 'share/ament_index/resource_index'
#: How colcon reports a circle (shell/template/prefix_util.py.em).
_CIRCLE = re.compile(r'^Circular dependency between: (.*)$', re.M)
#: What is done to a variable: `set`, `set-if-unset`, `append` or `prepend`
#: (where it is not in there yet); its name; and the value.
VariableChange = tuple[str, str, str]


class DamagedHooksError(Exception):
    """A description of hooks is damaged, so that sourcing fails."""

    def __init__(self, path: str, reason: str) -> None:
        super().__init__(f'{path} is damaged: {reason}')


@dataclass(frozen=True, slots=True)
class Hooks:
    """
    The hooks of a package.

    :param paths: What is read or looked for, the description of all first
    :param changes: All that is done to variables, in order
    :param scripts: The scripts that are sourced
    """

    paths: list[str] = field(default_factory=list)
    changes: list[VariableChange] = field(default_factory=list)
    scripts: list[str] = field(default_factory=list)


def read_hooks(prefix: str, name: str) -> Hooks:
    """
    Read what sourcing does for a package.

    :param prefix: The prefix that it is installed in
    :raises DamagedHooksError: when a description of its hooks is damaged
    """
    hooks = Hooks()
    path = os.path.join(prefix, 'share', name, 'package.dsv')
    hooks.paths.append(path)
    if os.path.exists(path):
        _read((path,), prefix, hooks)
        script = f'{path.removesuffix(".dsv")}.sh'
        if os.path.exists(script):
            described = set(_text(path).splitlines())
            for hook in _SH_HOOK.findall(_text(script)):
                if f'source;{hook}' not in described:
                    raise DamagedHooksError(path, f'it lacks {hook}')
    return hooks


def _read(chain: tuple[str, ...], prefix: str, hooks: Hooks) -> None:
    path = chain[-1]
    if path in chain[:-1]:
        raise DamagedHooksError(path, 'it names itself')
    sources: dict[str, set[str]] = {}
    for number, line in enumerate(_text(path).splitlines(), 1):
        if not line.strip() or line.startswith('#'):
            continue
        operation, separator, remainder = line.partition(';')
        try:
            if not separator:
                raise ValueError('there is no semicolon')
            if operation == 'source':
                base, extension = os.path.splitext(remainder)
                if not extension:
                    raise ValueError(f"'{remainder}' has no extension")
                sources.setdefault(base, set()).add(extension)
            else:
                _change(operation, remainder, prefix, hooks)
        except ValueError as e:
            raise DamagedHooksError(path, f'line {number}: {e}') from e
    for base, extensions in sources.items():
        base = os.path.join(prefix, base)
        description = f'{base}.dsv'
        hooks.paths.append(description)
        if os.path.exists(description):
            # both are written together, so a write was cut off
            is_empty = os.path.getsize(description) == 0
            if is_empty and os.path.exists(f'{base}.sh'):
                raise DamagedHooksError(description, 'it is empty')
            _read((*chain, description), prefix, hooks)
        else:
            scripts = [base + e for e in _SHELLS if e in extensions]
            hooks.scripts.extend(scripts[-1:])


def _change(operation: str, remainder: str, prefix: str, hooks: Hooks) -> None:
    name, *values = remainder.split(';')
    if operation not in (*_SET, *_EXTEND):
        raise ValueError(f"there is no operation '{operation}'")
    if not values:
        what = 'value' if operation in _SET else 'path'
        raise ValueError(f'{name} is given no {what}')
    if operation in _SET:
        values = [remainder.partition(';')[2]]
    for value in values:
        path = os.path.join(prefix, value) if value else prefix
        is_present = os.path.exists(path)
        if operation in _SET:
            hooks.paths.append(path)
            change = path if is_present else value
            hooks.changes.append((operation, name, change))
            continue
        if operation == _IF_EXISTS:
            hooks.paths.append(path)
            if not is_present:
                continue
        end = 'append' if operation == _APPEND else 'prepend'
        hooks.changes.append((end, name, path))


def _text(path: str) -> str:
    try:
        return content_of(path).decode('utf-8', 'surrogateescape')
    except OSError as e:
        raise DamagedHooksError(path, e.strerror or str(e)) from e


class Description:
    """
    The environment that sourcing a script makes, as far as hooks describe it.

    The packages come in the order of colcon's and ament's prefix scripts; a
    hook that is only a script is left out.

    :param setup: The `setup.bash` or, without what it chains, the
      `local_setup.bash` of a prefix
    :param environment: The variables before; left as they are
    """

    def __init__(self, setup: Path, environment: Mapping[str, str]) -> None:
        self._base = setup.parent
        self._is_chaining = setup.name == 'setup.bash'
        self._before = environment
        self.variables = dict(environment)
        #: Files and folders that sourcing reads or looks for.
        self.paths = [str(setup)]
        #: The hooks that are only scripts, by the prefix.
        self.scripts: dict[Path, list[str]] = {}
        #: The packages of the last prefix.
        self.packages: list[str] = []
        #: Whether all packages have descriptions of hooks that are sound.
        self.is_complete = True
        chained = chained_underlays(self._base) if self._is_chaining else []
        for prefix in (*chained, self._base):
            self._read_prefix(prefix)

    def environment(self) -> Environment:
        """Return the variables, with notes on what is left out."""
        notes = gone_notes(self._base) if self._is_chaining else ()
        sourced = sourced_underlays(self._before, self._base)
        left_out = [
            script
            for prefix, scripts in self.scripts.items()
            for script in scripts
            if prefix not in sourced
        ]
        if left_out:
            more = ', …' if len(left_out) > SHOWN_SCRIPTS else ''
            notes += (
                'left out of the environment, as nothing is run to look at a '
                f'launch: {", ".join(left_out[:SHOWN_SCRIPTS])}{more}',
            )
        return Environment(self.variables, notes=notes)

    def matches(self, variables: Mapping[str, str]) -> bool:
        """
        Return whether all that sourcing made is what the hooks describe.

        The entries of variables such as PATH may be in another order.
        """
        return (
            self.is_complete
            and not self.scripts
            and self.variables.keys() == variables.keys()
            and all(
                set(split_path(value)) == set(split_path(variables[name]))
                for name, value in self.variables.items()
                if value != variables[name]
            )
        )

    def _read_prefix(self, prefix: Path) -> None:
        self.paths += [str(prefix / name) for name in _SCRIPTS]
        is_of_colcon = os.path.isfile(prefix / UTIL)
        if is_of_colcon:
            self._change(('prepend', 'COLCON_PREFIX_PATH', str(prefix)))
            packages = self._colcon_packages(prefix)
        else:
            packages = self._ament_packages(prefix)
        needs = {name: needed for name, (_, needed) in packages.items()}
        self.packages = _ordered(needs)
        for name in self.packages:
            try:
                hooks = read_hooks(packages[name][0], name)
            except DamagedHooksError:
                self.is_complete = False
                continue
            self.paths += hooks.paths
            if not is_of_colcon and not os.path.exists(hooks.paths[0]):
                # ament sources a script of the package instead
                self.is_complete = False
            if hooks.scripts:
                self.scripts.setdefault(prefix, []).extend(hooks.scripts)
            for change in hooks.changes:
                self._change(change)

    def _colcon_packages(
        self, prefix: Path
    ) -> dict[str, tuple[str, set[str]]]:
        """Return packages with the prefix of each and what it needs."""
        is_merged = os.path.isdir(prefix / _COLCON_INDEX)
        found = {}
        for name in self._names(
            prefix / _COLCON_INDEX if is_merged else prefix
        ):
            own = prefix_of(name, prefix, is_merged)
            entry = own / _COLCON_INDEX / name
            self.paths.append(str(entry))
            if entry.is_file():
                found[name] = str(own), set(split_path(text_of(entry)))
        return found

    def _ament_packages(self, prefix: Path) -> dict[str, tuple[str, set[str]]]:
        index = prefix / _AMENT_INDEX
        found = {}
        for name in self._names(index / 'packages'):
            entry = index / 'package_run_dependencies' / name
            self.paths.append(str(entry))
            needed = text_of(entry) if entry.is_file() else ''
            found[name] = str(prefix), set(filter(None, needed.split(';')))
        return found

    def _names(self, folder: Path) -> list[str]:
        self.paths.append(str(folder))
        return sorted(n for n in names_in(folder) if not n.startswith('.'))

    def _change(self, change: VariableChange) -> None:
        operation, name, value = change
        variables = self.variables
        old = variables.get(name, '')
        if operation == 'set' or (operation == 'set-if-unset' and not old):
            variables[name] = value
        elif operation in ('append', 'prepend') and value not in split_path(
            old
        ):
            both = [old, value] if operation == 'append' else [value, old]
            variables[name] = os.pathsep.join(filter(None, both))


def described_environment(
    setup: Path, environment: Mapping[str, str]
) -> Environment:
    """Return what `source SETUP` would make, as far as it is described."""
    return Description(setup, environment).environment()


def _ordered(packages: dict[str, set[str]]) -> list[str]:
    """Return packages behind what they need, else by their names."""
    pending = {
        n: packages.keys() & needs - {n} for n, needs in packages.items()
    }
    users: dict[str, list[str]] = {}
    for name, needs in pending.items():
        for needed in needs:
            users.setdefault(needed, []).append(name)
    ready = sorted(name for name, needs in pending.items() if not needs)
    ordered = []
    while pending:
        # of a circle, for which sourcing brings in nothing, any will do
        name = heappop(ready) if ready else min(pending)
        if pending.pop(name, None) is None:
            continue
        ordered.append(name)
        for user in users.get(name, ()):
            needs = pending.get(user, set())
            needs.discard(name)
            if user in pending and not needs:
                heappush(ready, user)
    return ordered


def missing_packages(
    environment: Environment,
    names: Sequence[str],
    install_base: Path,
    merge_install: bool,
) -> dict[str, str]:
    """
    Find packages that sourcing did not add, though it returned 0.

    Return for each of them the explanation with the fix.
    """
    missing = {}
    for name in names:
        if name in environment.packages:
            continue
        prefix = prefix_of(name, install_base, merge_install)
        fix = _fix_of_package(name, prefix, merge_install)
        reason: str | None = f'it is not installed in {prefix}'
        if os.path.isfile(prefix / 'share' / name / 'package.sh'):
            try:
                changes = read_hooks(str(prefix), name).changes
            except DamagedHooksError as e:
                reason = str(e)
            else:
                reason = _lack(environment.variables, changes, install_base)
                if reason is not None:
                    fix = _fix_of_all(environment, install_base)
        if reason is not None:
            missing[name] = (
                f'sourcing {install_base / "setup.bash"} did not bring in '
                f'{name}: {reason}{shown_messages(environment.messages)}\n'
                f'{fix}'
            )
    return missing


def _lack(
    variables: Mapping[str, str],
    changes: Sequence[VariableChange],
    install_base: Path,
) -> str | None:
    """Return which entry that hooks add is missing in the variables."""
    own = ('prepend', 'COLCON_PREFIX_PATH', str(install_base))
    for operation, name, path in (own, *changes):
        if operation not in ('append', 'prepend'):
            continue
        entries = split_path(variables.get(name))
        real = os.path.realpath(path)
        if path not in entries and real not in map(os.path.realpath, entries):
            return f'{name} lacks {os.path.normpath(path)}'
    return None


def _fix_of_package(name: str, prefix: Path, merge_install: bool) -> str:
    # a prefix that all packages share holds the others, too
    folder = prefix / 'share' / name if merge_install else prefix
    return f'Remove {folder}, then launch again to have it built anew'


def _fix_of_all(environment: Environment, install_base: Path) -> str:
    """Return the fix of what keeps all packages out."""
    circle = _CIRCLE.search(environment.messages)
    if circle is not None:
        return (
            f'The installed packages {circle[1]} depend on each other in a '
            'circle. Remove a dependency from a package.xml, or what is '
            f'installed in {install_base} of a package that the workspace '
            'has no more, then launch again'
        )
    found = [
        *install_base.glob('share/*/package.dsv'),
        *install_base.glob('*/share/*/package.dsv'),
    ]
    for path in sorted(found):
        prefix, name = path.parents[2], path.parent.name
        try:
            read_hooks(str(prefix), name)
        except DamagedHooksError as e:
            return (
                f'{e}. {_fix_of_package(name, prefix, prefix == install_base)}'
            )
    return (
        f'The setup scripts in {install_base} may be damaged. Remove '
        f'{install_base / UTIL}, then launch again to have them written anew'
    )
