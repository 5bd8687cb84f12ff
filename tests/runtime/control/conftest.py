# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

from colcon_yamllaunch.common import temporary_folders
from colcon_yamllaunch.runtime.control import socket_folder
import pytest


@pytest.fixture(autouse=True)
def no_shared_folders(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have no folder for sockets but those that a test names."""
    monkeypatch.setattr(socket_folder, 'USER_FOLDERS', '/does/not/exist')
    monkeypatch.setattr(temporary_folders, 'SHARED_FOLDERS', ())
