# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What may stand at a place of the command line, for completion."""

from collections.abc import Mapping
from collections.abc import Sequence
import os
from pathlib import Path

from colcon_yamllaunch.workspace.packages.launch_files import find_launch_files
from colcon_yamllaunch.workspace.packages.launch_files import launch_file_names
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator
from colcon_yamllaunch.workspace.packages.source_programs import (
    source_programs,
)

#: Each candidate with its description, which zsh shows.
Candidates = Mapping[str, str]


def packages(locator: PackageLocator, prefix: str) -> Candidates:
    """Return the packages whose names start with something."""
    return {n: '' for n in locator.names() if n.startswith(prefix)}


def launch_files(
    package: str, locator: PackageLocator, prefix: str
) -> Candidates:
    """Return a package's launch files: names, or paths if one is begun."""
    own = locator.package(package)
    folder = locator.share(package) if own is None else own.path
    files = () if folder is None else find_launch_files(Path(folder))
    names = files if '/' in prefix else launch_file_names(package, files)
    return dict.fromkeys(names, '')


def executables(package: str, locator: PackageLocator) -> Candidates:
    """Return the programs that a package has installed, or will install."""
    names = set(locator.executables(package))
    own = locator.package(package)
    if own is not None:
        names |= source_programs(own.path).names
    return dict.fromkeys(sorted(names), '')


def paths(prefix: str, suffixes: Sequence[str]) -> Candidates:
    """
    Return folders, and files with given endings.

    :raises OSError: when the folder cannot be read
    """
    head = prefix[: prefix.rfind('/') + 1]
    begun = prefix[len(head) :]
    found = []
    with os.scandir(Path(head or '.').expanduser()) as entries:
        for entry in entries:
            name = entry.name
            if name.startswith('.') and not begun:
                continue
            if entry.is_dir():
                found.append(f'{head}{name}/')
            elif name.endswith(tuple(suffixes)):
                found.append(head + name)
    return dict.fromkeys(sorted(found), '')
