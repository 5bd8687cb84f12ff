# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""No verb runs what another user has put in the way."""

import os
from pathlib import Path
import subprocess

import pytest
from support.hostile import needs_other_user, OTHER_USER
from support.user import User

pytestmark = [pytest.mark.hostile, needs_other_user]


@pytest.fixture
def bait(user: User) -> Path:
    """Put the install folder of somebody else in the way of a user."""
    mine = user.root / 'mine'
    mine.mkdir()
    user.root.chmod(0o1777)
    install = user.root / 'install'
    for path, text in (
        ('.colcon_install_layout', 'isolated\n'),
        ('setup.bash', f'touch {user.root}/lured\n'),
    ):
        install.mkdir(exist_ok=True)
        (install / path).write_text(text, encoding='utf-8')
        os.chown(install / path, OTHER_USER, OTHER_USER)
    os.chown(install, OTHER_USER, OTHER_USER)
    (mine / 'demo.yaml').write_text('launch: []\n', encoding='utf-8')
    return mine


@pytest.mark.parametrize(
    'words',
    [
        ('launch', 'demo.yaml'),
        ('launch', 'demo.yaml', '--check'),
        ('launch', 'demo.yaml', '--no-build'),
        ('launch', '--workspace', '..', 'demo.yaml', '-s'),
        ('run', 'package', 'program'),
    ],
)
def test_no_verb_is_lured(
    user: User, bait: Path, words: tuple[str, ...]
) -> None:
    launch = user.start('colcon', *words, cwd=bait)
    assert launch.end() == 1
    line, hint = launch.output.splitlines()
    assert line.startswith(
        f'colcon {words[0]}: error: the workspace {user.root} is not used: '
        f'{user.root / "install"} belongs to '
    )
    assert f'export COLCON_LAUNCH_TRUST={user.root} ' in hint
    assert not (user.root / 'lured').exists()
    assert not (user.root / 'log').exists()


def test_create_makes_a_package_beside_a_lure(user: User, bait: Path) -> None:
    who = ('--maintainer-name', 'me', '--maintainer-email', 'me@example.com')
    subprocess.run(
        ['colcon', 'create', 'new', '--build-type', 'cmake', *who],
        cwd=bait,
        env=user.environment,
        check=True,
        capture_output=True,
    )
    assert (bait / 'new/CMakeLists.txt').is_file()
    assert not (user.root / 'lured').exists()


def test_workspace_that_is_trusted_is_used(user: User, bait: Path) -> None:
    user.environment['COLCON_LAUNCH_TRUST'] = f'/nowhere:{user.root}'
    user.launch('demo.yaml', cwd=bait)
    assert (user.root / 'lured').exists()
