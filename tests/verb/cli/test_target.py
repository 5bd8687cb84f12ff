# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Which workspace and launch file a command line is about."""

from pathlib import Path

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.verb.target import (
    find_target,
    find_workspace,
    WORKSPACE,
)
from colcon_yamllaunch.workspace.packages.package import Package
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator
from colcon_yamllaunch.workspace.packages.workspace_root import UntrustedError
import pytest


def refused(folder: Path, *words: str) -> str:
    with pytest.raises(UserError) as error:
        find_target(words, folder, PackageLocator((), folder, False, {}))
    return str(error.value)


def test_a_suggested_path_works_from_here(tmp_path: Path) -> None:
    (tmp_path / 'launch').mkdir()
    (tmp_path / 'launch/demo.yaml').touch()
    text = refused(tmp_path, 'launch/dmo.yaml')
    assert text.endswith("did you mean 'launch/demo.yaml'?")
    text = refused(tmp_path / 'launch', 'dmo.yaml')
    assert text.endswith("did you mean 'demo.yaml'?")


@pytest.mark.parametrize(
    ('word', 'hint'),
    [
        ('unit=kelvin', "did you mean 'unit:=kelvin'?"),
        ('kelvin', 'it is written name:=value'),
        ('=kelvin', 'it is written name:=value'),
    ],
)
def test_a_malformed_launch_argument(
    tmp_path: Path, word: str, hint: str
) -> None:
    (tmp_path / 'demo.yaml').touch()
    assert refused(tmp_path, 'demo.yaml', word).endswith(hint)


def test_launch_files_that_there_are_are_listed(tmp_path: Path) -> None:
    file = tmp_path / 'weather/launch/weather.launch.yaml'
    file.parent.mkdir(parents=True)
    file.touch()
    package = Package('weather', tmp_path / 'weather', 'ros.ament_cmake')
    locator = PackageLocator((package,), tmp_path / 'install', False, {})
    with pytest.raises(UserError) as error:
        find_target(('weather.launch.yaml',), tmp_path, locator)
    assert error.value.hint == (
        'Launch files here:\n  colcon launch weather weather.launch.yaml'
    )


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
