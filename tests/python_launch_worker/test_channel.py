# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The worker reads requests while launch files do what they like."""

from collections.abc import Callable, Iterator
import json
import os
from pathlib import Path
import signal
import subprocess
import sys
from typing import Any

from colcon_yamllaunch.python_launch.worker import channel
import pytest
from support.waiting import is_running, wait_until

DEADLINE = 60.0


class Talk:
    """A program that uses the channel, and its other end."""

    def __init__(self, folder: Path, code: str) -> None:
        program = folder / 'program.py'
        program.write_text(
            'import os, subprocess, sys, time\n'
            f'from {channel.__name__} import Channel\n'
            'if os.getpgid(0) != os.getpid():\n'
            '    os.setpgid(0, 0)\n'
            'channel = Channel()\n' + code
        )
        self.folder = folder
        self.errors = folder / 'errors'
        with self.errors.open('wb') as errors:
            self.process = subprocess.Popen(
                [sys.executable, str(program)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=errors,
                cwd=folder,
                text=True,
            )

    def send(self, **fields: Any) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(json.dumps(fields) + '\n')
        self.process.stdin.flush()

    def take(self) -> Any:
        assert self.process.stdout is not None
        return json.loads(self.process.stdout.readline())

    def end(self) -> int:
        assert self.process.stdin is not None
        self.process.stdin.close()
        return self.process.wait(DEADLINE)


TalkBy = Callable[[str], Talk]


@pytest.fixture
def talk_by(tmp_path: Path) -> Iterator[TalkBy]:
    """Return a function that starts a program with some code."""
    started: list[Talk] = []

    def start(code: str) -> Talk:
        started.append(Talk(tmp_path, code))
        return started[-1]

    yield start
    for talk in started:
        talk.process.kill()
        talk.process.wait()
        assert talk.process.stdin is not None
        assert talk.process.stdout is not None
        talk.process.stdin.close()
        talk.process.stdout.close()


def test_requests_are_done_before_an_answer_comes(talk_by: TalkBy) -> None:
    talk = talk_by(
        "serve = lambda line: channel.say('served', line=line)\n"
        "answer = channel.ask('include', serve, path='/é')\n"
        "channel.say('answered', answer=answer)\n"
        'channel.receive()\n',
    )
    assert talk.take() == {'say': 'include', 'ask': 1, 'path': '/é'}
    talk.send(do='visit', id=7)
    assert talk.take()['line'] == {'do': 'visit', 'id': 7}
    talk.send(answer=1, scope={})
    assert talk.take()['answer'] == {'answer': 1, 'scope': {}}
    assert talk.end() == 0


def test_what_is_printed_and_read_is_not_of_the_channel(
    talk_by: TalkBy,
) -> None:
    talk = talk_by(
        "print('printed', flush=True)\n"
        "subprocess.run(['sh', '-c', 'echo from sh; cat'], check=True)\n"
        "channel.say('read', text=sys.stdin.read())\n"
        'channel.say(channel.receive()["do"])\n'
        'channel.receive()\n',
    )
    talk.send(do='next')
    assert talk.take() == {'say': 'read', 'text': ''}
    assert talk.take() == {'say': 'next'}
    assert talk.end() == 0
    assert talk.errors.read_text() == 'printed\nfrom sh\n'


@pytest.mark.parametrize('start', ['sleep', 'setsid sleep'])
def test_the_end_ends_whatever_was_started(
    talk_by: TalkBy, start: str
) -> None:
    talk = talk_by(
        f'one = subprocess.Popen({[*start.split(), "600"]!r})\n'
        "channel.say('started', pid=one.pid)\n"
        'time.sleep(600)\n',
    )
    pid = talk.take()['pid']
    assert is_running(pid)
    assert talk.end() == 0
    wait_until(lambda: not is_running(pid))


def test_it_ends_where_nobody_reads(talk_by: TalkBy) -> None:
    talk = talk_by(
        'channel.receive()\n'
        "channel.say('nothing')\n"
        "open('went-on', 'w').close()\n",
    )
    assert talk.process.stdout is not None
    talk.process.stdout.close()
    talk.send(do='go')
    assert talk.process.wait(DEADLINE) == 0
    assert not (talk.folder / 'went-on').exists()


def test_low_descriptors_are_not_of_the_channel(talk_by: TalkBy) -> None:
    talk = talk_by(
        'for number in range(3, 100):\n'
        '    try:\n'
        "        os.write(number, b'junk')\n"
        '    except OSError:\n'
        '        pass\n'
        'os.closerange(0, 100)\n'
        'channel.say(channel.receive()["do"])\n'
        'channel.receive()\n',
    )
    talk.send(do='next')
    assert talk.take() == {'say': 'next'}
    assert talk.end() == 0


def test_a_copy_of_the_worker_says_nothing(talk_by: TalkBy) -> None:
    talk = talk_by(
        'pid = os.fork()\n'
        'if pid == 0:\n'
        '    channel.at_end.append(lambda: open("ended-copy", "w"))\n'
        "channel.say('told', status=os.waitpid(pid, 0)[1] if pid else -1)\n"
        'channel.receive()\n',
    )
    assert talk.take() == {'say': 'told', 'status': 0}
    assert talk.end() == 0
    assert not (talk.folder / 'ended-copy').exists()


def test_a_copy_does_not_hide_the_end_of_the_worker(talk_by: TalkBy) -> None:
    talk = talk_by(
        'pid = os.fork()\n'
        'if pid == 0:\n'
        '    time.sleep(600)\n'
        "channel.say('forked', pid=pid)\n"
        'os._exit(3)\n',
    )
    pid = talk.take()['pid']
    try:
        assert talk.process.stdout is not None
        assert not talk.process.stdout.read()
        assert talk.process.wait(DEADLINE) == 3
    finally:
        os.kill(pid, signal.SIGKILL)


def test_a_log_that_cannot_be_written_is_no_error() -> None:
    descriptor = os.open('/dev/full', os.O_WRONLY)
    log = channel.log_output(descriptor)
    print('x' * 100_000, 'é\udcff', file=log)
    os.close(descriptor)
    print('gone', file=log)
    log.close()
