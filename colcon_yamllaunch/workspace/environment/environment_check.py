# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Whether sourcing brought in what it should have.

colcon's scripts return 0 when a file of theirs is broken, and when installed
packages depend on each other in a circle (colcon-core issue 734). So what the
packages' hooks put in is looked for.
"""

from collections.abc import Iterable
from collections.abc import Mapping
from collections.abc import Sequence
import os
from pathlib import Path
import re

from colcon_yamllaunch.common.search_path import split_path
from colcon_yamllaunch.common.text_files import content_of
from colcon_yamllaunch.workspace.environment import hooks
from colcon_yamllaunch.workspace.environment import setup_templates
from colcon_yamllaunch.workspace.environment.sourcing import Environment
from colcon_yamllaunch.workspace.environment.sourcing import shown_messages
from colcon_yamllaunch.workspace.packages.package import prefix_of

_UTIL = '_local_setup_util_sh.py'
#: How colcon reports a circle (shell/template/prefix_util.py.em).
_CIRCLE = re.compile(r'^Circular dependency between: (.*)$', re.M)


def missing_packages(
    environment: Environment,
    names: Sequence[str],
    install_base: Path,
    merge_install: bool,
) -> dict[str, str]:
    """
    Find packages that sourcing did not bring in, though it returned 0.

    Return for each of them the explanation with the cure.
    """
    missing = {}
    for name in names:
        if name in environment.packages:
            continue
        prefix = prefix_of(name, install_base, merge_install)
        cure = _again(name, prefix, merge_install)
        reason = _damage(prefix, name)
        if reason is None:
            reason = _lack(environment.variables, name, prefix, install_base)
            if reason is not None:
                cure = _common_cure(environment, install_base) or cure
        if reason is not None:
            missing[name] = (
                f'sourcing {install_base / "setup.bash"} did not bring in '
                f'{name}: {reason}{shown_messages(environment.messages)}\n'
                f'{cure}'
            )
    return missing


def sourced_packages(
    environment: Environment, paths: Iterable[str], install_base: Path
) -> frozenset[str]:
    """
    Return the packages that a setup script brought in.

    :param environment: What it made
    :param paths: What sourcing it depends on
    """
    described = [path for path in paths if path.endswith('/package.dsv')]
    packages = set()
    for path in map(Path, described):
        name, prefix = path.parent.name, path.parents[2]
        if install_base in (prefix, prefix.parent):
            merged = prefix == install_base
            if not missing_packages(environment, [name], install_base, merged):
                packages.add(name)
    return frozenset(packages)


def cure_of_script(setup: Path) -> str:
    """Return the cure, in a line, where a setup script is to blame."""
    script = _unknown_script(setup.parent)
    if script is None or not os.path.isfile(setup):
        return ''
    return (
        f'\n{script} is not as colcon writes it: run `colcon build` in the '
        'workspace to have it written anew'
    )


def _unknown_script(install_base: Path) -> Path | None:
    for name in ('setup.bash', 'local_setup.bash', _UTIL):
        path = install_base / name
        try:
            text = content_of(path).decode('utf-8', 'surrogateescape')
            if not setup_templates.is_from(setup_templates.colcon(name), text):
                return path
        except OSError:
            return path
    return None


def _damage(prefix: Path, name: str) -> str | None:
    if not os.path.isfile(prefix / 'share' / name / 'package.sh'):
        return f'it is not installed in {prefix}'
    try:
        hooks.read_hooks(str(prefix), name)
    except hooks.DamagedHooksError as e:
        return str(e)
    return None


def _lack(
    variables: Mapping[str, str], name: str, prefix: Path, install_base: Path
) -> str | None:
    promised = [('COLCON_PREFIX_PATH', str(install_base))]
    promised += hooks.read_hooks(str(prefix), name).extended
    for variable, path in promised:
        if not _has(variables, variable, path):
            return f'{variable} lacks {os.path.normpath(path)}'
    return None


def _has(variables: Mapping[str, str], name: str, path: str) -> bool:
    entries = split_path(variables.get(name))
    if path in entries:
        return True
    real = os.path.realpath(path)
    return any(os.path.realpath(entry) == real for entry in entries)


def _again(name: str, prefix: Path, merge_install: bool) -> str:
    # a prefix that all packages share holds the others, too
    folder = prefix / 'share' / name if merge_install else prefix
    return f'Remove {folder}, then launch again to have it built anew'


def _common_cure(environment: Environment, install_base: Path) -> str | None:
    """Return the cure of what keeps all packages out."""
    circle = _CIRCLE.search(environment.messages)
    if circle is not None:
        return (
            f'The installed packages {circle[1]} depend on each other in a '
            'circle. Remove a dependency from a package.xml, or what is '
            f'installed in {install_base} of a package that the workspace '
            'has no more, then launch again'
        )
    script = _unknown_script(install_base)
    if script is not None:
        return (
            f'{script} is not as colcon writes it. Remove '
            f'{install_base / _UTIL}, then launch again to have it written '
            'anew'
        )
    return _damaged_neighbour(install_base)


def _damaged_neighbour(install_base: Path) -> str | None:
    found = [
        *install_base.glob('share/*/package.dsv'),
        *install_base.glob('*/share/*/package.dsv'),
    ]
    for path in sorted(found):
        prefix, name = path.parents[2], path.parent.name
        try:
            hooks.read_hooks(str(prefix), name)
        except hooks.DamagedHooksError as e:
            cure = _again(name, prefix, prefix == install_base)
            return f'{e}. {cure}'
    return None
