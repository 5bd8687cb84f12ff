# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What follows from changes of files and from builds, as data.

`docs/watching.md` has the table. Nothing here reads files or acts.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
import os
from typing import Literal, TypeAlias

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.plan.labels import (
    ANY_PACKAGE,
    machine_of,
    MACHINE_SEPARATOR,
)
from colcon_yamllaunch.plan.position import shown_path
from colcon_yamllaunch.watch.dependencies import (
    Dependencies,
    PackageDependencies,
    ProcessDependencies,
    Products,
)
from colcon_yamllaunch.watch.watched_files import Change, Kind

#: What to do; `restart after build` waits until the packages of the same batch
#: are built, whether or not the build changes anything; `keep` means that a
#: machine does not receive the change.
Action = Literal[
    'ignore', 'restart', 'build', 'restart after build', 'replan', 'keep'
]

_PYTHON_SUFFIX = '.py'
_LIBRARY = '.so'
_PYTHON_LIBRARY = '/libpython'
_MODULES = (_PYTHON_SUFFIX, _LIBRARY)
#: What may have happened to a file in between that was rewritten unchanged.
_MEANWHILE: tuple[Kind, ...] = ('changed', 'deleted')
_EVENTS = {
    'new': 'is new',
    'changed': 'changed',
    'deleted': 'was deleted',
    'mode': 'can be run now, or no more',
    'again': 'changed, and changed back',
}

_PHRASES: Mapping[Action, str] = {
    'ignore': 'nothing to do',
    'build': 'build {}',
    'replan': 'evaluate the launch file',
    'restart': 'restart {}',
    'restart after build': 'restart {} after the build',
    'keep': 'nothing on {}',
}


@dataclass(frozen=True, slots=True)
class Consequence:
    """
    What follows from a change.

    :param names: The labels to restart, in the order of the launch, the
      packages to build, or the machines that keep their files
    :param reason: Why, as a part of a sentence
    """

    change: Change
    action: Action
    names: tuple[str, ...]
    reason: str


#: A consequence without the change.
_Result: TypeAlias = tuple[Action, tuple[str, ...], str]


@dataclass(frozen=True, slots=True)
class Steps:
    """
    What to do about the changes of one batch.

    :param build: The packages that are probably stale
    :param replan: Whether to evaluate the launch file again
    :param restart: The labels to restart, in the order of the launch
    :param after_build: The labels to restart once the build has succeeded
    :param kept: The machines that do not receive the changes, each with the
      reason
    """

    build: frozenset[str] = frozenset()
    replan: bool = False
    restart: tuple[str, ...] = ()
    after_build: tuple[str, ...] = ()
    kept: tuple[str, ...] = ()


def consequences(
    changes: Sequence[Change], dependencies: Dependencies
) -> tuple[Consequence, ...]:
    """Return what follows from changes, in their order."""
    by_file: dict[tuple[str, str], list[Change]] = {}
    for change in changes:
        same = by_file.setdefault((change.real, change.kind), [])
        same.append(change)
    index = _Index(dependencies)
    found: list[Consequence] = []
    for same in by_file.values():
        found += index.of_file(same)
    return tuple(found)


def after_rewrite(
    rewritten: Iterable[Change],
    dependencies: Dependencies,
    *,
    failed: Collection[str],
    has_prepared: bool,
) -> tuple[Consequence, ...]:
    """
    Return what follows from files that were different only for a moment.

    A process or job that read one in that moment may have failed.

    :param rewritten: The files, which now have their former content
    :param failed: The labels of what may have failed because of that
    :param has_prepared: Whether a job may have read the files meanwhile
    """
    found: dict[Consequence, None] = {}
    for change in rewritten:
        as_others = [change._replace(kind=kind) for kind in _MEANWHILE]
        for one in consequences(as_others, dependencies):
            names = tuple(
                name
                for name in one.names
                if one.action == 'build' or name in failed
            )
            if has_prepared if one.action in ('build', 'replan') else names:
                found[replace(one, change=change, names=names)] = None
    return tuple(found)


def steps(found: Iterable[Consequence], dependencies: Dependencies) -> Steps:
    """Return what to do about all consequences of one batch."""
    names: dict[Action, set[str]] = {}
    for one in found:
        names.setdefault(one.action, set()).update(one.names)
    late = names.get('restart after build', set())
    return Steps(
        frozenset(names.get('build', ())),
        'replan' in names,
        dependencies.labels(names.get('restart', set()) - late),
        dependencies.labels(late),
        tuple(
            f'{machine} ({dependencies.remote.unsynced[machine]})'
            for machine in sorted(names.get('keep', ()))
        ),
    )


