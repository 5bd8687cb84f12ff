# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A connection that dies before the launch is noticed and given up."""

import os
from pathlib import Path
import select
import threading
import time

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.remote.connection import machine_connection
from colcon_yamllaunch.remote.connection.connection_errors import ConnectError
from colcon_yamllaunch.remote.connection.machine_connection import (
    MachineConnection,
)
from colcon_yamllaunch.remote.part_protocol import PartSettings
import pytest
from support.hostile_machine import hostile_machine
from support.linked_part import PlainMachine

pytestmark = pytest.mark.hostile


@pytest.mark.parametrize(
    'way, reason',
    [
        ('silent after have', 'the connection broke off'),
        ('silent after hello', 'the connection broke off'),
        ('silent after start', 'the connection broke off'),
        ('starts nothing', 'it does not tell what it has started'),
    ],
)
def test_silent_machine_is_dropped(
    way: str, reason: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert machine_connection.CONNECTION_SILENCE < 5
    monkeypatch.setattr(machine_connection, 'CONNECTION_SILENCE', 1.5)
    contact = MachineConnection(hostile_machine(way))
    with pytest.raises(ConnectError, match=reason):
        contact.connect()
        contact.start_part(Plan(), PartSettings('arm'))
    contact.close()


def test_endless_heartbeats_are_no_answer(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    contact = MachineConnection(hostile_machine('reads nothing'))
    contact.connect()
    monkeypatch.setattr(machine_connection, 'CONNECT_TIMEOUT', 1.0)
    with pytest.raises(ConnectError, match="answer 'start' within 1 s"):
        contact.start_part(Plan(), PartSettings('arm'))
    contact.close()


def test_connection_that_takes_nothing_is_closed() -> None:
    contact = MachineConnection(hostile_machine('reads nothing'))
    contact.connect()
    its_input, to_it = os.pipe()
    null = os.open(os.devnull, os.O_RDWR)
    errors: list[UserError] = []

    def run() -> None:
        try:
            contact.run_program(['cat'], its_input, null)
        except UserError as error:
            errors.append(error)

    thread = threading.Thread(target=run)
    thread.start()
    # more than all pipes hold
    data = bytes(1 << 20)
    os.set_blocking(to_it, False)
    while select.select([], [to_it], [], 1)[1]:
        os.write(to_it, data)
    contact.close()
    thread.join()
    os.close(to_it)
    assert 'the connection broke off' in str(errors)


def test_machine_at_work_gives_heartbeats(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(machine_connection, 'CONNECTION_SILENCE', 3.0)
    plain = PlainMachine(tmp_path)
    contact = MachineConnection(plain.machine())
    contact.connect()
    begin = time.monotonic()
    # neither reads nor writes
    null = [os.open(os.devnull, os.O_RDWR) for _ in range(2)]
    assert contact.run_program(['sleep', '5'], *null) == (0, [])
    assert time.monotonic() - begin >= 5
    contact.close()
    plain.wait_until_empty()


def test_function_that_takes_long_gives_heartbeats(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(machine_connection, 'CONNECTION_SILENCE', 3.0)
    plain = PlainMachine(tmp_path)
    contact = MachineConnection(plain.machine())
    contact.connect()
    modules = plain.home.glob('.cache/colcon-launch/program/*/*/remote/sync')
    (next(modules) / 'inspection.py').write_text(
        'import time\ndef wait(arguments, say):\n    time.sleep(5)\n'
        '    say("x" * 100_000)\n    return {"slept": True}\n'
    )
    lines: list[str] = []
    assert contact.ask('inspection.wait', {}, lines.append) == {'slept': True}
    assert lines == ['x' * 100_000]
    contact.close()
    plain.wait_until_empty()
