# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Where parameter files are written to."""

from pathlib import Path
import subprocess
import sys

from colcon_yamllaunch.common import files as common_files
from colcon_yamllaunch.engine.own_files import ParameterFiles
from colcon_yamllaunch.plan.plan import ParameterFile
import pytest
from support.hostile import with_mounts

pytestmark = pytest.mark.hostile

#: Writes 64 KiB for a process, and prints where.
WRITING = """\
import sys
from colcon_yamllaunch.common import files as common_files
from colcon_yamllaunch.plan.plan import ParameterFile, Process
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.engine.own_files import ParameterFiles
common_files.SHARED_FOLDERS = tuple(sys.argv[1:])
process = Process(
    label='a', argv=(ParameterFile('#' * 65536),), cwd='/',
    position=Position('/ws/demo.yaml', 1, 1),
)
files = ParameterFiles(lambda _: None)
print(*files.command_line(1, process))
"""


def test_another_place_is_taken_when_a_disk_is_full(tmp_path):
    full, free = tmp_path / 'full', tmp_path / 'free'
    full.mkdir()
    free.mkdir()
    command = with_mounts(
        f'mount -t tmpfs -o size=16k none {full}',
        [sys.executable, '-c', WRITING, str(full), str(free)],
    )
    written = subprocess.run(
        command, check=True, capture_output=True, text=True
    ).stdout
    assert Path(written.strip()).is_relative_to(free)
    assert list(full.iterdir()) == []


def test_no_file_is_written_to_the_current_folder(
    process, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv('TMPDIR', '/not/there')
    monkeypatch.setattr(common_files, 'SHARED_FOLDERS', ('/nowhere',))
    made = []
    files = ParameterFiles(made.append)
    with pytest.raises(OSError, match='not/there'):
        files.command_line(1, process('a', ParameterFile('{}')))
    assert made == list(tmp_path.iterdir()) == []


def test_a_process_that_is_another_one_has_another_file(process, tmp_path):
    files = ParameterFiles(lambda _: None)
    before = process('a', ParameterFile('one'))
    (path,) = files.command_line(3, before)
    Path(path).write_text('kept')
    assert files.command_line(3, before) == [path]
    assert Path(path).read_text() == 'kept'
    assert files.command_line(3, process('a', ParameterFile('two'))) == [path]
    assert Path(path).read_text() == 'two'
    files.remove()
    assert not Path(path).exists()