def changed_products(before: Products, after: Products) -> dict[str, str]:
    """Return the changed, new and removed files, with their packages."""
    return {
        # without the machine, as in `arm│my_pkg`
        path: name.removeprefix(machine_of(name))
        for name, now in after.items()
        for then in [before.get(name, {})]
        for path in then.keys() | now.keys()
        if then.get(path) != now.get(path)
    }


def affected_by_build(
    changed: Mapping[str, str],
    dependencies: Dependencies,
    libraries: Mapping[str, frozenset[str]],
) -> dict[str, str]:
    """
    Return the labels whose code a build changed, each with the reason.

    :param changed: The changed products, see :func:`changed_products`
    :param libraries: The files that are mapped into processes, or were when
      they were last examined, by label
    """
    return {
        process.label: reason
        for process in (dependencies.processes if changed else ())
        for mapped in [libraries.get(process.label)]
        if (reason := next(_reasons(process, changed, mapped), None))
    }


def why_lines(found: Iterable[Consequence], cwd: str = '') -> Iterator[str]:
    """
    Iterate over lines that say what follows from changes, and why.

    :param cwd: The folder that paths are shown from
    """
    by_change: dict[Change, list[str]] = {}
    for one in found:
        what = _PHRASES[one.action].format(', '.join(one.names))
        texts = by_change.setdefault(one.change, [])
        texts.append(f'{what}, as {one.reason}')
    for change, texts in by_change.items():
        path = one_line(shown_path(change.path, cwd))
        yield f'{path} {_EVENTS[change.kind]}: {"; ".join(texts)}'


