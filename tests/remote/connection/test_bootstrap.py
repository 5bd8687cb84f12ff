# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The first words with a machine, whatever answers."""

import os
from pathlib import Path
import shutil
import subprocess
import tempfile

from colcon_yamllaunch.common.process_scan import variable_of
from colcon_yamllaunch.deployment.deployment import Machine
from colcon_yamllaunch.remote.connection import bootstrap
from colcon_yamllaunch.remote.connection.bootstrap import (
    Bootstrap,
    MAXIMUM_NOISE,
    ProgramArchive,
)
from colcon_yamllaunch.remote.connection.connection_errors import ConnectError
from colcon_yamllaunch.remote.connection.machine_connection import (
    MachineConnection,
)
import pytest
from support.hostile import with_mounts
from support.linked_part import LinkedPart, PlainMachine, process

ARCHIVE = ProgramArchive({'a.py': ''})
SHELLS = ['sh', 'dash', 'bash', 'fish', 'csh', 'tcsh', 'zsh', 'busybox']


def test_answer_is_found_behind_noise_in_any_pieces() -> None:
    talk = Bootstrap(ARCHIVE)
    said = b'Welcome!\n' + bootstrap.MARK + b'have\nframes'
    found = b''
    for index in range(len(said)):
        if talk.state == 'noise':
            answer, found = talk.feed(said[index : index + 1])
            assert answer == b''
        else:
            found += said[index : index + 1]
    assert talk.state == 'answered'
    assert found == b'frames'


def test_modules_are_sent_on_request() -> None:
    talk = Bootstrap(ARCHIVE)
    answer, rest = talk.feed(bootstrap.MARK + b'need\n')
    assert answer == f'{len(ARCHIVE.data):8d}'.encode() + ARCHIVE.data
    assert rest == b''


@pytest.mark.parametrize(
    ('said', 'failure', 'detail'),
    [
        (b'none\n', 'none', ''),
        (b'old 3.6.9\n', 'old', '3.6.9'),
        (b'full No space left\n', 'full', 'No space left'),
        (b'what?\n', 'noise', ''),
    ],
)
def test_failure_there_is_recognized(
    said: bytes, failure: str, detail: str
) -> None:
    talk = Bootstrap(ARCHIVE)
    talk.feed(bootstrap.MARK + said)
    assert talk.state == 'failed'
    assert talk.failure == failure
    assert detail in talk.detail


def test_endless_noise_is_given_up() -> None:
    talk = Bootstrap(ARCHIVE)
    talk.feed(b'\n' * (MAXIMUM_NOISE - 100))
    assert talk.state == 'noise'
    talk.feed(b'login: ' * 100)
    assert talk.state == 'failed'
    assert talk.noise.endswith('login:')


def test_echo_of_the_script_is_no_answer() -> None:
    talk = Bootstrap(ARCHIVE)
    talk.feed(talk.script())
    assert talk.state == 'noise'


def answer_of(tmp_path: Path, *words: str, path: str = '') -> str:
    """Return what a command says that is given the script."""
    talk = Bootstrap(ARCHIVE)
    done = subprocess.run(
        words,
        input=talk.script(),
        capture_output=True,
        env={'PATH': path or os.environ['PATH'], 'HOME': str(tmp_path)},
        check=True,
    )
    assert done.stderr == b''
    return done.stdout.decode()


def machine_with(folder: Path, name: str, script: str) -> str:
    """Return a PATH with one program."""
    folder.mkdir(exist_ok=True)
    program = folder / name
    program.write_text(f'#!/bin/sh\n{script}\n')
    program.chmod(0o755)
    return str(folder)


def test_another_python_is_found(tmp_path: Path) -> None:
    path = machine_with(tmp_path / 'bin', 'python3.12', 'echo found "$5"')
    said = answer_of(tmp_path, '/bin/sh', path=path)
    assert said == f'found {ARCHIVE.digest}\n'


@pytest.mark.parametrize('shell', SHELLS)
def test_any_login_shell_runs_the_script(tmp_path: Path, shell: str) -> None:
    program = shutil.which(shell)
    if program is None:
        pytest.skip(f'{shell} is not installed')
    words = [program, 'sh'] if shell == 'busybox' else [program, '-c', 'sh']
    said = answer_of(tmp_path, *words)
    assert said == '\x01colcon-launch need\n'


@pytest.mark.parametrize('kind', ['file', 'others'])
def test_modules_go_to_another_folder_if_necessary(
    tmp_path: Path, kind: str
) -> None:
    plain = PlainMachine(tmp_path)
    cache = plain.home / '.cache'
    if kind == 'file':
        cache.write_text('no folder')
    else:
        # somebody else may write there
        with LinkedPart(plain.machine(), []) as part:
            part.finish()
        (folder,) = (cache / 'colcon-launch' / 'program').iterdir()
        folder.chmod(0o777)
    with LinkedPart(plain.machine(), [process('arm│a', 'echo a')]) as part:
        part.wait_for(part.out)
        place = Path(variable_of(part.guard, 'FOLDER') or '')
        assert place.stat().st_mode & 0o777 == 0o700
        kept = cache / 'colcon-launch' / 'program'
        temporary = Path(tempfile.gettempdir())
        assert place.parent == (temporary if kind == 'file' else kept)
        part.finish()
    plain.wait_until_empty()
    assert not place.exists()


@pytest.mark.hostile
@pytest.mark.parametrize('options', ['ro', 'size=4k'])
def test_full_or_read_only_disk_is_told(options: str) -> None:
    mounts = f"""
        for folder in /tmp /var/tmp; do
          mount -t tmpfs -o {options} tmpfs $folder
          head -c 9999 /dev/zero > $folder/filler || :
        done 2>/dev/null
        cd /proc
    """
    path = os.environ['PATH']
    argv = ['env', '-i', 'HOME=/proc', f'PATH={path}', 'sh']
    words = with_mounts(mounts, argv)
    contact = MachineConnection(Machine('arm', 'connect', tuple(words)))
    with pytest.raises(ConnectError) as caught:
        contact.connect()
    text = str(caught.value)
    assert ': what is to run there cannot be stored, neither in ' in text
    assert 'No usable temporary directory' in text
