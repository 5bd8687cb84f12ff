# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Packages are found as if the workspace were built."""

from collections.abc import Iterator
import importlib
from pathlib import Path
import sys
from types import SimpleNamespace
from typing import Any

from colcon_yamllaunch.python_launch.worker.packages import Packages
from colcon_yamllaunch.python_launch.worker.packages import when_imported
import pytest


class Visitor:
    """What is used of the visitor."""

    def __init__(self) -> None:
        self.told: list[tuple[str, dict[str, Any]]] = []
        self.answer: dict[str, Any] = {}

    def say(self, what: str, **fields: Any) -> None:
        self.told.append((what, fields))

    def ask(self, what: str, **fields: Any) -> dict[str, Any]:
        self.told.append((what, fields))
        return self.answer

    def here(self) -> list[object]:
        return ['/a.launch.py', 1, 1]

    def text_of(self, text: Any) -> str:
        return str(text)


@pytest.fixture
def visitor() -> Visitor:
    return Visitor()


@pytest.fixture
def packages(visitor: Visitor) -> Packages:
    found: Any = visitor
    packages = Packages(found)
    packages.set(
        {
            'apart': {'prefix': '/ws/install/apart', 'built': False},
            'one': {'prefix': '/merged', 'built': False},
            'two': {'prefix': '/merged', 'built': True},
        }
    )
    return packages


@pytest.fixture
def index(packages: Packages) -> Any:
    """Return an ament index, without `apart` and `nowhere`."""

    def find(package_name: str) -> str:
        if package_name in ('apart', 'nowhere'):
            raise LookupError(package_name)
        return '/there'

    module = SimpleNamespace(
        get_package_prefix=find, __name__='no_index.packages'
    )
    packages._wrap_index(module)
    return module


@pytest.fixture
def library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    (tmp_path / 'some_library').mkdir()
    (tmp_path / 'some_library/__init__.py').write_text('')
    (tmp_path / 'some_library/inner.py').write_text('value = 1\n')
    monkeypatch.syspath_prepend(tmp_path)
    yield
    for name in ('some_library', 'some_library.inner'):
        sys.modules.pop(name, None)


def test_a_package_that_is_not_built_is_where_it_will_be(
    index: Any, visitor: Visitor, packages: Packages
) -> None:
    assert index.get_package_prefix('two') == '/there'
    assert index.get_package_prefix('apart') == '/ws/install/apart'
    assert index.get_package_prefix('apart') == '/ws/install/apart'
    named = [fields['name'] for what, fields in visitor.told]
    assert named == ['two', 'apart']
    # its files may be what is missing
    assert packages.missing(ValueError()) == 'apart'


def test_a_package_that_nobody_has_is_missing(
    index: Any, visitor: Visitor, packages: Packages
) -> None:
    with pytest.raises(LookupError) as info:
        index.get_package_prefix('nowhere')
    assert packages.missing(info.value) == 'nowhere'
    wrapping = RuntimeError()
    wrapping.__cause__ = info.value
    assert packages.missing(wrapping) == 'nowhere'
    assert visitor.told == []


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


def test_a_file_is_looked_for_where_it_will_come_from(
    packages: Packages, visitor: Visitor, tmp_path: Path
) -> None:
    source = str(tmp_path / 'p.yaml')
    visitor.answer = {'path': source}
    installed = '/merged/share/one/p.yaml'
    assert packages.source(installed) == source
    assert packages.source(installed) == source
    assert visitor.told == [('locate', {'path': installed})]
    assert packages.installed(source) == installed
    assert packages.installed('/else') == '/else'
    assert packages.source('/nowhere/p.yaml') == '/nowhere/p.yaml'
    assert packages.source('relative.yaml') == 'relative.yaml'


def test_a_file_that_nobody_knows_stays_where_it_is(
    packages: Packages, visitor: Visitor
) -> None:
    visitor.answer = {'path': None}
    path = '/merged/share/one/p.yaml'
    assert packages.source(path) == path
    assert packages.installed(path) == path


def test_an_executable_that_is_not_built_is_where_it_will_be(
    packages: Packages, visitor: Visitor
) -> None:
    class ExecutableInPackage:
        def __init__(self, package: str, executable: str) -> None:
            self.package = package
            self.executable = executable

        def perform(self, _context: object) -> str:
            raise RuntimeError('no such executable')

    packages._wrap_executable(
        SimpleNamespace(ExecutableInPackage=ExecutableInPackage)
    )
    executable = ExecutableInPackage('one', 'talker')
    assert executable.perform(None) == '/merged/lib/one/talker'
    ((what, fields),) = visitor.told
    assert what == 'executable'
    assert fields['path'] == '/merged/lib/one/talker'
    with pytest.raises(RuntimeError):
        ExecutableInPackage('other', 'talker').perform(None)


@pytest.mark.usefixtures('library')
def test_something_is_done_when_a_module_is_imported() -> None:
    found: list[object] = []
    when_imported(
        'some_library.inner', lambda module: found.append(module.value)
    )
    importlib.import_module('some_library')
    assert found == []
    importlib.import_module('some_library.inner')
    assert found == [1]
    when_imported(
        'some_library.inner', lambda module: found.append(module.value)
    )
    assert found == [1, 1]
