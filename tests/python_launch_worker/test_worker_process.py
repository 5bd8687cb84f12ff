# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The process that reads launch files in Python, played by a script."""

from collections.abc import Callable, Iterator
import os
from pathlib import Path
import select
import signal
import subprocess
import sys
import time

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.process_scan import read_process
from colcon_yamllaunch.engine.launch_scan import new_identity
from colcon_yamllaunch.language.evaluation.request import (
    NoWorkerError,
    WorkerError,
    WorkerTimeoutError,
)
from colcon_yamllaunch.python_launch import worker_process
from colcon_yamllaunch.python_launch.worker_process import WorkerProcess
import pytest
from support.waiting import wait_until

#: Seconds.
DEADLINE = 60
#: What each script begins with.
PLAYED = """\
import json, os, signal, subprocess, sys, time

def say(what, **fields):
    print(json.dumps({'say': what, **fields}), flush=True)

def take():
    line = sys.stdin.readline()
    if not line:
        sys.exit()
    return json.loads(line)

"""
ECHO = """\
say('found', missing=[])
while True:
    say('done', id=take()['id'])
"""
#: Takes no notice of the end of its input.
DEAF = """\
say('found', missing=[])
child = subprocess.Popen(['sleep', '1000'], start_new_session=True)
say('child', pid=child.pid)
while True:
    time.sleep(1000)
"""

MakeLink = Callable[..., WorkerProcess]


@pytest.fixture
def link(tmp_path: Path) -> Iterator[MakeLink]:
    """Make a link to a worker that is played by a script, or several."""
    links = []

    def make(*scripts: str, timeout: float = DEADLINE) -> WorkerProcess:
        folders = []
        for number, script in enumerate(scripts):
            folder = tmp_path / f'python{number}'
            folder.mkdir()
            program = folder / 'python3'
            program.write_text(f'#!{sys.executable} -IS\n{PLAYED}{script}')
            program.chmod(0o755)
            folders.append(str(folder))
        path = ':'.join([*folders, os.environ['PATH']])
        if not scripts:
            path = str(tmp_path)
        links.append(
            WorkerProcess(
                {'PATH': path},
                str(tmp_path),
                tmp_path / 'launch_files.log',
                new_identity(),
                timeout,
            )
        )
        return links[-1]

    yield make
    for one in links:
        one.close()


def has_ended(pid: int) -> bool:
    # one that nobody has waited for runs no more
    return read_process(pid) is None


def wait_for_end(*pids: int) -> None:
    wait_until(lambda: all(map(has_ended, pids)))


def test_messages_go_both_ways(link: MakeLink) -> None:
    worker = link(ECHO)
    assert worker.pid == 0
    for number in range(3):
        worker.send({'id': number, 'text': 'ä' * 100_000})
        assert worker.receive() == {'say': 'done', 'id': number}
    pid = worker.pid
    worker.close()
    assert has_ended(pid)
    assert worker.pid == 0
    with pytest.raises(WorkerError, match='ended'):
        worker.send({})


def test_one_that_was_started_before_is_asked(link: MakeLink) -> None:
    worker = link(ECHO)
    worker.start()
    pid = worker.pid
    assert pid
    worker.send({'id': 1})
    assert worker.receive()['id'] == 1
    assert worker.pid == pid


def test_one_that_is_never_asked_is_ended(
    link: MakeLink, monkeypatch: pytest.MonkeyPatch
) -> None:
    worker = link('import time\nwhile True: time.sleep(1)\n')
    # it is not waited for, as it has nothing to end
    monkeypatch.setattr(worker_process, 'ANSWER_TIMEOUT', DEADLINE)
    worker.start()
    pid = worker.pid
    begin = time.monotonic()
    worker.close()
    assert time.monotonic() - begin < DEADLINE
    assert has_ended(pid)


@pytest.mark.parametrize('is_started_before', [True, False])
def test_start_that_fails_is_told_when_it_is_asked(
    link: MakeLink, is_started_before: bool
) -> None:
    worker = link()
    if is_started_before:
        worker.start()
    assert worker.pid == 0
    with pytest.raises(NoWorkerError, match='python3'):
        worker.send({'id': 1})


def test_much_goes_both_ways_at_once(link: MakeLink) -> None:
    worker = link(
        "say('found', missing=[])\nsay('much', text='x' * 1_000_000)\n" + ECHO
    )
    worker.send({'id': 1, 'text': 'y' * 1_000_000})
    assert len(worker.receive()['text']) == 1_000_000
    assert worker.receive()['id'] == 1


LACKS = "say('found', missing=['{}'])\n"


@pytest.mark.parametrize(
    'scripts',
    [
        [LACKS.format('launch')] * 2,
        ['sys.exit(3)\n'],
        ['os.abort()\n'],
        ['(\n'],
        ['#!/no/such/python\n'],
    ],
)
def test_the_next_python_is_taken_where_one_is_of_no_use(
    link: MakeLink, tmp_path: Path, scripts: list[str]
) -> None:
    worker = link(*scripts, ECHO)
    if scripts[0].startswith('#!'):
        (tmp_path / 'python0' / 'python3').write_text(scripts[0])
    for number in (1, 2):
        worker.send({'id': number})
    for number in (1, 2):
        assert worker.receive() == {'say': 'done', 'id': number}


