# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Users with machines."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from support.deployer import Deployer
from support.sshd import Sshd


@pytest.fixture
def deployer(tmp_path: Path, sshd: Sshd) -> Iterator[Deployer]:
    """Return a user whose machines are reached by ssh."""
    home = tmp_path / 'deployer'
    home.mkdir()
    somebody = Deployer(home, sshd)
    yield somebody
    somebody.leave()
