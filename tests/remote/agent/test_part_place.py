# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The folder where parts of launches are found."""

import os
from pathlib import Path

from colcon_yamllaunch.engine.launch_scan import new_identity
from colcon_yamllaunch.remote.agent import part_place
from colcon_yamllaunch.remote.agent.part_place import PartPlace
import pytest


def test_part_that_is_just_starting_is_not_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / 'place'
    monkeypatch.setattr(part_place, '_folders', lambda _: [folder])
    place, other = PartPlace({}), PartPlace({})
    write = os.write

    def write_late(descriptor: int, data: bytes) -> int:
        # another connection looks just now
        assert list(other.left_behind()) == []
        return write(descriptor, data)

    monkeypatch.setattr(os, 'write', write_late)
    identity = new_identity()
    with place.listen(identity), other.connect(identity):
        assert other.has_record(identity)
    place.remove(identity)
    assert list(folder.iterdir()) == []
