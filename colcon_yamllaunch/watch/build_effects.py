# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What a build changed, and which processes it concerns.

The records of builds have the content of all that was built and installed, so
what was made anew and came out the same concerns nobody.
"""

from collections.abc import Iterable
from collections.abc import Iterator
from collections.abc import Mapping
import os

from colcon_yamllaunch.plan.labels import machine_of
from colcon_yamllaunch.plan.labels import MACHINE_SEPARATOR
from colcon_yamllaunch.remote.agent.builds_there import ANY_PACKAGE
from colcon_yamllaunch.watch.knowledge import Knowledge
from colcon_yamllaunch.watch.knowledge import ProcessUse
from colcon_yamllaunch.watch.package_uses import record_of
from colcon_yamllaunch.watch.package_uses import Workspace

#: What was built and installed of packages: for each file, behind all links,
#: what tells its content.
Built = Mapping[str, Mapping[str, str]]
#: Files that a build changed, with the packages that they belong to.
Changed = Mapping[str, str]

_LIBRARY = '.so'
_MODULES = ('.py', _LIBRARY)


def records(workspace: Workspace, names: Iterable[str]) -> Built:
    """Return what the last successful builds of some packages made."""
    if workspace.root is None:
        return {}
    return {name: _built(workspace, name) for name in names}


def changed_by_build(before: Built, after: Built) -> Changed:
    """
    Return the files that are others now, new or gone, behind all links.

    :param before: What was there of packages
    :param after: What is there of them now
    """
    return {
        path: name
        for name, now in after.items()
        for then in [before.get(name, {})]
        for path in then.keys() | now.keys()
        if then.get(path) != now.get(path)
    }


def touched_by(changed: Changed, knowledge: Knowledge) -> dict[str, str]:
    """
    Return what is restarted as its code was changed by a build, and why.

    They are labels of processes, in the order of the launch.
    """
    found: dict[str, str] = {}
    if not changed:
        return found
    for process in knowledge.processes:
        reason = next(_reasons(process, changed), None)
        if reason is not None:
            found[process.label] = reason
    return found


def _built(workspace: Workspace, name: str) -> dict[str, str]:
    record = record_of(workspace, name)
    if record is None:
        return {}
    colcon = workspace.colcon
    return {
        f'{folder}{os.sep}{path}': f'{found.digest} {found.executable:d}'
        for folder, files in (
            (os.path.realpath(colcon.install_base), record.installed),
            (os.path.realpath(colcon.build_base / name), record.products),
        )
        for path, found in files.items()
    }


def _reasons(process: ProcessUse, changed: Changed) -> Iterator[str]:
    machine = process.machine
    place = f' on {machine}' if machine else ''
    if process.program in changed:
        yield 'its program was built'
    for path in sorted(process.files.intersection(changed)):
        what = 'is another one' if machine else 'was installed'
        yield f'{os.path.basename(path)} {what}{place}'
    libraries = process.libraries
    if process.is_component:
        # its code is in the container
        return
    if libraries is not None:
        for path in sorted(libraries.intersection(changed)):
            yield f'{os.path.basename(path)}, which it uses, was built'
    for path, package in sorted(changed.items()):
        if machine_of(path) != (machine and machine + MACHINE_SEPARATOR):
            continue
        is_used = package in process.packages or package == ANY_PACKAGE
        if not is_used or not _is_module(path, package):
            continue
        is_library = _LIBRARY in os.path.basename(path)
        if is_library and libraries is None:
            # it may have ended before anybody looked
            name = os.path.basename(path)
            yield f'{name}, which it may use, was built{place}'
        elif not is_library and process.may_run_python:
            yield f'a Python module of {package} was installed{place}'


def _is_module(path: str, package: str) -> bool:
    name = os.path.basename(path)
    if not (name.endswith(_MODULES) or f'{_LIBRARY}.' in name):
        return False
    # programs, and what lies in the share folder, are no modules
    parts = path.split(os.sep)
    return 'share' not in parts and parts[-3:-1] != ['lib', package]
