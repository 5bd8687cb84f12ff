# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the journal is sent when it is slow, or lines are long."""

from collections.abc import Iterator
from pathlib import Path
import socket
from types import SimpleNamespace
from typing import Any

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.loop import Loop
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.service import journald
from colcon_yamllaunch.service.journald import JournalOutput
import pytest

PROCESS = Process('lidar', ('true',), '/', Position('/ws/a.yaml', 1, 1))


@pytest.fixture
def journal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[socket.socket]:
    """Return the socket of a journal that is `j` in the current folder."""
    monkeypatch.chdir(tmp_path)
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as found:
        found.bind('j')
        found.settimeout(10)
        yield found


@pytest.fixture
def output(journal: socket.socket) -> JournalOutput:
    """Return what sends the output of a launch."""
    made = JournalOutput('j')
    state = SimpleNamespace(process=lambda _label: None)
    engine: Any = SimpleNamespace(loop=Loop(), state=state)
    made.join(engine)
    return made


def write(output: JournalOutput, data: bytes) -> None:
    output.handle_output(events.Output(PROCESS, 'stdout', data))


def test_long_line_is_split(
    output: JournalOutput, journal: socket.socket
) -> None:
    write(output, b'x' * (journald.LONGEST + 1) + b'\n')
    output.end_turn()
    first, second = (journal.recv(1 << 17) for _ in range(2))
    assert first.startswith(b'MESSAGE=' + b'x' * journald.LONGEST + b'\n')
    assert second.startswith(b'MESSAGE=x\nPRIORITY=6\n')
    output.finish()


def test_name_cannot_add_fields(
    output: JournalOutput, journal: socket.socket
) -> None:
    assert journald._field('A', b'1\nB=2') == (
        b'A\n\x05\x00\x00\x00\x00\x00\x00\x001\nB=2\n'
    )
    output.finish()


def test_slow_journal_loses_nothing_and_holds_processes(
    output: JournalOutput,
    journal: socket.socket,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(journald, 'PENDING_BYTES', 10_000)
    count = 0
    while output.accepts('lidar'):
        write(output, b'line %d\n' % count)
        output.end_turn()
        count += 1
    received = 0
    while received < count:
        assert journal.recv(1000).startswith(b'MESSAGE=line %d\n' % received)
        received += 1
        output.end_turn()
    assert output.accepts('lidar')
    output.finish()


def test_missing_journal_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(OSError, match='No such file'):
        JournalOutput(str(tmp_path / 'none'))
