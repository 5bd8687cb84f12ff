# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Real launches, and clients of their sockets, well-behaved or not."""

import os
from pathlib import Path
import resource
import select
import signal

from colcon_yamllaunch.control import protocol
from colcon_yamllaunch.control.client import (
    ControlError,
    LaunchEndedError,
    running_launches,
    RunningLaunch,
)
from colcon_yamllaunch.control.orphaned_launches import orphaned_launches
from colcon_yamllaunch.engine import commands
import pytest
from support.controlled import ABOUT, idles, memory_of

#: Says what it reads, and reads each line of it at once.
ECHO = (
    'import sys\n'
    'print("ready", flush=True)\n'
    'for line in sys.stdin: print("read", line.strip(), flush=True)\n'
)


def stat_of(path):
    status = path.stat()
    return status.st_mode & 0o777, status.st_uid


def test_socket_is_private_and_removed_at_the_end(controlled, sleep):
    c = controlled(sleep('a'))
    record, path = sorted(c.folder.iterdir())
    assert (record.suffix, path.suffix) == ('.json', '.sock')
    assert stat_of(c.folder) == (0o700, os.getuid())
    assert stat_of(path) == stat_of(record) == (0o600, os.getuid())
    assert c.one.sends(signal.SIGINT).ends() == 0
    assert list(c.folder.iterdir()) == []


def test_the_status_has_everything(controlled, sleep, sh):
    c = controlled(
        sleep('a', package='my_pkg', node_name='/demo/a', name='sleep-1'),
        sh('b', 'exit 3'),
        sleep('c', output='screen'),
    )
    c.becomes('b', 'ended')
    state = c.client.refresh()
    assert (state.title, state.package) == ('my_pkg demo.yaml', 'my_pkg')
    assert state.pid == c.one.popen.pid
    assert state.log_folder == str(c.one.log_folder)
    assert not state.stopping
    a, b, without_log = state.processes
    assert (a.phase, a.node, a.package) == ('running', '/demo/a', 'my_pkg')
    assert os.getpgid(a.pid) == a.pid
    assert (a.executable, a.restarts, a.terminal) == ('sleep', 0, False)
    assert (a.name, b.name) == ('sleep-1', 'b')
    assert Path(a.log).parent.name == 'a-1'
    assert b.ending == 'exited with code 3'
    assert b.pid is None
    assert without_log.log is None


def test_a_process_is_stopped_and_restarted(controlled, sh, is_running):
    c = controlled(
        sh('a', 'sleep 99; true', respawn=True, on_exit_shutdown=True),
        sh('b', 'sleep 99; true'),
    )
    first = c.becomes('a', 'running').pid
    c.client.do(commands.Stop('a'))
    stopped = c.becomes('a', 'ended')
    assert stopped.ending == 'stopped'
    assert not is_running(first)
    c.client.do(commands.Restart('a'))
    second = c.becomes('a', 'running')
    assert second.pid != first
    assert second.restarts == 1
    assert c.process('b').restarts == 0
    assert c.one.sends(signal.SIGINT).ends() == 0
    actions = [e['action'] for e in c.one.events('requested')]
    assert actions == ['stop', 'restart']


def test_refused_command_has_a_reason(idle):
    with pytest.raises(ControlError, match="no process 'x'"):
        idle.client.do(commands.Stop('x'))
    with pytest.raises(ControlError, match='emulate_tty'):
        idle.client.request('attach', process='a')
    assert idle.process('a').phase == 'running'


def test_oldest_client_is_closed_above_the_limit(controlled, sleep):
    c = controlled(sleep('a'))
    for _ in range(protocol.MAXIMUM_CLIENTS):
        last = c.connect()
    assert last.refresh().pid == c.one.popen.pid
    with pytest.raises(LaunchEndedError):
        c.client.refresh()


