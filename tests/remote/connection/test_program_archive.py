# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Machines are sent what runs there, all of it, and little more."""

import ast
from collections.abc import Iterator
import json
import subprocess
import sys
import zlib

from colcon_yamllaunch.remote.connection.bootstrap import (
    program_archive,
    program_files,
)
from support.sources import PACKAGE

#: Bytes that a slow link takes some seconds for, once.
SMALL = 400_000


def imported(tree: ast.AST) -> Iterator[str]:
    """Return the modules that one imports when it runs, wherever it does."""
    if isinstance(tree, ast.If) and ast.unparse(tree.test) == 'TYPE_CHECKING':
        return
    if isinstance(tree, ast.Import):
        yield from (alias.name for alias in tree.names)
    elif isinstance(tree, ast.ImportFrom):
        assert tree.module
        yield tree.module
        yield from (f'{tree.module}.{alias.name}' for alias in tree.names)
    for child in ast.iter_child_nodes(tree):
        yield from imported(child)


def test_modules_need_only_the_standard_library() -> None:
    known = {*sys.stdlib_module_names, 'colcon_yamllaunch', '__future__'}
    # other Pythons run these: that of ROS, and that of the colcon there
    others = (
        'engine/ros_client.py',
        'workspace/colcon/',
        'workspace/packages/package.py',
    )
    more = {
        (name, module)
        for name, text in program_files().items()
        if not name.startswith(others)
        for module in imported(ast.parse(text))
        if module.partition('.')[0] not in known
    }
    assert more == set()


def test_every_imported_module_is_sent() -> None:
    files = program_files()
    for name, text in files.items():
        wanted = set()
        for module in imported(ast.parse(text)):
            path = '/'.join(module.split('.')[1:])
            for file in (f'{path}.py', f'{path}/__init__.py'):
                if (
                    module.startswith('colcon_yamllaunch.')
                    and (PACKAGE / file).is_file()
                ):
                    wanted.add(file)
        assert wanted <= files.keys(), name


def test_archive_is_small_and_reproducible() -> None:
    archive = program_archive()
    assert len(archive.data) < SMALL
    assert json.loads(zlib.decompress(archive.data)).keys() == {
        f'colcon_yamllaunch/{name}' for name in program_files()
    }
    assert not any(
        name.startswith(
            ('verb/', 'terminal/full_screen/', 'watch/', 'remote/machine_link')
        )
        for name in program_files()
    )
    code = (
        'from colcon_yamllaunch.remote.connection.bootstrap '
        'import program_archive; print(program_archive().digest)'
    )
    digest = subprocess.check_output([sys.executable, '-c', code], text=True)
    assert digest.strip() == archive.digest
