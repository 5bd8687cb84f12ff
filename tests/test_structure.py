# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A stranger finds his way: small folders, names of one meaning, no circle."""

import ast
from collections import Counter
from collections import defaultdict
from collections.abc import Iterator
from collections.abc import Mapping
from functools import cache
from graphlib import CycleError
from graphlib import TopologicalSorter
from pathlib import Path
import subprocess

import pytest
from support.sources import modules
from support.sources import PACKAGE

# so that one worker parses the code
pytestmark = pytest.mark.xdist_group('sources')
#: How many modules of a folder a reader can take in.
MAXIMUM_MODULES = 14

Graph = Mapping[str, set[str]]


@cache
def names() -> dict[str, Path]:
    """Return the files of the modules by their full names."""
    found = {}
    for path in modules():
        parts = path.relative_to(PACKAGE.parent).with_suffix('').parts
        found['.'.join(parts).removesuffix('.__init__')] = path
    return found


def imported(tree: ast.AST) -> Iterator[str]:
    """Return the names that a module imports, wherever it does."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert not node.level, 'no relative imports'
            for alias in node.names:
                yield f'{node.module}.{alias.name}'


@cache
def imports() -> Graph:
    """Return the modules of the package that each of them imports."""
    graph: dict[str, set[str]] = {}
    for name, path in names().items():
        graph[name] = {_module(wanted) for wanted in imported(modules()[path])}
        graph[name] -= {name, ''}
    return graph


def _module(name: str) -> str:
    """Return the module that is imported, or that a name is imported from."""
    parent = name.rpartition('.')[0]
    return next((one for one in (name, parent) if one in names()), '')


def folded(graph: Graph, depth: int) -> Graph:
    """Return the graph of the folders that are at most that deep."""
    folders = {
        name: _folder(name, path.name == '__init__.py', depth)
        for name, path in names().items()
    }
    result: dict[str, set[str]] = defaultdict(set)
    for name, others in graph.items():
        result[folders[name]] |= {folders[other] for other in others}
    return {name: others - {name} for name, others in result.items()}


def _folder(name: str, is_package: bool, depth: int) -> str:
    parts = name.split('.') if is_package else name.split('.')[:-1]
    return '.'.join(parts[: depth + 1])


def circle(graph: Graph) -> list[str]:
    """Return one circle of a graph, or nothing."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as e:
        return list(e.args[1])
    return []


def test_no_folder_has_too_many_modules() -> None:
    count = Counter(
        path.parent.relative_to(PACKAGE)
        for path in modules()
        if path.name != '__init__.py'
    )
    assert {f: n for f, n in count.items() if n > MAXIMUM_MODULES} == {}


def test_each_module_has_a_name_of_its_own() -> None:
    count = Counter(
        path.name for path in modules() if path.name != '__init__.py'
    )
    assert [name for name, number in count.items() if number > 1] == []


def test_imports_and_circles_are_found() -> None:
    assert sum(map(len, imports().values())) > len(names())
    assert circle({'a': {'b'}, 'b': {'c'}, 'c': {'b'}})


def test_no_modules_import_one_another_in_a_circle() -> None:
    assert circle(imports()) == []


@pytest.mark.parametrize('depth', [1, 2])
def test_arrows_between_folders_go_one_way(depth: int) -> None:
    assert circle(folded(imports(), depth)) == []


def test_symlinks_stay_in_the_repository() -> None:
    root = PACKAGE.parent
    try:
        listed = subprocess.run(
            ['git', 'ls-files', '--stage', '-z'],
            cwd=root,
            capture_output=True,
            text=True,
            check=True,
        ).stdout
    except (OSError, subprocess.CalledProcessError):
        pytest.skip('this is no clone of the repository, or git is missing')
    links = [
        root / entry.partition('\t')[2]
        for entry in listed.split('\0')
        if entry.startswith('120000')
    ]
    for link in links:
        # a missing target and a circle are errors
        assert link.resolve(strict=True).is_relative_to(root.resolve()), link
