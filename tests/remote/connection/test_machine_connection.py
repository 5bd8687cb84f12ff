# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Machines are connected with and asked, or it is said why not."""

from collections.abc import Iterator
import os
import threading

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.control.protocol import ProtocolError
from colcon_yamllaunch.deployment.deployment import Machine
from colcon_yamllaunch.remote.connection import machine_connection
from colcon_yamllaunch.remote.connection.connection_errors import ConnectError
from colcon_yamllaunch.remote.connection.machine_connection import (
    MachineConnection,
)
import pytest
from support.linked_part import PlainMachine
from support.sshd import Sshd
from support.time_limits import within


@pytest.fixture
def contact(plain: PlainMachine) -> Iterator[MachineConnection]:
    """Return a connection with `plain`; nothing runs there at the end."""
    contact = MachineConnection(plain.machine())
    contact.connect()
    yield contact
    contact.close()
    plain.wait_until_empty()


def ssh(sshd: Sshd, name: str, **more: object) -> MachineConnection:
    """Return what connects with a machine of `sshd`."""
    machine = Machine('arm', 'ssh', (name,), **more)  # type: ignore[arg-type]
    return MachineConnection(machine, (), sshd.environment(dict(os.environ)))


def failed(contact: MachineConnection) -> ConnectError:
    """Return why a machine cannot be connected with."""
    with pytest.raises(ConnectError) as caught:
        contact.connect()
    return caught.value


def test_connect_returns_the_facts(sshd: Sshd) -> None:
    (sshd['arm'].home / 'ws').mkdir()
    machine = Machine('arm', 'ssh', ('arm',))
    environment = sshd.environment(dict(os.environ))
    contact = MachineConnection(machine, ('/none', '~/ws'), environment)
    facts = contact.connect()
    assert facts.home == str(sshd['arm'].home)
    assert facts.workspace == str(sshd['arm'].home / 'ws')
    assert facts.has_workspace
    assert abs(facts.ahead) < 5
    contact.close()
    sshd.wait_until_empty()


def test_connection_closed_before_it_begins_does_not_stay(
    plain: PlainMachine,
) -> None:
    contact = MachineConnection(plain.machine())
    # as by a launch that turns out not to need the machine
    contact.close()
    failed(contact)
    plain.wait_until_empty()


def test_ask_calls_a_function_there(
    contact: MachineConnection, plain: PlainMachine
) -> None:
    (plain.home / 'there').touch()
    answer = contact.ask(
        'inspection.find_missing', {'paths': ['~/there', '~/missing']}
    )
    assert answer == {'missing': ['~/missing']}
    with pytest.raises(UserError, match=r'arm: there is no request'):
        contact.ask('a.b', {})
    with pytest.raises(
        UserError, match=r'arm: inspection.find_missing failed: KeyE'
    ):
        contact.ask('inspection.find_missing', {})


def test_program_there_reads_and_writes_descriptors(
    contact: MachineConnection, plain: PlainMachine
) -> None:
    data = os.urandom(3_000_000)
    its_input, to_it = os.pipe()
    from_it, its_output = os.pipe()
    got = []
    threads = [
        threading.Thread(target=_write, args=(to_it, data)),
        threading.Thread(target=lambda: got.append(_read(from_it))),
    ]
    for thread in threads:
        thread.start()
    command = ['sh', '-c', 'cat; pwd; echo oh no >&2; exit 3']
    ended = contact.run_program(command, its_input, its_output)
    assert ended == (3, ['oh no'])
    for thread in threads:
        thread.join()
    assert got == [data + f'{plain.home}\n'.encode()]
    with pytest.raises(UserError, match='no-such-program: No such file'):
        run(contact, 'no-such-program')
    # and others after it
    assert contact.ask('inspection.find_missing', {'paths': []}) == {
        'missing': []
    }


def run(contact: MachineConnection, *words: str) -> tuple[int, list[str]]:
    """Run a program there that reads nothing and whose output is dropped."""
    null = [os.open(os.devnull, os.O_RDWR) for _ in range(2)]
    return contact.run_program(words, *null)


def _write(descriptor: int, data: bytes) -> None:
    with open(descriptor, 'wb') as file:
        file.write(data)


def _read(descriptor: int) -> bytes:
    with open(descriptor, 'rb') as file:
        return file.read()


def test_another_thread_ends_a_connection(
    contact: MachineConnection, plain: PlainMachine
) -> None:
    modules = plain.home.glob('.cache/colcon-launch/program/*/*/remote/sync')
    (next(modules) / 'inspection.py').write_text(
        'import time\ndef wait(arguments, say):\n    say("")\n'
        '    time.sleep(99)\n'
    )
    begun = threading.Event()
    errors: list[Exception] = []

    def ask() -> None:
        try:
            contact.ask('inspection.wait', {}, lambda _: begun.set())
        except UserError as error:
            errors.append(error)

    thread = threading.Thread(target=ask)
    thread.start()
    begun.wait()
    contact.close()
    thread.join()
    assert 'the connection broke off' in str(errors[0])


def test_shell_that_starts_something_else_is_an_error(sshd: Sshd) -> None:
    sshd['arm'].shell_reads('while :; do echo "Press any key to begin"; done')
    text = str(failed(ssh(sshd, 'arm')))
    assert text.startswith('arm (ssh arm): something else answers than a')
    assert 'Press any key' in text
    assert "'.bashrc'" in text


def test_named_python_is_used(sshd: Sshd) -> None:
    text = str(failed(ssh(sshd, 'arm', python='/opt/none')))
    assert 'there is no /opt/none on its PATH' in text


def test_silent_machine_is_an_error(
    sshd: Sshd, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(machine_connection, 'CONNECT_TIMEOUT', 1.0)
    sshd['arm'].link.hold()
    with within(30):
        text = str(failed(ssh(sshd, 'arm')))
    assert text.startswith('arm (ssh arm): no answer within 1 s')


def test_missing_command_is_an_error() -> None:
    machine = Machine('edge', 'connect', ('dokker', 'exec', '-i', 'edge'))
    assert str(failed(MachineConnection(machine))) == (
        "edge (dokker exec -i edge): the program 'dokker' is not on the "
        'PATH; install it'
    )


def test_failed_command_is_an_error() -> None:
    words = 'sh', '-c', 'echo no such container: edge >&2; exit 1'
    text = str(failed(MachineConnection(Machine('edge', 'connect', words))))
    assert 'the connection ended before it stood (exit code 1)' in text
    assert text.endswith('\n  no such container: edge')


@pytest.mark.hostile
@pytest.mark.parametrize(
    'line',
    [
        *(b'[]', b'null', b'{', b'\xff', b'[' * 100_000, b'9' * 10_000),
        b'{"a": 1' + b'0' * 60 + b'}',
        b'{"a": {"b": -' + b'9' * 400 + b'}}',
        *(b'{"a": 1e999}', b'{"a": NaN}', b'{"a": -Infinity}'),
    ],
)
def test_message_that_is_no_object_is_refused(line: bytes) -> None:
    with pytest.raises(ProtocolError):
        machine_connection.read_message(line)
