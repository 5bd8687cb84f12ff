# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the tests of services share."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from support.systemd import Systemd
from support.user import User


@pytest.fixture
def systemd(user: User, tmp_path: Path) -> Iterator[Systemd]:
    """Play systemd."""
    folder = tmp_path / 'systemd'
    folder.mkdir()
    played = Systemd(folder, user)
    yield played
    played.close()
