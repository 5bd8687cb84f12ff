# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Package manifests that colcon passes over without a word.

Where a `package.xml` is invalid, colcon takes the folder for whatever else is
there, say plain CMake, and then knows no dependencies (colcon-core issue 597).
"""

from collections.abc import Iterable
from collections.abc import Iterator
import os
from pathlib import Path
import re

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.text_files import text_of
from colcon_yamllaunch.workspace.packages.package import Package
from colcon_yamllaunch.workspace.packages.workspace_root import is_ignored

_NAME = re.compile(r'<name>\s*([^<\s]+)\s*</name>')
_MANIFEST = 'package.xml'


@dataclass(frozen=True, slots=True)
class BrokenManifest:
    """
    A `package.xml` that cannot be used.

    :param name: The package's name as far as it can be told
    :param path: The folder that it is in
    :param reason: What catkin_pkg says about it
    """

    name: str | None
    path: Path
    reason: str


def invalid_manifest(package: Package) -> str | None:
    """Tell what is wrong with a manifest that colcon did not use, if so."""
    if package.type.startswith('ros.'):
        return None
    error = manifest_error(package.path)
    if error is None:
        return None
    return (
        f'{package.path / _MANIFEST} is invalid, so colcon would build '
        f'{package.name} as a {package.type} package without its '
        f'dependencies: {error}'
    )


def broken_manifests(
    base_paths: Iterable[Path], packages: Iterable[Package]
) -> tuple[BrokenManifest, ...]:
    """
    Return the manifests in the workspace that make no package at all.

    This crawls the workspace: it is for messages about unknown packages.
    """
    known = {os.path.realpath(package.path) for package in packages}
    folders = [f for base in base_paths for f in _folders(base, known)]
    return tuple(
        BrokenManifest(manifest_name(folder), folder, reason)
        for folder in folders
        if (reason := manifest_error(folder)) is not None
    )


def manifest_error(folder: Path) -> str | None:
    """Tell what is wrong with the manifest in a folder, if it has one."""
    if not os.path.isfile(folder / _MANIFEST):
        return None
    # takes long to import and is hardly ever needed
    from catkin_pkg.package import InvalidPackage
    from catkin_pkg.package import parse_package

    try:
        parse_package(str(folder)).get_build_type()
    except (InvalidPackage, AssertionError, OSError, ValueError) as e:
        return ' '.join(str(e).split())
    return None


def manifest_name(folder: Path) -> str | None:
    """Return the name in a folder's manifest as far as it can be told."""
    match = _NAME.search(text_of(folder / _MANIFEST))
    return match and match[1]


def _folders(base: Path, known: set[str]) -> Iterator[Path]:
    for current, folders, files in os.walk(base):
        folder = Path(current)
        if os.path.realpath(folder) in known or is_ignored(folder):
            folders.clear()
            continue
        folders[:] = sorted(f for f in folders if not f.startswith('.'))
        if _MANIFEST in files:
            yield folder
