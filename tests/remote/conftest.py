# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Users with machines."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from support.deployer import Deployer
from support.developer import Developer
from support.linked_part import PlainMachine
from support.sshd import Sshd


@pytest.fixture
def deployer(tmp_path: Path, sshd: Sshd) -> Iterator[Deployer]:
    """Return a user whose machines are reached by ssh."""
    home = tmp_path / 'deployer'
    home.mkdir()
    somebody = Deployer(home, sshd)
    yield somebody
    somebody.leave()


@pytest.fixture
def plain(tmp_path: Path) -> Iterator[PlainMachine]:
    """Return a machine; nothing runs there at the end."""
    machine = PlainMachine(tmp_path)
    yield machine
    machine.clear()


@pytest.fixture
def developer(tmp_path: Path) -> Iterator[Developer]:
    """Return somebody with a workspace here and a machine."""
    somebody = Developer(tmp_path)
    yield somebody
    somebody.machine.close()
