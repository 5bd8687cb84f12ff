# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A part runs, and the launcher has all of it, whatever the link does."""

import contextlib
import os
import signal
import time

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.control.client import LaunchEndedError, running_launches
from colcon_yamllaunch.engine.commands import Describe, Kill, Restart, Shutdown
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.plan_json import plan_to_json
from colcon_yamllaunch.remote import machine_link
from colcon_yamllaunch.remote.connection import bootstrap, connect_process
from colcon_yamllaunch.remote.connection.connection_errors import ConnectError
from colcon_yamllaunch.remote.part_protocol import LINK_LOST, Measure
import pytest
from support.linked_part import LinkedPart, PlainMachine, process
from support.marked_processes import command_of
from support.time_limits import within

# writes 20,000 lines in a second or more
MANY_LINES = """\
i=0
while [ $i -lt 20000 ]; do
  echo line $i; i=$((i+1)); [ $((i%200)) != 0 ] || sleep 0.01
done
"""
LINES = [f'line {i}' for i in range(20_000)]


def test_a_part_runs_and_is_stopped(plain: PlainMachine) -> None:
    script = 'echo hello; echo oh >&2; sleep 1000'
    with LinkedPart(plain.machine(), [process('arm│a', script)]) as part:
        before = time.time()
        part.wait_for(lambda: part.out() and part.out(stream='stderr'))
        assert part.out() == 'hello\n'
        assert part.out(stream='stderr') == 'oh\n'
        assert all(before - 10 < t < time.time() + 10 for t in part.times)
        assert part.told.index('started') < part.told.index('output')
        part.finish()
        assert part.gone_for == 'it has ended'
        assert {'signalled', 'exited', 'ended'} <= set(part.told)
    plain.wait_until_empty()
    logs = plain.home / '.ros' / 'log' / 'launch_test'
    assert 'hello' in (logs / 'launch.log').read_text()


def test_missing_setup_script_is_an_error(
    plain: PlainMachine,
) -> None:
    with pytest.raises(UserError, match=r'^arm: there is no .*setup.bash'):
        LinkedPart(plain.machine(), [], workspace=str(plain.home / 'ws'))
    plain.wait_until_empty()


def test_commands_are_executed_and_answered(plain: PlainMachine) -> None:
    script = 'echo begun; sleep 1000'
    with LinkedPart(plain.machine(), [process('arm│a', script)]) as part:
        part.wait_for(part.out)
        usage = part.answer(Measure())
        assert usage['usage']['arm│a'][1] > 0
        described = part.answer(Describe('arm│a'))['description']
        assert described['label'] == 'arm│a'
        refused = part.answer(Kill('nobody'))
        assert refused['error'] == "there is no process 'nobody'"
        assert part.answer(Restart('arm│a'))['ok']
        part.wait_for(lambda: part.out() == 'begun\nbegun\n')
        part.finish()
    plain.wait_until_empty()


def test_output_is_complete_after_lost_connections(
    plain: PlainMachine,
) -> None:
    machine = plain.machine(on_lost='keep')
    with LinkedPart(machine, [process('arm│a', MANY_LINES)]) as part:
        for count in (1, 2, 3):
            size = len(part.out())
            part.wait_for(lambda size=size: len(part.out()) > size)
            part.cut()
            part.wait_for_told('back', count)
        part.wait_for_told('exited')
        assert part.out().splitlines() == LINES
        assert part.told.count('exited') == part.told.count('started') == 1
        assert part.told.index('exited') > part.told.index('back')
        part.finish()
    plain.wait_until_empty()


def test_kept_part_runs_on_without_a_connection(
    plain: PlainMachine, monkeypatch: pytest.MonkeyPatch
) -> None:
    machine = plain.machine(on_lost='keep')
    with LinkedPart(machine, [process('arm│a', MANY_LINES)]) as part:
        part.wait_for(part.out)
        connect = connect_process.connect_command
        monkeypatch.setattr(
            connect_process, 'connect_command', lambda *_, **__: ['false']
        )
        part.cut()
        part.wait_for_told('lost')
        # it has ended long before
        until = time.monotonic() + 12
        turns = []
        part.wait_for(lambda: turns.append(1) or time.monotonic() > until)
        assert 'gone' not in part.told
        # the launcher is idle meanwhile
        assert len(turns) < 2000
        monkeypatch.setattr(connect_process, 'connect_command', connect)
        part.wait_for_told('exited')
        assert part.out().splitlines() == LINES
        part.finish()
    plain.wait_until_empty()


