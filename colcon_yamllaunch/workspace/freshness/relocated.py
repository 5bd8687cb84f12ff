# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
A workspace that was copied or moved after it was built.

CMake would go on to build the old folder (it prints an error and colcon
returns 0), and links would lead to the old files.
"""

from collections.abc import Iterable
from collections.abc import Iterator
from collections.abc import Mapping
from contextlib import suppress
import os
from pathlib import Path
import re

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.common.json_files import read_json
from colcon_yamllaunch.common.text_files import text_of
from colcon_yamllaunch.workspace.freshness.build_products import Products
from colcon_yamllaunch.workspace.freshness.build_products import remove_folder
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

    Return for each the folder that it was built from, or in if only that one
    changed.
    """
    old = {p.name: _old_place(p, build_base / p.name) for p in packages}
    return {name: place for name, place in old.items() if place is not None}


def remove_builds(relocated: Mapping[str, Path], products: Products) -> None:
    """
    Remove what was built of packages, so that they are built anew.

    Only folders of these packages directly below `build/` and `install/` are
    removed. Links are removed, never followed. In a merged install space only
    links to the old place are removed, as builds would trip over them.

    :param relocated: As :func:`relocated_packages` returns them
    :raises WorkspaceError: when something cannot be removed
    """
    for name in relocated:
        _remove(products.build_base, name)
        if not products.merge_install:
            _remove(products.install_base, name)
    if products.merge_install:
        _remove_links(relocated, products.build_base, products.install_base)


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
    for old, place in _places(package.path, build):
        if old != place and os.path.realpath(old) != os.path.realpath(place):
            return old
    return None


def _places(source: Path, build: Path) -> Iterator[tuple[Path, Path]]:
    """Iterate over what builds wrote down, each with what it should be."""
    cache = dict(_CACHE_ENTRY.findall(text_of(build / 'CMakeCache.txt')))
    yield Path(cache.get('CMAKE_HOME_DIRECTORY', source)), source
    yield Path(cache.get('CMAKE_CACHEFILE_DIR', build)), build
    # colcon links the setup.py of a Python package into its build space
    with suppress(OSError):
        yield (build / 'setup.py').readlink().parent, source
    record = read_json(build / RECORD_NAME)
    if isinstance(record, dict) and isinstance(record.get('source'), str):
        yield Path(record['source']), source
