# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The import contract between the sub-packages, and links of the repository.

Each line lists the sub-packages that one of them may import.
"""

import ast
from collections.abc import Iterator
from pathlib import Path
import subprocess

import pytest
from support.sources import modules, PACKAGE

CORE = {'common', 'plan'}
ALLOWED = {
    'common': set[str](),
    'workspace': {'common'},
    'plan': {'common'},
    'language': CORE,
    'engine': CORE,
    'observers': CORE | {'engine'},
    'control': CORE | {'engine', 'observers'},
    'python_launch': CORE | {'engine', 'language'},
    'terminal': CORE | {'engine', 'observers', 'control'},
    'run': CORE | {'engine', 'observers', 'control', 'terminal'},
    'deployment': CORE | {'control', 'language'},
    'remote': CORE
    | {
        'deployment',
        'engine',
        'observers',
        'control',
        'language',
        'workspace',
        'run',
    },
    'service': CORE | {'engine', 'observers'},
    'watch': CORE | {'engine', 'language', 'workspace'},
    'sweep': CORE | {'engine', 'observers', 'run'},
}


def imported(tree: ast.AST) -> Iterator[str]:
    """Return the sub-packages that a module imports, wherever it does."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            parts = (node.module or '').split('.')
            if parts[0] == PACKAGE.name and parts[1:]:
                yield parts[1]


@pytest.mark.parametrize('name', ALLOWED)
def test_sub_package_imports_only_what_the_contract_allows(name: str) -> None:
    found = {
        f'{path.relative_to(PACKAGE)}: {other}'
        for path, tree in modules().items()
        if path.relative_to(PACKAGE).with_suffix('').parts[0] == name
        for other in imported(tree)
        if other not in ALLOWED[name] | {name}
    }
    assert found == set()


def test_symlinks_stay_in_the_repository() -> None:
    root: Path = PACKAGE.parent
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
