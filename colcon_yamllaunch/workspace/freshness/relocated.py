# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
A workspace that was copied or moved after it was built.

CMake would go on to build the old folder (it prints an error and colcon
returns 0), and links would lead to the old files.
"""

from collections.abc import Iterable
from collections.abc import Mapping
import json
import os
from pathlib import Path
import re

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.common.removal import remove_folder
from colcon_yamllaunch.workspace.freshness.build_record import RECORD_NAME
from colcon_yamllaunch.workspace.freshness.source_links import tree
from colcon_yamllaunch.workspace.packages.package import Package

_CACHE_ENTRY = re.compile(
    r'^(CMAKE_HOME_DIRECTORY|CMAKE_CACHEFILE_DIR):INTERNAL=(.*)$', re.M
)


def relocated_packages(
    packages: Iterable[Package], build_base: Path
) -> dict[str, Path]:
    """
    Find packages whose builds belong to another place.

    :param packages: The packages to look at
    :param build_base: The build folder of the workspace
    :returns: For each one found the folder that it was built from, or in if
      only that one changed
    """
    relocated = {}
    for package in packages:
        old = _old_place(package, build_base / package.name)
        if old is not None:
            relocated[package.name] = old
    return relocated


def remove_builds(
    relocated: Mapping[str, Path],
    build_base: Path,
    install_base: Path,
    merge_install: bool,
) -> None:
    """
    Remove what was built of packages, so that they are built anew.

    Only folders of these packages directly below the two given ones are
    removed. Links are removed, never followed. In a merged install space only
    links to the old place are removed, as builds would trip over them.

    :param relocated: As :func:`relocated_packages` returns them
    :param build_base: The build folder of the workspace
    :param install_base: The install folder of the workspace
    :param merge_install: Whether all packages are installed into one prefix
    :raises WorkspaceError: when something cannot be removed
    """
    for name in relocated:
        _remove(build_base, name)
        if not merge_install:
            _remove(install_base, name)
    if merge_install:
        _remove_links(relocated, build_base, install_base)


def _remove(base: Path, name: str) -> None:
    path = base / name
    if path.parent != base or name in ('', '.', '..'):
        raise WorkspaceError(f"'{name}' is no name of a package")
    remove_folder(path, ', which was built in another place')


def _remove_links(
    relocated: Mapping[str, Path], build_base: Path, install_base: Path
) -> None:
    for path in list(tree(install_base)):
        if not path.is_symlink():
            continue
        target = path.readlink()
        if target.is_relative_to(build_base):
            continue
        # the old build folder is not known of all types of packages
        built = any(
            f'/{build_base.name}/{name}/' in str(target) for name in relocated
        )
        if built or any(
            target.is_relative_to(old) for old in relocated.values()
        ):
            path.unlink()


def _old_place(package: Package, build: Path) -> Path | None:
    expected = {
        'CMAKE_HOME_DIRECTORY': package.path,
        'CMAKE_CACHEFILE_DIR': build,
    }
    cache = _cache(build)
    for name, place in expected.items():
        if name in cache and not _is_same(Path(cache[name]), place):
            return Path(cache[name])
    for source in (_linked_source(build), _recorded_source(build)):
        if source is not None and not _is_same(Path(source), package.path):
            return Path(source)
    return None


def _cache(build: Path) -> dict[str, str]:
    try:
        path = build / 'CMakeCache.txt'
        text = path.read_text(encoding='utf-8', errors='replace')
    except OSError:
        return {}
    return dict(_CACHE_ENTRY.findall(text))


def _linked_source(build: Path) -> str | None:
    # colcon links the setup.py of a Python package into its build space
    try:
        return str((build / 'setup.py').readlink().parent)
    except OSError:
        return None


def _recorded_source(build: Path) -> str | None:
    try:
        source = json.loads((build / RECORD_NAME).read_bytes())['source']
    except (OSError, ValueError, TypeError, KeyError):
        return None
    return source if isinstance(source, str) else None


def _is_same(first: Path, second: Path) -> bool:
    if first == second:
        return True
    return os.path.realpath(first) == os.path.realpath(second)
