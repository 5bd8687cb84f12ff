# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Which workspace a command line is about."""

from pathlib import Path

from colcon_yamllaunch.verb.target import find_workspace
from colcon_yamllaunch.verb.target import WORKSPACE
from colcon_yamllaunch.workspace.packages.workspace_root import UntrustedError
import pytest


@pytest.fixture
def outside(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Stand outside of all workspaces, with one in the environment."""
    for name in ('named', 'around', 'outside'):
        (tmp_path / name).mkdir()
    (tmp_path / 'around/install').mkdir()
    (tmp_path / 'around/demo.yaml').touch()
    monkeypatch.chdir(tmp_path / 'outside')
    monkeypatch.setenv(WORKSPACE, str(tmp_path / 'named'))
    return tmp_path


def test_workspace_of_the_environment(
    outside: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert find_workspace(None, ()) == outside / 'named'
    around = outside / 'around'
    # what is given, what the launch file is in and what is around goes first
    assert find_workspace(around, ()) == around
    assert find_workspace(None, [str(around / 'demo.yaml')]) == around
    monkeypatch.chdir(around)
    assert find_workspace(None, ()) == around


@pytest.mark.parametrize('value', ['', 'named', '../named', '/no/where'])
def test_what_names_no_workspace(
    outside: Path, monkeypatch: pytest.MonkeyPatch, value: str
) -> None:
    monkeypatch.setenv(WORKSPACE, value)
    assert find_workspace(None, ()) is None


def test_home_and_trust(
    outside: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv('HOME', str(outside))
    monkeypatch.setenv(WORKSPACE, '~/named')
    assert find_workspace(None, ()) == outside / 'named'
    # everyone may write there
    (outside / 'named').chmod(0o1777)
    with pytest.raises(UntrustedError):
        find_workspace(None, ())
