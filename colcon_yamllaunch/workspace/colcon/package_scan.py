# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The packages of a workspace without colcon, as completion needs them.

Nothing is written. The cached answers of colcon are used for unchanged
folders; for new and changed folders, the files that colcon would read tell
what they are.
"""

from collections.abc import Mapping
import os
from pathlib import Path

from colcon_yamllaunch.common.codec import from_json
from colcon_yamllaunch.common.files import split_path
from colcon_yamllaunch.workspace.colcon.colcon_cache import (
    BuildArguments,
    read_cache,
)
from colcon_yamllaunch.workspace.environment.sourcing import chained_underlays
from colcon_yamllaunch.workspace.packages.build_files import (
    cmake_name,
    python_name,
)
from colcon_yamllaunch.workspace.packages.package import (
    is_merged,
    manifest_name,
    Package,
)
from colcon_yamllaunch.workspace.packages.package_index import (
    IGNORED,
    PACKAGE,
    PackageIndex,
    PLAIN,
)
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator
from colcon_yamllaunch.workspace.packages.workspace_root import is_ignored

#: What `colcon build` does without arguments and defaults.
_USUAL = BuildArguments('build', 'install', False, ('.',), {})


def scan_packages(
    root: Path | None, environment: Mapping[str, str]
) -> PackageLocator:
    """
    Find the packages of a workspace, of its install space and the underlays.

    :param root: The workspace, or None: then there are only the underlays
    """
    if root is None:
        return PackageLocator((), Path(), False, environment)
    root = Path(os.path.realpath(root))
    cache = read_cache(root)
    try:
        arguments = from_json(BuildArguments, cache['arguments'])
    except (KeyError, TypeError, ValueError):
        arguments = _USUAL
    index = PackageIndex(root, arguments.base_paths, os.environ)
    reader = _FolderReader(root)
    index.find(cache.get('folders', {}), lambda: reader)
    install_base = root / arguments.install_base
    return PackageLocator(
        index.packages().values(),
        install_base,
        arguments.merge_install or is_merged(install_base),
        _with_underlays(environment, install_base),
    )


def _with_underlays(
    environment: Mapping[str, str], install_base: Path
) -> dict[str, str]:
    """Add the prefixes that the workspace's setup script would add."""
    chained = [str(path) for path in reversed(chained_underlays(install_base))]
    added = {
        'AMENT_PREFIX_PATH': chained,
        'COLCON_PREFIX_PATH': [str(install_base), *chained],
    }
    return dict(environment) | {
        name: os.pathsep.join((*paths, *split_path(environment.get(name))))
        for name, paths in added.items()
    }


class _FolderReader:
    """Identifies folders without colcon; see `package_index.Identifier`."""

    def __init__(self, root: Path) -> None:
        self._root = root
        self._packages: dict[str, Package] = {}

    def identify(self, folder: str) -> tuple[str, str]:
        path = Path(os.path.normpath(self._root / folder))
        if is_ignored(path):
            return IGNORED, ''
        for package_type, name_of in _NAMES:
            name = name_of(path)
            if name is not None:
                self._packages[folder] = Package(name, path, package_type)
                return PACKAGE, package_type
        return PLAIN, ''

    def describe(self) -> Mapping[str, tuple[Package, str]]:
        return {f: (package, '') for f, package in self._packages.items()}


def _python_name(folder: Path) -> str | None:
    is_setup = os.path.isfile(folder / 'setup.py')
    if not is_setup and not os.path.isfile(folder / 'setup.cfg'):
        return None
    return python_name(folder) or (folder.name if is_setup else None)


# in the order in which colcon asks its extensions; of a package with a
# manifest, what builds it matters to nobody here
_NAMES = (
    ('ros.', manifest_name),
    ('cmake', cmake_name),
    ('python', _python_name),
)
