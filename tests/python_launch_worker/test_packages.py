# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Packages are found as if the workspace were built."""

from collections.abc import Iterator
import importlib
from pathlib import Path
import sys
from typing import Any

from colcon_yamllaunch.python_launch.worker.imports import when_imported
from colcon_yamllaunch.python_launch.worker.packages import Packages
import pytest


@pytest.fixture
def packages() -> Packages:
    visitor: Any = None
    packages = Packages(visitor)
    one = {'prefix': '/merged', 'built': False}
    apart = {'prefix': '/ws/install/apart', 'built': False}
    packages.set({'apart': apart, 'one': one, 'two': {**one, 'built': True}})
    return packages


@pytest.fixture
def library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    (tmp_path / 'some_library').mkdir()
    (tmp_path / 'some_library/__init__.py').write_text('')
    (tmp_path / 'some_library/inner.py').write_text('value = 1\n')
    monkeypatch.syspath_prepend(tmp_path)
    yield
    for name in ('some_library', 'some_library.inner'):
        sys.modules.pop(name, None)


@pytest.mark.parametrize(
    ('error', 'package'),
    [
        (FileNotFoundError(2, 'no', '/ws/install/apart/x/y'), 'apart'),
        (FileNotFoundError(2, 'no', '/merged/share/one/a'), 'one'),
        (FileNotFoundError(2, 'no', '/merged/lib/two/a'), 'two'),
        (FileNotFoundError(2, 'no', '/merged/x'), None),
        (FileNotFoundError(2, 'no', '/elsewhere/one'), None),
        (ModuleNotFoundError('no', name='one.tools'), 'one'),
        (ModuleNotFoundError('no', name='yaml'), None),
        (ValueError(), None),
    ],
)
def test_the_package_that_an_error_is_about(
    packages: Packages, error: Exception, package: str | None
) -> None:
    assert packages.missing(error) == package


@pytest.mark.usefixtures('library')
def test_something_is_done_when_a_module_is_imported() -> None:
    found: list[object] = []
    name = 'some_library.inner'
    when_imported(name, lambda module: found.append(module.value))
    importlib.import_module('some_library')
    assert found == []
    importlib.import_module(name)
    assert found == [1]
    when_imported(name, lambda module: found.append(module.value))
    assert found == [1, 1]