class _Index:
    """The processes and packages that use each file."""

    def __init__(self, dependencies: Dependencies) -> None:
        self._dependencies = dependencies
        self._programs: dict[str, list[str]] = {}
        self._named: dict[str, list[str]] = {}
        for process in dependencies.processes:
            if process.program is not None:
                labels = self._programs.setdefault(process.program, [])
                labels.append(process.label)
            for path in process.files:
                self._named.setdefault(path, []).append(process.label)
        files = dependencies.remote.files.values()
        self._remote_files = frozenset[str]().union(*files)
        self._packages = {p.path: p for p in dependencies.packages}
        self._readers: dict[str, list[str]] = {}
        for package in dependencies.packages:
            for path in package.inputs:
                self._readers.setdefault(path, []).append(package.name)

    def of_file(self, changes: Sequence[Change]) -> list[Consequence]:
        """Return what follows from the change of a file with all its names."""
        # a name in a package says more than the target of a link
        first = next((c for c in changes if self._owner(c)), changes[0])
        found = {Consequence(first, *one): None for one in self._of_use(first)}
        for change in changes:
            for one in self._of_package(change):
                found[Consequence(change, *one)] = None
        if not any(one.action in ('replan', 'build') for one in found):
            # after a build, the launch file is evaluated again, too
            reason = ''
            if self._dependencies.is_plan_broken:
                reason = 'it may mend the launch file'
            elif self._dependencies.reads_more:
                reason = 'a program that the launch file runs may read it'
            if reason:
                found[Consequence(first, 'replan', (), reason)] = None
        if not found:
            reason = 'nothing in the launch uses it'
            return [Consequence(first, 'ignore', (), reason)]
        return list(found)

    def _of_use(self, change: Change) -> Iterator[_Result]:
        """Iterate over what follows from the plan's use of the file."""
        real = change.real
        is_read = real in self._dependencies.plan_files
        if is_read:
            yield 'replan', (), 'the launch file reads it'
        labels = tuple(self._programs.get(real, ()))
        if labels:
            reason = f'it is the program of {_listed(labels)}'
            if change.kind == 'deleted':
                # a fresh launch would fail, so the process is not stopped
                yield 'replan', (), reason
            else:
                yield 'restart', labels, reason
        if not self._remote_files.isdisjoint((real, change.path)):
            yield 'replan', (), 'what runs on another machine names it'
        labels = tuple(self._named.get(real, ()))
        if not labels:
            return
        yield 'restart', labels, f'the plan names it for {_listed(labels)}'
        if change.kind in ('new', 'deleted') and not is_read:
            # the plan omits a parameter file that does not exist
            yield 'replan', (), 'whether it is there matters to the plan'

    def _of_package(self, change: Change) -> Iterator[_Result]:
        """Iterate over what follows from the packages of the file."""
        package = self._owner(change)
        if package is not None:
            found = [*self._of_source(change, package)]
            yield from found
            is_built = any(action == 'build' for action, _, _ in found)
            yield from self._of_machines(change, package, is_built=is_built)
        readers = {
            name
            for path in (change.path, change.real)
            for name in self._readers.get(path, ())
        }
        if readers:
            names = tuple(sorted(readers))
            yield 'build', names, f'{_listed(names)} was built with it'

    def _owner(self, change: Change) -> PackageDependencies | None:
        """Return the package whose source folder has the file."""
        folder = change.path
        # a package may lie in another
        while folder := folder.rpartition(os.sep)[0]:
            if folder in self._packages:
                return self._packages[folder]
        return None

    def _of_source(
        self, change: Change, package: PackageDependencies
    ) -> Iterator[_Result]:
        name = package.name
        relative = change.path[len(package.path) + 1 :]
        is_live = relative in package.live
        if not is_live or change.kind == 'deleted':
            reason = f'{name} is built from it'
            if is_live:
                reason = f'{name} has installed a link to it'
            yield 'build', (name,), reason
        is_module = relative in package.modules
        action: Action = 'restart after build'
        if is_module and change.kind not in ('deleted', 'mode'):
            action, what = 'restart', 'it is a'
        elif change.kind in ('new', 'deleted') and (
            is_module
            or (
                relative.endswith(_PYTHON_SUFFIX)
                and os.path.dirname(relative) in package.module_folders
            )
        ):
            what = 'it is a new' if change.kind == 'new' else 'it was a'
        else:
            return
        importers = tuple(
            process.label
            for process in self._dependencies.processes
            if process.may_run_python
            and not process.machine
            and name in process.packages
        )
        if importers:
            yield action, importers, f'{what} Python module of {name}'

    def _of_machines(
        self, change: Change, package: PackageDependencies, *, is_built: bool
    ) -> Iterator[_Result]:
        """Iterate over what follows for other machines with the package."""
        remote = self._dependencies.remote
        kept = remote.unsynced
        machines = [m for m, p in remote.packages.items() if package.name in p]
        sent = [m for m in machines if m not in kept]
        if sent and not is_built:
            # a machine has copies of the files that are linked here
            reason = f'{package.name} is also on {_listed(sent)}'
            yield 'build', (package.name,), reason
        if change.real in self._dependencies.plan_files:
            # launch files are evaluated here
            return
        for machine in machines:
            if machine in kept:
                reason = f'it is sent nothing ({kept[machine]})'
                yield 'keep', (machine,), reason


def _listed(names: Sequence[str]) -> str:
    *others, last = names
    return f'{", ".join(others)} and {last}' if others else last


def _reasons(
    process: ProcessDependencies,
    changed: Mapping[str, str],
    libraries: frozenset[str] | None,
) -> Iterator[str]:
    machine = process.machine
    place = f' on {machine}' if machine else ''
    if process.program in changed:
        yield 'its program was built'
    for path in sorted(process.files.intersection(changed)):
        what = 'is another one' if machine else 'was installed'
        yield f'{os.path.basename(path)} {what}{place}'
    if process.is_component:
        # the container has its code
        return
    for path in sorted((libraries or set()).intersection(changed)):
        yield f'{os.path.basename(path)}, which it uses, was built'
    runs_python = process.may_run_python or any(
        _PYTHON_LIBRARY in path for path in libraries or ()
    )
    for path, package in sorted(changed.items()):
        if machine_of(path) != (machine and machine + MACHINE_SEPARATOR):
            continue
        is_used = package in process.packages or package == ANY_PACKAGE
        if not is_used or not _is_module(path, package):
            continue
        is_library = _LIBRARY in os.path.basename(path)
        if is_library and libraries is None:
            # it may have ended before its libraries were examined
            name = os.path.basename(path)
            yield f'{name}, which it may use, was built{place}'
        elif not is_library and runs_python:
            yield f'a Python module of {package} was installed{place}'


def _is_module(path: str, package: str) -> bool:
    name = os.path.basename(path)
    if not (name.endswith(_MODULES) or f'{_LIBRARY}.' in name):
        return False
    # programs and files in the share folder are no modules
    parts = path.split(os.sep)
    return 'share' not in parts and parts[-3:-1] != ['lib', package]
