# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""`colcon create --example` and `colcon launch --demo`, from a user's side."""

import os
from pathlib import Path
import shlex
import signal

import pytest
from support.user import Launch, User

ROOT = Path(__file__).parents[3]
#: What the listener of the package talk prints.
HEARD = 'Heard 2, twice that is 4'
HINT = 'To get your own: colcon create --example'


def finished(user: User, *words: str, code: int = 0) -> str:
    """Run a command to its end, and return its output."""
    done = user.start('colcon', *words)
    assert done.end() == code, done.output
    assert 'Traceback' not in done.output
    return done.output


def error(user: User, *words: str) -> str:
    """Return the error of a command, which has made nothing."""
    before = sorted(user.root.rglob('*'))
    output = finished(user, *words, code=1)
    assert sorted(user.root.rglob('*')) == before
    assert output.count('error: ') == 1
    return output


def files(folder: Path) -> dict[str, bool]:
    """Return the files below a folder, and whether they are executable."""
    return {
        str(path.relative_to(folder)): os.access(path, os.X_OK)
        for path in folder.rglob('*')
        if path.is_file() and '__pycache__' not in path.parts
    }


@pytest.fixture
def temporary(user: User) -> Path:
    """Return the folder for temporary files of a user without ROS."""
    folder = user.root.parent / 'temporary'
    folder.mkdir()
    user.environment['TMPDIR'] = str(folder)
    return folder


def test_example_is_the_sample_workspace_and_launches(user: User) -> None:
    output = finished(user, 'create', '--example', 'my ws')
    expected = files(ROOT / 'sample_ws')
    for name in [*expected]:
        if name.split('/')[0] in ('build', 'install', 'log'):
            # somebody uses that of the clone
            del expected[name]
    made = user.root / 'my ws'
    assert files(made) == expected
    assert expected['src/my_pkg/scripts/counter.py']
    for name in expected:
        original = ROOT / 'sample_ws' / name
        assert (made / name).read_bytes() == original.read_bytes()
    command = output.rpartition('Try it:')[2].strip()
    assert command == "cd 'my ws' && colcon launch talk talk.yaml"
    words = shlex.split(command.partition('&& ')[2])
    launch = user.start(*words, 'period:=0.1', cwd=made)
    launch.wait_for(HEARD)
    assert launch.interrupt() == 0, launch.output


def test_example_has_a_name_of_its_own(user: User) -> None:
    output = finished(user, 'create', '--example')
    assert 'Created sample_ws, ' in output
    assert (user.root / 'sample_ws/README.md').is_file()


def test_example_overwrites_nothing(user: User) -> None:
    user.write('sample_ws/notes.txt', 'mine\n')
    output = error(user, 'create', '--example')
    assert f'{user.root / "sample_ws"} is there already' in output
    assert 'help: name another one: --example DIR' in output
    assert 'is there already' in error(user, 'create', '--example', '.')
    user.write('file', '')
    output = error(user, 'create', '--example', 'file/ws')
    assert f'{user.root / "file"} is there already' in output


def test_example_in_a_place_that_takes_no_folder(user: User) -> None:
    output = error(user, 'create', '--example', '/proc/ws')
    assert 'cannot make /proc/ws: No such file or directory' in output


@pytest.mark.parametrize(
    ('words', 'message'),
    [
        (['a', 'b'], "'b' is one word too many"),
        (['--node', 'a'], '--example and --node exclude one another'),
        (
            ['--build-type', 'ament_cmake'],
            '--example and --build-type exclude one another',
        ),
        (['--destination', 'a'], '--example and --destination exclude'),
    ],
)
def test_example_with_other_words(
    user: User, words: list[str], message: str
) -> None:
    assert message in error(user, 'create', '--example', *words)


def demo(user: User, *words: str) -> Launch:
    return user.start('colcon', 'launch', '--demo', *words)


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_demo_leaves_nothing(
    user: User, temporary: Path, number: signal.Signals
) -> None:
    home = files(user.root.parent)
    launch = demo(user, 'period:=0.1')
    launch.wait_for(HEARD)
    (folder,) = temporary.glob('colcon-demo-*')
    launch.process.send_signal(number)
    assert launch.end() == 0, launch.output
    assert not folder.exists()
    assert launch.output.rstrip().endswith(HINT)
    assert launch.output.count(HINT) == 1
    assert files(user.root.parent) == home


def test_demo_that_ends_in_its_build_leaves_nothing(
    user: User, temporary: Path
) -> None:
    launch = demo(user)
    launch.wait_for('Starting >>> talk')
    assert launch.interrupt() == 130, launch.output
    assert [*temporary.glob('colcon-demo-*')] == []


def test_demo_in_a_workspace_touches_nothing_in_it(user: User) -> None:
    user.package('talk')
    before = sorted(user.root.rglob('*'))
    launch = demo(user, '--until', HEARD, 'period:=0.1', '--quiet')
    assert launch.end() == 0, launch.output
    assert HINT not in launch.output
    assert sorted(user.root.rglob('*')) == before


def test_two_demos_at_once_hear_only_themselves(
    user: User, temporary: Path
) -> None:
    launches = [demo(user, f'period:={period}') for period in (0.1, 1000)]
    launches[0].wait_for(HEARD)
    launches[1].wait_for('talker.*started')
    assert len([*temporary.glob('colcon-demo-*')]) == 2
    assert 'Heard' not in launches[1].output
    for launch in launches:
        assert launch.interrupt() == 0, launch.output


@pytest.mark.parametrize(
    ('words', 'message'),
    [
        (['talk'], '--demo takes nothing else to launch'),
        (['--watch'], 'for --watch, make one of your own with colcon create'),
        (['--plan'], 'for --plan, make one of your own with colcon create'),
        (['--status'], '--demo and --status exclude one another'),
        (['--workspace', '.'], '--demo and --workspace exclude one another'),
    ],
)
def test_demo_with_other_words(
    user: User, words: list[str], message: str
) -> None:
    assert message in error(user, 'launch', '--demo', *words)


def test_demo_without_room_for_temporary_files(user: User) -> None:
    program = (
        'import sys, tempfile; tempfile.tempdir = "/proc/none"; '
        'sys.argv[0] = "colcon"; '
        'import colcon_core.command as c; sys.exit(c.main())'
    )
    done = user.start('python3', '-c', program, 'launch', '--demo')
    assert done.end() == 1
    assert 'error: --demo needs a temporary folder: No such' in done.output
    assert 'TMPDIR=FOLDER' in done.output
    assert 'Traceback' not in done.output
