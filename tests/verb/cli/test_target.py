# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is said when the words name no launch file."""

from pathlib import Path

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.verb.cli.target import path_target
import pytest


def refused(folder: Path, *words: str) -> str:
    with pytest.raises(UserError) as error:
        path_target(words, folder)
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
