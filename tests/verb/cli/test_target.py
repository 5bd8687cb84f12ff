# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is said when the words name no launch file."""

from pathlib import Path

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.verb.target import path_target
from colcon_yamllaunch.workspace.packages.package import Package
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator
import pytest


def refused(folder: Path, *words: str) -> str:
    with pytest.raises(UserError) as error:
        path_target(words, folder, PackageLocator((), folder, False, {}))
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
        path_target(('weather.launch.yaml',), tmp_path, locator)
    assert error.value.hint == (
        'Launch files here:\n  colcon launch weather weather.launch.yaml'
    )
