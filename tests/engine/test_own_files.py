# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

import os
from pathlib import Path
import socket

from colcon_yamllaunch.engine import own_files
import pytest
from support.hostile import needs_other_user, OTHER_USER

pytestmark = pytest.mark.hostile


@pytest.fixture
def folder(tmp_path):
    """Return a folder as the launcher makes one, with a parameter file."""
    made = tmp_path / 'colcon_launch_x'
    made.mkdir(mode=0o700)
    (made / 'talker-1-0-3.yaml').touch()
    return made


def test_the_folder_of_a_launch_is_removed(folder):
    own_files.remove_parameter_files(own_files.OwnFile.of(str(folder)))
    assert not folder.exists()
    # once more does no harm
    own_files.remove_parameter_files(own_files.OwnFile(str(folder), 1, 2))


@pytest.mark.parametrize(
    'name', ['notes.yaml', 'a-1-x.yaml', '-1.yaml', 'a-1-2.yml', 'b-1-1.yaml/']
)
def test_what_the_launcher_does_not_make_stays(folder, name):
    path = folder / name
    if name.endswith('/'):
        path.mkdir()
    else:
        path.touch()
    own_files.remove_parameter_files(own_files.OwnFile.of(str(folder)))
    assert os.listdir(folder) == [path.name]


def exchanged(folder: Path) -> own_files.OwnFile:
    """Put another folder where one was."""
    found = own_files.OwnFile.of(str(folder))
    folder.rename(folder.with_name('moved'))
    folder.mkdir(mode=0o700)
    return found


def test_another_folder_in_its_place_is_left_alone(folder):
    found = exchanged(folder)
    (folder / 'a-1-2.yaml').touch()
    own_files.remove_parameter_files(found)
    assert os.listdir(folder) == ['a-1-2.yaml']


def test_a_link_in_its_place_is_left_alone(folder):
    found = exchanged(folder)
    folder.rmdir()
    moved = folder.with_name('moved')
    folder.symlink_to(moved)
    own_files.remove_parameter_files(found)
    assert os.listdir(moved) == ['talker-1-0-3.yaml']


def test_a_folder_that_others_may_enter_or_of_another_name_stays(folder):
    folder.chmod(0o777)
    own_files.remove_parameter_files(own_files.OwnFile.of(str(folder)))
    folder.chmod(0o700)
    other = folder.rename(folder.with_name('work'))
    own_files.remove_parameter_files(own_files.OwnFile.of(str(other)))
    assert os.listdir(other) == ['talker-1-0-3.yaml']


@needs_other_user
def test_a_folder_of_another_user_stays(folder):
    os.chown(folder, OTHER_USER, OTHER_USER)
    own_files.remove_parameter_files(own_files.OwnFile.of(str(folder)))
    assert os.listdir(folder) == ['talker-1-0-3.yaml']


def test_a_socket_is_removed_but_not_the_next_one_of_its_name(tmp_path):
    path = tmp_path / '5.sock'
    places = []
    for _ in range(2):
        listener = socket.socket(socket.AF_UNIX)
        path.unlink(missing_ok=True)
        listener.bind(str(path))
        places.append((own_files.OwnFile.of(str(path)), listener))
        # so that the inode is not used again
        os.link(path, f'{path}{len(places)}')
    own_files.remove_file(places[0][0])
    assert path.exists()
    own_files.remove_file(places[1][0])
    assert not path.exists()
    for _, listener in places:
        listener.close()
