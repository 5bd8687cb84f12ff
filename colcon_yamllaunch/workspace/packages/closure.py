# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Which packages of the workspace a launch needs."""

from collections import deque
from collections.abc import Iterable
from collections.abc import Iterator
from collections.abc import Mapping
from collections.abc import Sequence

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.workspace.packages.package import Package


def closure(packages: Iterable[Package], wanted: Iterable[str]) -> list[str]:
    """
    Return the packages to be built, each after those that it needs.

    These are the wanted ones and what they need to be built and to run,
    transitively. Names that are not in the workspace are left out, as what
    they stand for comes from an underlay. What only tests need is not in it.

    :raises WorkspaceError: when needed packages depend on each other in a
      circle or when two have the same name
    """
    known = index(packages)
    # a dict, as it finds a name fast
    order: dict[str, None] = {}
    for name in sorted(set(wanted)):
        if name in known and name not in order:
            _visit(name, known, order)
    return list(order)


def index(packages: Iterable[Package]) -> dict[str, list[Package]]:
    """Return the packages by name; a name may be used more than once."""
    known: dict[str, list[Package]] = {}
    for package in packages:
        known.setdefault(package.name, []).append(package)
    return known


def build_closure(
    known: Mapping[str, Sequence[Package]], name: str
) -> tuple[frozenset[str], frozenset[str]]:
    """
    Return the packages whose builds a package's build depends on.

    These are its build dependencies with all that these need: a package
    that builds on another one gets to see what that one exports. First come
    those in the workspace, then the names of others.

    :param known: All packages of the workspace, by name
    """
    found: set[str] = set()
    others: set[str] = set()
    pending = [
        needed
        for package in known.get(name, ())
        for needed in package.build_depends
    ]
    while pending:
        current = pending.pop()
        if current in found or current == name:
            continue
        if current not in known:
            others.add(current)
            continue
        found.add(current)
        for package in known[current]:
            pending.extend(package.build_depends | package.run_depends)
    return frozenset(found), frozenset(others)


def needed_by(
    packages: Iterable[Package], wanted: Iterable[str]
) -> dict[str, tuple[str, ...]]:
    """
    Tell why packages are in the closure of those that the launch uses.

    Return for each the shortest way to it: the names of a wanted package, of
    one that this needs and so on, up to itself.
    """
    known = index(packages)
    ways: dict[str, tuple[str, ...]] = {
        name: (name,) for name in sorted(set(wanted)) if name in known
    }
    pending = deque(ways)
    while pending:
        current = pending.popleft()
        for package in known[current]:
            for name in sorted(package.build_depends | package.run_depends):
                if name in known and name not in ways:
                    ways[name] = (*ways[current], name)
                    pending.append(name)
    return ways


def _visit(
    name: str, known: Mapping[str, list[Package]], order: dict[str, None]
) -> None:
    # depth first without recursion: a chain may be longer than Python's stack
    path = {name: _needs(name, known)}
    while path:
        current, pending = next(reversed(path.items()))
        for needed in pending:
            if needed in path:
                names = list(path)
                raise _circle([*names[names.index(needed) :], needed])
            if needed in known and needed not in order:
                path[needed] = _needs(needed, known)
                break
        else:
            del path[current]
            order[current] = None


def _needs(name: str, known: Mapping[str, list[Package]]) -> Iterator[str]:
    package = _only(known[name])
    return iter(sorted((package.build_depends | package.run_depends) - {name}))


def _only(packages: list[Package]) -> Package:
    if len({package.path for package in packages}) == 1:
        return packages[0]
    paths = ''.join(f'\n  {path}' for path in sorted(p.path for p in packages))
    raise WorkspaceError(
        f"several packages are named '{packages[0].name}':{paths}",
        'rename all but one, or put a file COLCON_IGNORE into the others',
    )


def _circle(names: list[str]) -> WorkspaceError:
    return WorkspaceError(
        f'packages depend on each other in a circle: {" -> ".join(names)}',
        'remove one of these dependencies from its package.xml',
    )
