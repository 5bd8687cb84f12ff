# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Imports of packages that a package does not declare."""

from pathlib import Path

from colcon_yamllaunch.workspace.packages.package import Package
from colcon_yamllaunch.workspace.packages.python_modules import (
    certain_imports,
    undeclared_imports,
    undeclared_owner,
)


def package(root: Path, name: str, *needs: str, **files: str) -> Package:
    folder = root / name
    folder.mkdir()
    for file, text in files.items():
        path = folder / file.replace('__', '/', 1).replace('_py', '.py')
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
    return Package(
        name, folder, 'ros.ament_cmake', frozenset(), frozenset(needs)
    )


def test_only_what_fails_for_certain_is_imported_for_certain(
    tmp_path: Path,
) -> None:
    text = 'import a.b, c\nfrom . import d\ntry:\n    import e\nexcept: 0\n'
    script = tmp_path / 'node.py'
    script.write_text(text)
    assert [name for name, _ in certain_imports(script)] == ['a', 'c']
    for other in (f'import sys\nsys.path.append(1)\n{text}', 'import', '\0'):
        script.write_text(other)
        assert list(certain_imports(script)) == []


def test_undeclared_imports(tmp_path: Path) -> None:
    maps = package(tmp_path, 'maps')
    (maps.path / 'map_tools').mkdir()
    (maps.path / 'map_tools/__init__.py').touch()
    msgs = package(tmp_path, 'my_msgs')
    user = package(
        tmp_path,
        'user',
        'rclpy',
        node_py='import os, rclpy\n\nif os:\n    from map_tools.a import b\n',
        scripts__run_py='from my_msgs.msg import A\nfrom . import my_msgs\n',
        test__test_py='import my_msgs\n',
        broken_py='import my_msgs\nthis is no Python\n',
    )
    everyone = (maps, msgs, user)
    found = [
        (f.path.name, f.line, f.column, f.module, f.owner)
        for f in undeclared_imports(user, everyone)
    ]
    assert found == [
        ('node.py', 4, 5, 'map_tools', 'maps'),
        ('run.py', 1, 1, 'my_msgs', 'my_msgs'),
    ]


def test_what_is_declared_or_nobodys_is_not_named(tmp_path: Path) -> None:
    msgs = package(tmp_path, 'my_msgs')
    user = package(tmp_path, 'user', 'my_msgs')
    assert undeclared_owner('my_msgs', user, (msgs, user)) is None
    assert undeclared_owner('user', user, (msgs, user)) is None
    assert undeclared_owner('numpy', user, (msgs, user)) is None
    assert undeclared_owner('user', msgs, (msgs, user)) == 'user'
