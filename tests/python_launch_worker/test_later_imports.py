# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is imported in vain takes no time, and is else as it would be."""

from collections.abc import Iterator
import importlib
from pathlib import Path
import sys
from types import ModuleType

from colcon_yamllaunch.python_launch.worker import imports
import pytest

NAME = 'many_arrays'


@pytest.fixture
def ran(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[str]]:
    """Return which modules were run."""
    recorder = ModuleType('recorder')
    names: list[str] = []
    recorder.__dict__['ran'] = names.append
    monkeypatch.setitem(sys.modules, 'recorder', recorder)
    monkeypatch.setattr(imports, 'RUN_LATER', NAME)
    monkeypatch.setattr(sys, 'meta_path', list(sys.meta_path))
    imports.run_later()
    yield names
    for name in [n for n in sys.modules if n.startswith(NAME)]:
        del sys.modules[name]


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a package that imports one of its two modules."""
    folder = tmp_path / NAME
    folder.mkdir()
    for name, text in {
        '__init__': f'from {NAME} import inner\nvalue = inner.value\n',
        'inner': 'value = 7\n',
        'other': f'from {NAME} import value\n',
    }.items():
        text = f'import recorder\nrecorder.ran(__name__)\n{text}'
        (folder / f'{name}.py').write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    return folder


@pytest.mark.usefixtures('package')
def test_first_use_runs_it(ran: list[str]) -> None:
    module = importlib.import_module(NAME)
    # each further import looks at it
    exec(f'import {NAME}')
    assert ran == []
    assert module.value == 7
    assert ran == [NAME, f'{NAME}.inner']
    assert type(module) is ModuleType
    assert not hasattr(module, 'nothing')
    assert len(ran) == 2


@pytest.mark.parametrize('inner', ['inner', 'other'])
@pytest.mark.parametrize('is_imported', [False, True])
@pytest.mark.usefixtures('package')
def test_module_of_it_comes_behind_it(
    ran: list[str], inner: str, is_imported: bool
) -> None:
    if is_imported:
        importlib.import_module(NAME)
    module = importlib.import_module(f'{NAME}.{inner}')
    assert ran[0] == NAME
    assert len(ran) == len(set(ran))
    assert module.value == 7
    assert getattr(sys.modules[NAME], inner) is module
    assert module.__spec__ is not None
    assert importlib.reload(module) is module


def test_failure_is_that_of_each_use(ran: list[str], package: Path) -> None:
    (package / 'inner.py').write_text("raise ImportError('too old')\n")
    module = importlib.import_module(NAME)
    for _ in range(2):
        with pytest.raises(ImportError, match='too old'):
            _ = module.value
    assert ran == [NAME, NAME]


@pytest.mark.usefixtures('ran')
def test_absence_is_told_at_once() -> None:
    with pytest.raises(ModuleNotFoundError, match=NAME):
        importlib.import_module(NAME)
