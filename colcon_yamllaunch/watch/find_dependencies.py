# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Finds what a launch uses, in its plan and in the records of builds.

The record of a package's last successful build lists which source files stand
for installed files. It is read once, and again when it has changed.
"""

from collections.abc import Iterable
from collections.abc import Iterator
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
import os
from pathlib import Path
import re

from colcon_yamllaunch.language.policies.evaluate import Evaluation
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.watch.consequences import Products
from colcon_yamllaunch.watch.dependencies import Dependencies
from colcon_yamllaunch.watch.dependencies import PackageDependencies
from colcon_yamllaunch.watch.dependencies import RemoteDependencies
from colcon_yamllaunch.watch.process_dependencies import ProcessFinder
from colcon_yamllaunch.workspace.colcon.colcon_cache import CachedColcon
from colcon_yamllaunch.workspace.freshness.build_record import (
    DamagedRecordError,
)
from colcon_yamllaunch.workspace.freshness.build_record import read_record
from colcon_yamllaunch.workspace.freshness.build_record import Record
from colcon_yamllaunch.workspace.freshness.build_record import RECORD_NAME
from colcon_yamllaunch.workspace.packages.closure import closure
from colcon_yamllaunch.workspace.packages.package import Package
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator

_PYTHON_SUFFIX = '.py'
_LINK = 'link to '
#: More than workspaces have packages.
_RECORDS = 10_000


def find_dependencies(
    plan: Plan,
    evaluation: Evaluation,
    colcon: CachedColcon | None,
    locator: PackageLocator,
    wanted: Iterable[str],
    libraries: Mapping[str, frozenset[str] | None],
    environment: Mapping[str, str],
    remote: RemoteDependencies | None = None,
) -> Dependencies:
    """
    Return what a launch uses.

    :param plan: Its plan, with the labels that are in use
    :param evaluation: The evaluation that made the plan
    :param colcon: The colcon of the workspace, None without a workspace
    :param locator: Finds the packages of the workspace
    :param wanted: The packages of the workspace that it names
    :param libraries: The files mapped into processes, as far as known
    :param environment: The environment of the processes
    :param remote: The dependencies of parts on other machines
    """
    remote = remote or RemoteDependencies()
    packages: list[Package] = []
    products: set[str] = set()
    folders: list[Path] = []
    used: tuple[PackageDependencies, ...] = ()
    install = os.sep
    if colcon is not None:
        for base in (colcon.build_base, colcon.install_base):
            products |= {str(base), os.path.realpath(base)}
        install = f'{colcon.install_base}{os.sep}'
        by_name = {p.name: p for p in locator.packages()}
        needed = frozenset(wanted).union(*remote.packages.values())
        packages = [by_name[n] for n in closure(by_name.values(), needed)]
        folders = [colcon.root, *(package.path for package in packages)]
        used = tuple(
            replace(
                _package(p.name, str(p.path), _stamp(colcon, p.name)),
                machines=tuple(
                    machine
                    for machine, names in remote.packages.items()
                    if p.name in names
                ),
                share=locator.share(p.name) or '',
            )
            for p in packages
        )
    finder = ProcessFinder(
        plan,
        packages,
        libraries,
        environment,
        install,
        tuple(f'{os.path.realpath(p)}{os.sep}' for p in folders),
        remote,
    )
    read = [*(file.path for file in evaluation.files), *evaluation.inputs]
    return Dependencies(
        tuple(finder.find()),
        used,
        frozenset(map(os.path.realpath, read)),
        reads_more=evaluation.has_run_programs,
        is_plan_broken=bool(evaluation.errors),
        products=tuple(sorted(products)),
        remote_files=frozenset[str]().union(*remote.files.values()),
        unsynced=remote.unsynced,
    )


def build_products(colcon: CachedColcon, names: Iterable[str]) -> Products:
    """Return the products of the last successful builds of packages."""
    return {name: _products(colcon, name) for name in names}


def _products(colcon: CachedColcon, name: str) -> dict[str, str]:
    stamp = _stamp(colcon, name)
    record = None if stamp is None else _record(*stamp)
    if record is None:
        return {}
    return {
        f'{folder}{os.sep}{path}': f'{found.digest} {found.executable:d}'
        for folder, files in (
            (os.path.realpath(colcon.install_base), record.installed),
            (os.path.realpath(colcon.build_base / name), record.products),
        )
        for path, found in files.items()
    }


def _stamp(colcon: CachedColcon, name: str) -> tuple[str, int, int] | None:
    path = f'{colcon.build_base}{os.sep}{name}{os.sep}{RECORD_NAME}'
    try:
        status = os.stat(path)
    except OSError:
        return None
    return path, status.st_mtime_ns, status.st_ino


@lru_cache(_RECORDS)
def _record(path: str, _time: int, _inode: int) -> Record | None:
    try:
        return read_record(Path(path))
    except DamagedRecordError:
        return None


@lru_cache(_RECORDS)
def _package(
    name: str, path: str, stamp: tuple[str, int, int] | None
) -> PackageDependencies:
    """Return what is used of a package, as of its last build."""
    record = None if stamp is None else _record(*stamp)
    if stamp is None or record is None:
        return PackageDependencies(name, path)
    build = os.path.dirname(stamp[0])
    modules = frozenset(_modules(name, Path(path), record, build))
    return PackageDependencies(
        name,
        path,
        record.live,
        modules,
        frozenset(map(os.path.dirname, modules)),
        frozenset(filter(os.path.isabs, record.files)),
    )


def _modules(
    name: str, folder: Path, record: Record, build: str
) -> Iterator[str]:
    """
    Iterate over the files that programs in Python import.

    :param build: The package's folder in the build space, where those of
      packages in Python are linked, too
    """
    candidates = [r for r in record.live if r.endswith(_PYTHON_SUFFIX)]
    if not candidates:
        return
    folders = {str(folder), os.path.realpath(folder), build}
    starts = [f'{_LINK}{start}{os.sep}' for start in sorted(folders)]
    data, programs = set(), set()
    for installed, found in record.installed.items():
        for start in starts:
            if not found.digest.startswith(start):
                continue
            parts = installed.split(os.sep)
            target = found.digest[len(start) :].rstrip(os.sep)
            if 'share' in parts:
                data.add(target)
            elif parts[-3:-1] == ['lib', name]:
                programs.add(target)
    imported = _imported(folder, programs)
    for relative in candidates:
        above = {relative, *map(str, Path(relative).parents)}
        if data.isdisjoint(above) and (
            relative not in programs
            or Path(relative).stem in imported
            or not os.access(folder / relative, os.X_OK)
        ):
            yield relative


def _imported(folder: Path, programs: Iterable[str]) -> set[str]:
    """Return the modules that programs import, up to the first dot."""
    found: set[str] = set()
    for program in programs:
        try:
            text = (folder / program).read_text('utf-8')
        except (OSError, UnicodeDecodeError):
            continue
        found.update(re.findall(r'(?m)^\s*(?:from|import)\s+(\w+)', text))
    return found