@pytest.mark.parametrize(
    'line',
    [
        b'\x00\xff\xfe garbage \x80\n',
        b'[]\n',
        b'{}\n',
        b'{"version": 99, "request": "status"}\n',
        b'{"version": 1, "request": "dance"}\n',
        b'{"version": 1, "request": "stop"}\n',
        b'{"version": 1, "request": {"a": [1]}, "process": 7}\n',
        b'x' * (protocol.MAXIMUM_REQUEST + 70_000),
        b'[' * 60_000 + b'\n',
    ],
)
def test_malformed_request_gets_an_error(idle, line):
    client = idle.connect()
    client.connection.sendall(line)
    assert client.receive()['ok'] is False
    with pytest.raises(LaunchEndedError):
        client.receive()
    assert idle.process('a').phase == 'running'


def test_request_in_pieces_is_answered(idle):
    client = idle.connect()
    for byte in protocol.encode(protocol.request('status')):
        client.connection.sendall(bytes([byte]))
    assert client.receive()['ok']


@pytest.mark.full
def test_client_that_never_reads_costs_no_time_and_memory(controlled, sleep):
    c = controlled(sleep('a' * 1000))
    before = memory_of(c.one.popen.pid)
    deaf = c.raw()
    deaf.setblocking(False)
    requests = protocol.encode(protocol.request('status')) * 1000
    sent = 0
    while select.select([], [deaf], [], 0.5)[1]:
        sent += deaf.send(requests)
        assert sent < 5_000_000
    assert memory_of(c.one.popen.pid) - before < 8_000_000
    assert c.client.refresh().pid == c.one.popen.pid
    assert idles(c.one.popen.pid)


@pytest.mark.full
def test_vanished_client_is_forgotten(controlled, sleep, wait_until):
    c = controlled(sleep('a'))
    c.becomes('a', 'running')
    # by then it has also closed what that took
    assert idles(c.one.popen.pid)
    count = descriptors_of(c.one.popen.pid)
    for _ in range(5):
        raw = c.raw()
        raw.sendall(protocol.encode(protocol.request('status')) * 50)
        raw.close()
    wait_until(lambda: descriptors_of(c.one.popen.pid) <= count)
    assert idles(c.one.popen.pid)


@pytest.mark.full
def test_launch_continues_without_free_descriptors(controlled, sleep):
    c = controlled(sleep('a'))
    c.becomes('a', 'running')
    pid = c.one.popen.pid
    _, hard = resource.prlimit(pid, resource.RLIMIT_NOFILE)
    limit = (descriptors_of(pid), hard)
    resource.prlimit(pid, resource.RLIMIT_NOFILE, limit)
    with pytest.raises(LaunchEndedError):
        c.connect().refresh()
    assert idles(pid)
    assert c.process('a').phase == 'running'


def test_a_killed_launcher_leaves_no_socket(controlled, sleep, wait_until):
    c = controlled(sleep('a'))
    c.one.sends(signal.SIGKILL)
    c.one.popen.wait()
    wait_until(lambda: not list(c.folder.iterdir()))
    wait_until(lambda: not c.one.processes())


def test_a_launcher_without_a_guard_leaves_a_socket_for_the_next_look(
    controlled, sleep, wait_until
):
    c = controlled(sleep('a'))
    (guard,) = wait_until(c.one.guards)
    # who is just being started has the socket, too
    (process,) = wait_until(c.one.processes)
    wait_until(lambda: len(os.listdir(f'/proc/{process}/fd')) == 3)
    c.one.sends(signal.SIGSTOP)
    os.kill(guard, signal.SIGKILL)
    c.one.sends(signal.SIGKILL)
    c.one.popen.wait()
    assert {p.suffix for p in c.folder.iterdir()} == {'.sock', '.json'}
    assert running_launches(c.place, pytest.fail) == []
    # what the launch is known by stays as long as something of it runs
    (record,) = c.folder.iterdir()
    assert record.suffix == '.json'
    for pid in c.one.processes():
        os.kill(pid, signal.SIGKILL)
    wait_until(lambda: not c.one.processes())
    # that finds nothing of it, and so removes what is left
    orphaned_launches(c.place)
    assert list(c.folder.iterdir()) == []


