# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What follows from changes of files; `docs/watching.md` has the table.

Nothing is looked at here but what is given, and nothing is done.
"""

from collections.abc import Iterable
from collections.abc import Iterator
from collections.abc import Sequence
import os
from typing import Literal

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.watch.changes import Change
from colcon_yamllaunch.watch.knowledge import Knowledge
from colcon_yamllaunch.watch.knowledge import PackageUse
from colcon_yamllaunch.watch.knowledge import ProcessUse

#: What is to be done; `restart after build` waits until the packages of the
#: same batch are built, and is done whatever that brought.
Action = Literal['ignore', 'restart', 'build', 'restart after build', 'replan']

_PYTHON_SUFFIX = '.py'


@dataclass(frozen=True, slots=True)
class Consequence:
    """
    What follows from a change.

    :param names: Labels of what is restarted, in the order of the launch, or
      packages that are built
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
    """

    build: frozenset[str] = frozenset()
    replan: bool = False
    restart: tuple[str, ...] = ()
    after_build: tuple[str, ...] = ()

    @property
    def is_empty(self) -> bool:
        """Whether nothing is to be done."""
        return not (
            self.build or self.replan or self.restart or self.after_build
        )


def consequences(
    changes: Sequence[Change], knowledge: Knowledge
) -> tuple[Consequence, ...]:
    """Tell what follows from changes, in their order."""
    by_file: dict[tuple[str, str], list[Change]] = {}
    for change in changes:
        same = by_file.setdefault((change.real, change.kind), [])
        same.append(change)
    found: list[Consequence] = []
    for same in by_file.values():
        found += _of_file(same, knowledge)
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
    )


def _of_file(
    changes: Sequence[Change], knowledge: Knowledge
) -> list[Consequence]:
    """Tell what follows from the change of one file, whatever its names."""
    found = dict.fromkeys(_of_use(changes[0], knowledge))
    for change in changes:
        found.update(dict.fromkeys(_of_package(change, knowledge)))
    first = changes[0]
    if not any(one.action in ('replan', 'build') for one in found):
        # a build is followed by another look at the launch file, if need be
        if knowledge.is_plan_broken:
            reason = 'it may mend the launch file'
            found[Consequence(first, 'replan', (), reason)] = None
        elif knowledge.reads_more:
            reason = 'a program that the launch file runs may read it'
            found[Consequence(first, 'replan', (), reason)] = None
    if not found:
        reason = 'nothing in the launch uses it'
        return [Consequence(first, 'ignore', (), reason)]
    return list(found)


def _of_use(change: Change, knowledge: Knowledge) -> Iterator[Consequence]:
    """Tell what follows as the launch uses the file by itself."""
    real = change.real
    if real in knowledge.plan_files:
        yield Consequence(change, 'replan', (), 'the launch file reads it')
    runs = [p.label for p in knowledge.processes if p.program == real]
    if runs:
        reason = f'it is the program of {_listed(runs)}'
        if change.kind == 'deleted':
            # a fresh launch would not start, so nothing is stopped for it
            yield Consequence(change, 'replan', (), reason)
        else:
            yield Consequence(change, 'restart', tuple(runs), reason)
    names = [p.label for p in knowledge.processes if real in p.files]
    if not names:
        return
    reason = f'the plan names it for {_listed(names)}'
    yield Consequence(change, 'restart', tuple(names), reason)
    if change.kind in ('new', 'deleted') and real not in knowledge.plan_files:
        # a file with parameters that is not there is left out of the plan
        reason = 'whether it is there matters to the plan'
        yield Consequence(change, 'replan', (), reason)


def _of_package(change: Change, knowledge: Knowledge) -> Iterator[Consequence]:
    """Tell what follows as the file belongs to packages."""
    owner = knowledge.package_of(change.path)
    if owner is not None:
        yield from _of_source(change, *owner, knowledge)
    readers = sorted(
        package.name
        for package in knowledge.packages
        if not package.inputs.isdisjoint((change.path, change.real))
    )
    if readers:
        reason = f'{_listed(readers)} was built with it'
        yield Consequence(change, 'build', tuple(readers), reason)


def _of_source(
    change: Change, package: PackageUse, relative: str, knowledge: Knowledge
) -> Iterator[Consequence]:
    name = package.name
    is_live = relative in package.live
    if not is_live or change.kind == 'deleted':
        reason = f'{name} is built from it'
        if is_live:
            reason = f'{name} has installed a link to it'
        yield Consequence(change, 'build', (name,), reason)
    if relative in package.modules and change.kind != 'deleted':
        users = _importers(name, knowledge)
        if users and change.kind != 'mode':
            reason = f'it is a Python module of {name}'
            yield Consequence(change, 'restart', users, reason)
    elif relative in package.modules or (
        change.kind in ('new', 'deleted')
        and relative.endswith(_PYTHON_SUFFIX)
        and os.path.dirname(relative) in package.module_folders
    ):
        users = _importers(name, knowledge)
        if users:
            what = 'a new' if change.kind == 'new' else 'no more a'
            reason = f'it is {what} Python module of {name}'
            yield Consequence(change, 'restart after build', users, reason)


def _importers(package: str, knowledge: Knowledge) -> tuple[str, ...]:
    """Return what may have imported a module of a package."""
    return tuple(
        process.label
        for process in knowledge.processes
        if _may_import(process, package)
    )


def _may_import(process: ProcessUse, package: str) -> bool:
    return process.may_run_python and package in process.packages


def _listed(names: Sequence[str]) -> str:
    *others, last = names
    return f'{", ".join(others)} and {last}' if others else last
