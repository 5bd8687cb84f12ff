# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What follows from changes of files; `docs/watching.md` has the table.

Nothing is looked at here but what is given, and nothing is done.
"""

from collections.abc import Collection
from collections.abc import Iterable
from collections.abc import Iterator
from collections.abc import Sequence
from dataclasses import replace
import os
from typing import Literal

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.watch.changes import Change
from colcon_yamllaunch.watch.changes import Kind
from colcon_yamllaunch.watch.knowledge import Knowledge
from colcon_yamllaunch.watch.knowledge import PackageUse

#: What is to be done; `restart after build` waits until the packages of the
#: same batch are built, and is done whatever that brought; `keep` is that a
#: machine is not sent the change.
Action = Literal[
    'ignore', 'restart', 'build', 'restart after build', 'replan', 'keep'
]

_PYTHON_SUFFIX = '.py'
#: What a file may have been for a moment that is as it was.
_MEANWHILE: tuple[Kind, ...] = ('changed', 'deleted')


@dataclass(frozen=True, slots=True)
class Consequence:
    """
    What follows from a change.

    :param names: Labels of what is restarted, in the order of the launch,
      packages that are built, or machines that keep what they have
    :param reason: Why, as a part of a sentence
    """

    change: Change
    action: Action
    names: tuple[str, ...]
    reason: str


@dataclass(frozen=True, slots=True)
class Steps:
    """
    What follows from changes that count as one.

    :param build: Packages that are stale, as far as can be told without
      looking
    :param replan: Whether the launch file is to be evaluated again
    :param restart: The labels of what is restarted, in the order of the launch
    :param after_build: Those that are restarted once the build has succeeded
    :param kept: Machines that are not sent the changes, each with the reason
    """

    build: frozenset[str] = frozenset()
    replan: bool = False
    restart: tuple[str, ...] = ()
    after_build: tuple[str, ...] = ()
    kept: tuple[str, ...] = ()

    @property
    def is_empty(self) -> bool:
        """Whether nothing is to be done, or to be said."""
        return self == Steps()


def consequences(
    changes: Sequence[Change], knowledge: Knowledge
) -> tuple[Consequence, ...]:
    """Tell what follows from changes, in their order."""
    by_file: dict[tuple[str, str], list[Change]] = {}
    for change in changes:
        same = by_file.setdefault((change.real, change.kind), [])
        same.append(change)
    uses = _Uses(knowledge)
    found: list[Consequence] = []
    for same in by_file.values():
        found += uses.of_file(same)
    return tuple(found)


def missed(
    again: Iterable[Change],
    knowledge: Knowledge,
    *,
    failed: Collection[str],
    has_looked: bool,
) -> tuple[Consequence, ...]:
    """
    Tell what follows for who may have read files while they were others.

    :param again: Files that are as they were, but were written or away
    :param failed: The labels of what may have failed by that
    :param has_looked: Whether the launch may have been prepared meanwhile
    """
    found: dict[Consequence, None] = {}
    for change in again:
        as_others = [change._replace(kind=kind) for kind in _MEANWHILE]
        for one in consequences(as_others, knowledge):
            names = tuple(
                name
                for name in one.names
                if one.action == 'build' or name in failed
            )
            if has_looked if one.action in ('build', 'replan') else names:
                found[replace(one, change=change, names=names)] = None
    return tuple(found)


def steps(found: Iterable[Consequence], knowledge: Knowledge) -> Steps:
    """Return what is to be done about all of them together."""
    names: dict[Action, set[str]] = {}
    for one in found:
        names.setdefault(one.action, set()).update(one.names)
    late = names.get('restart after build', set())
    return Steps(
        frozenset(names.get('build', ())),
        'replan' in names,
        knowledge.labels(names.get('restart', set()) - late),
        knowledge.labels(late),
        tuple(
            f'{machine} ({knowledge.kept[machine]})'
            for machine in sorted(names.get('keep', ()))
        ),
    )


class _Uses:
    """Who uses which files."""

    def __init__(self, knowledge: Knowledge) -> None:
        self._knowledge = knowledge
        self._programs: dict[str, list[str]] = {}
        self._named: dict[str, list[str]] = {}
        for process in knowledge.processes:
            if process.program is not None:
                labels = self._programs.setdefault(process.program, [])
                labels.append(process.label)
            for path in process.files:
                self._named.setdefault(path, []).append(process.label)
        self._packages = {p.path: p for p in knowledge.packages}
        self._readers: dict[str, list[str]] = {}
        for package in knowledge.packages:
            for path in package.inputs:
                self._readers.setdefault(path, []).append(package.name)

    def of_file(self, changes: Sequence[Change]) -> list[Consequence]:
        """Tell what follows from the change of one file, by all its names."""
        # the name in a package tells more than where a link leads
        first = next((c for c in changes if self._owner(c)), changes[0])
        found = dict.fromkeys(self._of_use(first))
        for change in changes:
            found.update(dict.fromkeys(self._of_package(change)))
        if not any(one.action in ('replan', 'build') for one in found):
            # a build is followed by another look at the launch file
            if self._knowledge.is_plan_broken:
                reason = 'it may mend the launch file'
                found[Consequence(first, 'replan', (), reason)] = None
            elif self._knowledge.reads_more:
                reason = 'a program that the launch file runs may read it'
                found[Consequence(first, 'replan', (), reason)] = None
        if not found:
            reason = 'nothing in the launch uses it'
            return [Consequence(first, 'ignore', (), reason)]
        return list(found)

    def _of_use(self, change: Change) -> Iterator[Consequence]:
        """Tell what follows as the launch uses the file by itself."""
        real = change.real
        is_read = real in self._knowledge.plan_files
        if is_read:
            yield Consequence(change, 'replan', (), 'the launch file reads it')
        labels = self._programs.get(real, ())
        if labels:
            reason = f'it is the program of {_listed(labels)}'
            if change.kind == 'deleted':
                # a fresh launch would not start, so nothing is stopped for it
                yield Consequence(change, 'replan', (), reason)
            else:
                yield Consequence(change, 'restart', tuple(labels), reason)
        if not self._knowledge.files_there.isdisjoint((real, change.path)):
            reason = 'what runs on another machine names it'
            yield Consequence(change, 'replan', (), reason)
        labels = self._named.get(real, ())
        if not labels:
            return
        reason = f'the plan names it for {_listed(labels)}'
        yield Consequence(change, 'restart', tuple(labels), reason)
        if change.kind in ('new', 'deleted') and not is_read:
            # a file with parameters that is not there is left out of the plan
            reason = 'whether it is there matters to the plan'
            yield Consequence(change, 'replan', (), reason)

    def _of_package(self, change: Change) -> Iterator[Consequence]:
        """Tell what follows as the file belongs to packages."""
        package = self._owner(change)
        if package is not None:
            found = [*self._of_source(change, package)]
            yield from found
            is_built = any(one.action == 'build' for one in found)
            yield from self._of_machines(change, package, is_built=is_built)
        readers = {
            name
            for path in (change.path, change.real)
            for name in self._readers.get(path, ())
        }
        if readers:
            names = tuple(sorted(readers))
            reason = f'{_listed(names)} was built with it'
            yield Consequence(change, 'build', names, reason)

    def _owner(self, change: Change) -> PackageUse | None:
        """Return the package that has a file, by its name."""
        folder = change.path
        # one may lie in another
        while folder := folder.rpartition(os.sep)[0]:
            if folder in self._packages:
                return self._packages[folder]
        return None

    def _of_source(
        self, change: Change, package: PackageUse
    ) -> Iterator[Consequence]:
        name = package.name
        relative = change.path[len(package.path) + 1 :]
        is_live = relative in package.live
        if not is_live or change.kind == 'deleted':
            reason = f'{name} is built from it'
            if is_live:
                reason = f'{name} has installed a link to it'
            yield Consequence(change, 'build', (name,), reason)
        is_module = relative in package.modules
        if is_module and change.kind != 'deleted':
            if change.kind != 'mode':
                reason = f'it is a Python module of {name}'
                yield from self._of_importers(change, 'restart', name, reason)
        elif is_module or (
            change.kind in ('new', 'deleted')
            and relative.endswith(_PYTHON_SUFFIX)
            and os.path.dirname(relative) in package.module_folders
        ):
            is_new = change.kind == 'new'
            what = 'it is a new' if is_new else 'it was a'
            reason = f'{what} Python module of {name}'
            late: Action = 'restart after build'
            yield from self._of_importers(change, late, name, reason)

    def _of_machines(
        self, change: Change, package: PackageUse, *, is_built: bool
    ) -> Iterator[Consequence]:
        """Tell what follows as other machines need the package."""
        kept = self._knowledge.kept
        sent = [m for m in package.machines if m not in kept]
        if sent and not is_built:
            # what is linked here is a file of its own there
            reason = f'{package.name} is also on {_listed(sent)}'
            yield Consequence(change, 'build', (package.name,), reason)
        if change.real in self._knowledge.plan_files:
            # it is evaluated here
            return
        for machine in package.machines:
            if machine in kept:
                reason = f'it is sent nothing ({kept[machine]})'
                yield Consequence(change, 'keep', (machine,), reason)

    def _of_importers(
        self, change: Change, action: Action, package: str, reason: str
    ) -> Iterator[Consequence]:
        """Tell what follows for what may have imported from a package."""
        labels = tuple(
            process.label
            for process in self._knowledge.processes
            if process.may_run_python
            and not process.machine
            and package in process.packages
        )
        if labels:
            yield Consequence(change, action, labels, reason)


def _listed(names: Sequence[str]) -> str:
    *others, last = names
    return f'{", ".join(others)} and {last}' if others else last