def test_ended_connection_stops_the_part_at_once(
    plain: PlainMachine, monkeypatch: pytest.MonkeyPatch
) -> None:
    script = 'echo begun; sleep 1000'
    # the machine is told another time
    monkeypatch.setattr(machine_link, 'LOST_AFTER', 2)
    monkeypatch.setattr(machine_link, 'STOPPED_AFTER', 2)
    with LinkedPart(plain.machine(), [process('arm│a', script)]) as part:
        part.wait_for(part.out)
        monkeypatch.setattr(
            connect_process, 'connect_command', lambda *_, **__: ['false']
        )
        part.cut()
        part.wait_for_told('lost')
        plain.wait_until_empty()
        logs = plain.home / '.ros/log/launch_test/launch.log'
        assert 'the connection to the launcher has ended' in logs.read_text()
        part.wait_for_told('gone')
        assert part.gone_for is not None
        assert 'its part has stopped itself' in part.gone_for


def test_part_stopped_for_a_lost_link_says_so(plain: PlainMachine) -> None:
    script = "trap 'sleep 1; exit' INT; echo begun; sleep 1000 & wait"
    with LinkedPart(plain.machine(), [process('arm│a', script)]) as part:
        part.wait_for(part.out)
        part.cut()
        part.wait_for_told('gone')
        # what ends it is not the end of the launch
        reasons = [e['reason'] for e in part.events('shutdown')]
        assert all(reason.startswith(LINK_LOST) for reason in reasons)
    plain.wait_until_empty()


@pytest.mark.parametrize('victim', ['engine', 'launcher'])
def test_silence_counts_from_lost_after(
    plain: PlainMachine, victim: str
) -> None:
    machine = plain.machine(lost_after=0.5)
    script = 'echo begun; sleep 1000'
    with LinkedPart(machine, [process('arm│a', script)]) as part:
        part.wait_for(part.out)
        # the shell starts it after what it prints
        part.wait_for(lambda: 'sleep 1000' in map(command_of, plain.pids()))
        if victim == 'engine':
            os.kill(part.engine, signal.SIGSTOP)
            part.wait_for_told('lost')
            assert part.reason == 'nothing was heard of it for 0.5 s'
            os.kill(part.engine, signal.SIGCONT)
        else:
            # no turn, so no heartbeat
            begin = time.monotonic()
            while 'sleep 1000' in map(command_of, plain.pids()):
                time.sleep(0.05)
            assert time.monotonic() - begin < 8
            part.wait_for_told('gone')
    plain.wait_until_empty()


@pytest.mark.parametrize('on_lost', ['stop', 'keep'])
def test_part_without_launcher_is_listed_on_its_machine(
    plain: PlainMachine, monkeypatch: pytest.MonkeyPatch, on_lost: str
) -> None:
    def phases(engine: int) -> list[str]:
        found: list[str] = []
        variables = {'XDG_RUNTIME_DIR': str(plain.home)}
        for launch in running_launches(variables, print):
            # it may end as it is asked
            with contextlib.suppress(LaunchEndedError):
                if launch.pid == engine:
                    states = launch.refresh().processes
                    found = [state.phase for state in states]
            launch.close()
        return found

    script = "trap '' INT; echo begun; while :; do sleep 1; done"
    one = process('arm│a', script, sigterm_timeout=3.0)
    with LinkedPart(plain.machine(on_lost=on_lost), [one]) as part:
        part.wait_for(part.out)
        engine = part.engine
        assert phases(engine) == []
        monkeypatch.setattr(
            connect_process, 'connect_command', lambda *_, **__: ['false']
        )
        part.cut()
        expected = ['running' if on_lost == 'keep' else 'stopping']
        part.wait_for(lambda: phases(engine) == expected)
        if on_lost == 'keep':
            # what `--stop` there asks for
            variables = {'XDG_RUNTIME_DIR': str(plain.home)}
            for launch in running_launches(variables, print):
                if launch.pid == engine:
                    launch.do(Shutdown())
                launch.close()
            part.wait_for(lambda: not phases(engine))
    plain.clear()


def test_new_part_is_started_on_a_machine_that_is_gone(
    plain: PlainMachine,
) -> None:
    script = 'echo begun; sleep 1000'
    with LinkedPart(plain.machine(), [process('arm│a', script)]) as part:
        part.wait_for(part.out)
        first = part.identity
        part.cut()
        part.wait_for_told('gone')
        plan = Plan((process('arm│a', 'echo again; sleep 1000'),))
        part.link.start_again(lambda: plan_to_json(plan), at_once=True)
        part.wait_for(lambda: 'again' in part.out())
        assert part.told[part.told.index('gone') :].count('back') == 1
        assert part.identity != first
        part.gone_for = None
        part.finish()
    plain.wait_until_empty()