def test_launch_without_socket_runs(launch, sleep, tmp_path):
    (tmp_path / f'colcon-launch-{os.getuid()}').write_text('in the way')
    one = launch(
        sleep('a'), about=ABOUT, environment={'TMPDIR': str(tmp_path)}
    )
    one.shows('other terminals cannot see this launch').shows('a: started')
    assert one.sends(signal.SIGINT).ends() == 0


def test_keys_go_to_an_attached_process_and_output_comes_back(
    controlled, python
):
    c = controlled(python('a', ECHO, emulate_tty=True), python('b', ECHO))
    c.one.shows('[a]      ready')
    c.client.request('attach', process='a')
    c.client.send({'keys': 'hello\r'})
    seen = ''
    while 'read hello\n' not in seen:
        seen += c.client.receive().get('output', '')
    # the echo of the terminal is not in the log
    c.wait_until(lambda: b'hello' in c.one.log('a/stdout.log'))
    assert c.one.log('a/stdout.log') == b'ready\nread hello\n'
    assert c.one.events('attached')[0]['label'] == 'a'
    c.client.close()
    c.one.shows('a: detached')


def test_attached_client_learns_how_the_process_ended(controlled, python):
    c = controlled(
        python('a', ECHO, emulate_tty=True, respawn=True, respawn_delay=0.1),
        python('b', ECHO, emulate_tty=True),
    )
    c.one.shows('[a]      ready')
    c.client.request('attach', process='a')
    c.client.send({'keys': '\x04'})
    assert told(c.client, 'ended') == {'ended': 'finished', 'again': True}
    assert told(c.client, 'started')['started'] > 0
    c.connect().do(commands.Stop('a'))
    assert told(c.client, 'ended')['again'] is False


def test_prompt_is_shown_on_attaching(controlled, python):
    script = 'import time; print("Name: ", end="", flush=True); time.sleep(9)'
    c = controlled(python('a', script, emulate_tty=True))
    for _ in range(2):
        client = c.connect()
        client.request('attach', process='a')
        assert told(client, 'output') == {'output': 'Name: '}


@pytest.mark.full
def test_slow_attached_client_skips_output(controlled, python):
    script = (
        'import os, sys\n'
        'sys.stdin.readline()\n'
        'for _ in range(3000): os.write(1, b"x" * 8191 + b"\\n")\n'
        'os.write(1, b"done\\n")\n'
        'sys.stdin.readline()\n'
    )
    c = controlled(python('a', script, emulate_tty=True, output='own_log'))
    c.becomes('a', 'running')
    before = memory_of(c.one.popen.pid)
    slow = c.connect()
    slow.request('attach', process='a')
    slow.send({'keys': 'go\r'})
    log = c.one.log_folder / 'a/stdout.log'
    size = 3000 * 8192 + 5
    c.wait_until(lambda: log.exists() and log.stat().st_size == size)
    assert memory_of(c.one.popen.pid) - before < 16_000_000
    assert c.client.refresh().pid == c.one.popen.pid
    received = skipped = 0
    while not skipped:
        message = slow.receive()
        received += len(message.get('output', ''))
        skipped = message.get('skipped', 0)
    assert 0 < received < size
    assert received + skipped >= size


@pytest.mark.full
def test_unread_keys_use_no_memory(controlled, sleep):
    c = controlled(sleep('a', emulate_tty=True))
    c.becomes('a', 'running')
    before = memory_of(c.one.popen.pid)
    client = c.connect()
    client.request('attach', process='a')
    for _ in range(1000):
        client.send({'keys': 'x' * 20_000})
    assert c.client.refresh().pid == c.one.popen.pid
    assert memory_of(c.one.popen.pid) - before < 8_000_000
    assert idles(c.one.popen.pid)


def told(client: RunningLaunch, key):
    """Return the next message that has a key."""
    while key not in (message := client.receive()):
        continue
    return message


def descriptors_of(pid):
    return len(os.listdir(f'/proc/{pid}/fd'))
