# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""No test that builds gets among those of `make quick` by oversight."""

import subprocess
import sys

import pytest


@pytest.mark.parametrize('program', ['cmake', '/opt/bin/colcon'])
def test_a_quick_test_cannot_build(program: str) -> None:
    with pytest.raises(pytest.fail.Exception, match='`full`'):
        subprocess.run([program], check=False)


def test_a_quick_test_cannot_be_a_node(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # another test of this process may have imported it
    monkeypatch.delitem(sys.modules, 'rclpy', raising=False)
    with pytest.raises(pytest.fail.Exception, match='`full`'):
        __import__('rclpy')


@pytest.mark.full
def test_another_test_may_do_anything() -> None:
    with pytest.raises(FileNotFoundError):
        subprocess.run(['/nowhere/colcon'], check=False)
