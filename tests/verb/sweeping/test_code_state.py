# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Which version of the code runs use."""

from collections.abc import Callable
import os
from pathlib import Path
import subprocess

from colcon_yamllaunch.verb import code_state
from colcon_yamllaunch.verb.code_state import CodeState
import pytest

Git = Callable[..., None]


@pytest.fixture
def git(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Git:
    """Return what calls git in a new repository."""
    monkeypatch.setattr(code_state, '_INTERVAL', 0.0)
    for name in ('AUTHOR', 'COMMITTER'):
        monkeypatch.setenv(f'GIT_{name}_NAME', 'somebody')
        monkeypatch.setenv(f'GIT_{name}_EMAIL', 'somebody@example.com')

    def call(*words: str) -> None:
        subprocess.run(['git', *words], cwd=tmp_path, check=True)

    call('init', '-q')
    return call


def test_commit_and_parts_follow_edits(tmp_path: Path, git: Git) -> None:
    package = tmp_path / 'package'
    package.mkdir()
    node = package / 'node.py'
    node.write_text('1')
    (package / 'README.md').write_text('1')
    git('add', '.')
    git('commit', '-qm', 'one')
    state = CodeState(os.environ)
    state.add([str(package), str(tmp_path / 'gone')])
    first = state.look()
    assert len(first.commit) >= 10
    assert list(first.parts) == [str(package)]
    (package / 'README.md').write_text('2')
    node.touch()
    assert state.look() == first
    node.write_text('2')
    edited = state.look()
    assert edited.commit == f'{first.commit}-dirty'
    assert edited.parts != first.parts
    node.write_text('1')
    (package / 'README.md').write_text('1')
    assert state.look() == first
    # a file that another run turns out to use
    more = state.look([str(tmp_path / '.git' / 'HEAD')])
    assert first.parts.items() < more.parts.items()


def test_tracked_files_beside_a_launch_file_count(
    tmp_path: Path, git: Git
) -> None:
    for name in ('lib.sh', 'out.csv'):
        (tmp_path / name).touch()
    git('add', 'lib.sh')
    state = CodeState(os.environ)
    state.add_tracked(tmp_path)
    found = state.look()
    assert list(found.parts) == [str(tmp_path / 'lib.sh')]
    # there is no commit yet
    assert not found.commit


def test_fingerprint_without_git_has_no_commit(tmp_path: Path) -> None:
    (tmp_path / 'a').touch()
    state = CodeState({'PATH': '', 'GIT_CEILING_DIRECTORIES': '/'})
    state.add_tracked(tmp_path)
    found = state.look([str(tmp_path / 'a')])
    assert (found.commit, list(found.parts)) == ('', [str(tmp_path / 'a')])