def test_all_of_them_lack_something(link: MakeLink) -> None:
    # no more are tried
    worker = link(*map(LACKS.format, 'abcd'))
    worker.send({'id': 1})
    with pytest.raises(NoWorkerError, match='there is no a'):
        worker.receive()
    with pytest.raises(NoWorkerError):
        worker.send({'id': 2})


def test_a_worker_that_takes_too_long_says_what_it_does(
    link: MakeLink,
) -> None:
    worker = link(
        "say('found', missing=[])\ntake()\ntake()\nsay('other')\n"
        "say('where', frames=[1])\nsys.stdin.read()",
        timeout=0.5,
    )
    worker.send({'id': 1})
    with pytest.raises(WorkerTimeoutError, match=r'more than 0\.5 s'):
        worker.receive()
    pid = worker.pid
    assert worker.doing()['frames'] == [1]
    assert has_ended(pid)


def test_a_worker_that_says_nothing_is_killed(
    link: MakeLink, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(worker_process, 'ANSWER_TIMEOUT', 0.1)
    worker = link(DEAF, timeout=DEADLINE)
    worker.send({'id': 1})
    child = worker.receive()['pid']
    pid = worker.pid
    assert worker.doing() == {}
    wait_for_end(pid, child)


SAYS_MORE = "print('oh', file=sys.stderr)\nprint('no JSON')\n"


@pytest.mark.parametrize(
    ('script', 'ending'),
    [
        (f'{SAYS_MORE}sys.exit(3)', 'exited with code 3.*launch_files.log'),
        (
            f'{SAYS_MORE}os.kill(os.getpid(), signal.SIGSEGV)',
            'died by SIGSEGV.*launch_files.log',
        ),
        (
            f"{SAYS_MORE}os.close(1)\nsys.stdin.read()\nsys.exit('x')",
            'exited.*launch_files.log',
        ),
        # without a word
        ('sys.exit(3)', r'^exited with code 3$'),
    ],
)
def test_a_worker_that_ends(link: MakeLink, script: str, ending: str) -> None:
    worker = link(f"say('found', missing=[])\n{script}")
    with pytest.raises(WorkerError, match=ending):
        worker.send({'id': 1})
        worker.receive()
        worker.receive()


def test_what_it_prints_as_an_error_is_in_the_log(
    link: MakeLink, tmp_path: Path
) -> None:
    worker = link(f"print('hello', file=sys.stderr)\n{ECHO}")
    worker.send({'id': 1})
    worker.receive()
    assert (tmp_path / 'launch_files.log').read_text() == 'hello\n'


def test_polling_does_not_wait(link: MakeLink) -> None:
    worker = link(ECHO)
    worker.send({'id': 1})
    worker.receive()
    assert worker.poll() is None
    worker.send({'id': 2})
    assert select.select([worker.descriptor], [], [], DEADLINE)[0]
    assert worker.poll() == {'say': 'done', 'id': 2}
    worker.entrust()
    os.kill(worker.pid, signal.SIGKILL)
    assert select.select([worker.descriptor], [], [], DEADLINE)[0]
    assert worker.poll() is None
    assert worker.descriptor == -1
    os.waitpid(worker.pid, 0)
    worker.reaped()
    with pytest.raises(WorkerError):
        worker.receive()


def test_what_runs_in_the_background_outlives_a_release(
    link: MakeLink,
) -> None:
    child = "child = subprocess.Popen(['sleep', '1000'])\n"
    worker = link(f"{child}say('child', pid=child.pid)\n{ECHO}")
    worker.send({'id': 1})
    child_pid = worker.receive()['pid']
    pid = worker.pid
    worker.release()
    assert has_ended(pid)
    assert not has_ended(child_pid)
    worker.close()
    wait_for_end(child_pid)


KILLED = """\
import os, sys
from pathlib import Path
from colcon_yamllaunch.python_launch.worker_process import WorkerProcess
from colcon_yamllaunch.engine.launch_scan import new_identity
log = Path('/dev/null')
link = WorkerProcess(dict(os.environ), '/', log, new_identity(), 1e3)
link.send({'id': 1})
print(link.pid, link.receive()['pid'], flush=True)
link.receive()
"""


def test_it_ends_with_a_launcher_that_is_killed(
    link: MakeLink, tmp_path: Path
) -> None:
    link(DEAF)
    path = f'{tmp_path}/python0:{os.environ["PATH"]}'
    with subprocess.Popen(
        [sys.executable, '-c', KILLED],
        env={**os.environ, 'PATH': path},
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as launcher:
        assert launcher.stdout is not None
        pids = [int(word) for word in launcher.stdout.readline().split()]
        launcher.kill()
    wait_for_end(*pids)


@pytest.mark.parametrize('text', ['x', '0', '-1', 'nan', 'inf'])
def test_a_time_limit_that_is_none(text: str) -> None:
    with pytest.raises(UserError, match='COLCON_LAUNCH_PYTHON_TIMEOUT'):
        worker_process.timeout_of({'COLCON_LAUNCH_PYTHON_TIMEOUT': text})


def test_the_time_limit() -> None:
    name = 'COLCON_LAUNCH_PYTHON_TIMEOUT'
    assert worker_process.timeout_of({}) == 60
    assert worker_process.timeout_of({name: ''}) == 60
    assert worker_process.timeout_of({name: '2.5'}) == 2.5