def test_silence_is_a_loss(plain: PlainMachine) -> None:
    script = 'echo begun; sleep 1000'
    with LinkedPart(plain.machine(), [process('arm│a', script)]) as part:
        part.wait_for(part.out)
        os.kill(part.engine, signal.SIGSTOP)
        begin = time.monotonic()
        with within(10):
            part.wait_for_told('lost')
        assert time.monotonic() - begin > 2
        assert part.reason == 'nothing was heard of it for 4.5 s'
        os.kill(part.engine, signal.SIGCONT)
        part.wait_for_told('back')
        part.finish()
    plain.wait_until_empty()


def test_paused_link_delivers_nothing(plain: PlainMachine) -> None:
    script = 'echo first; sleep 1; yes abcdefgh | head -c 20000000'
    with LinkedPart(plain.machine(), [process('arm│a', script)]) as part:
        part.wait_for(part.out)
        part.link.pause(True)
        until = time.monotonic() + 7
        part.wait_for(lambda: time.monotonic() > until)
        assert part.out() == 'first\n'
        assert 'lost' not in part.told
        part.link.pause(False)
        part.wait_for_told('exited')
        assert len(part.out()) == 20_000_006
        part.finish()


def test_output_is_complete_after_a_paused_link_was_lost(
    plain: PlainMachine,
) -> None:
    machine = plain.machine(on_lost='keep')
    with LinkedPart(machine, [process('arm│a', MANY_LINES)]) as part:
        part.wait_for(part.out)
        part.link.pause(True)
        until = time.monotonic() + 1
        part.wait_for(lambda: time.monotonic() > until)
        part.cut()
        part.wait_for_told('back')
        part.link.pause(False)
        part.wait_for_told('exited')
        assert part.out().splitlines() == LINES
        assert part.told.count('started') == 1
        part.finish()
    plain.wait_until_empty()


def test_slow_loop_does_not_lose_the_link(plain: PlainMachine) -> None:
    with LinkedPart(plain.machine(), [process('arm│a', 'sleep 99')]) as part:
        part.wait_for_told('started')
        time.sleep(machine_link.CONNECTION_SILENCE + 1)
        part.turn()
        part.turn()
        assert 'lost' not in part.told
        part.finish()


def test_part_that_never_began_is_stopped(plain: PlainMachine) -> None:
    part = LinkedPart(plain.machine(), [process('arm│a', 'sleep 99')])
    assert plain.pids()
    part.__exit__()
    plain.wait_until_empty()


HOSTILE = {
    'noise': "launcher_channel.write(b'x\\n' * 100_000)",
    'length': """launcher_channel.write(b'{"packed": {"bytes": -1}}\\n')""",
    'bomb': (
        "body = zlib.compress(b'0' * (1 << 27), 1)\n"
        "launcher_channel.write(protocol.encode_raw('packed', {}, body))"
    ),
    'no object': "launcher_channel.write(b'[1]\\n')",
    'deep': "launcher_channel.write(b'[' * 99999 + b'\\n')",
    'output': """launcher_channel.write(b'{"output": "abc"}\\n')""",
    'flood': (
        'at = 0\n'
        'while True:\n'
        "    fields = {'process': 'arm│a', 'stream': 'stdout', 'time': 0.0}\n"
        "    fields['at'] = at\n"
        '    at += 1 << 20\n'
        "    data = protocol.encode_raw('output', fields, bytes(1 << 20))\n"
        '    launcher_channel.write(data)'
    ),
}


@pytest.mark.hostile
@pytest.mark.parametrize('name', HOSTILE)
def test_machine_that_sends_nonsense_is_dropped(
    plain: PlainMachine, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    # what its agent is replaced by
    code = f"""
import os, zlib
from colcon_yamllaunch.remote.agent import launcher_channel
from colcon_yamllaunch.control import protocol

def pass_on(engine):
    os.write(1, b'{{"ok": true, "id": "subscribed", "asked": 0}}\\n')
{''.join(f'    {line}{chr(10)}' for line in HOSTILE[name].splitlines())}
    os.read(0, 1 << 16)
    while os.read(0, 1 << 16):
        pass
    raise launcher_channel.LauncherGoneError
"""
    before = bootstrap._PROGRAM
    ours = 'from colcon_yamllaunch.remote.agent.machine_agent'
    file = plain.home / 'hostile.py'
    file.write_text(code, encoding='utf-8')
    line = (
        'import colcon_yamllaunch.remote.agent.part_link as link\n'
        f'exec(open("{file}", encoding="utf-8").read(), vars(link))\n'
    )
    monkeypatch.setattr(
        bootstrap, '_PROGRAM', before.replace(ours, line + ours)
    )
    try:
        linked = LinkedPart(plain.machine(), [process('arm│a', 'sleep 99')])
    except ConnectError as error:
        # it may come with the answer to the start
        assert 'the connection is damaged: ' in str(error)
        return
    with linked as part:
        if name == 'flood':
            part.link.pause(True)
        part.wait_for_told('gone')
        assert part.gone_for is not None
        assert part.gone_for.startswith('the connection is damaged: ')
