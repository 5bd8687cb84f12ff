# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Whatever is killed on either side of a link, nothing is left running."""

import os
import signal
import subprocess
import sys

import pytest
from support.linked_part import DEADLINE, LinkedPart, PlainMachine, process
from support.time_limits import within

#: Ignores what it may, and has a child in another session.
STUBBORN = "trap '' INT TERM; setsid sh -c 'sleep 1000' & echo begun; wait"


def stubborn(label: str = 'arm│a') -> object:
    """Return a process that only SIGKILL ends."""
    return process(label, STUBBORN, sigterm_timeout=0.5, sigkill_timeout=0.5)


def test_killed_guard_is_replaced(plain: PlainMachine) -> None:
    with LinkedPart(plain.machine(), [stubborn()]) as part:
        part.wait_for(part.out)
        first = part.guard
        os.kill(first, signal.SIGKILL)
        part.wait_for(lambda: _other_guard(part, first))
        os.kill(part.engine, signal.SIGKILL)
        part.wait_for_told('gone')
    plain.wait_until_empty()


def _other_guard(part: LinkedPart, first: int) -> bool:
    try:
        return part.guard != first
    except AssertionError:
        return False


def test_next_connection_stops_orphans_of_a_killed_part(
    plain: PlainMachine,
) -> None:
    part = LinkedPart(plain.machine(), [stubborn()])
    with part:
        part.wait_for(part.out)
        pids = [part.engine, part.guard, part.link.pid]
        for number in (signal.SIGSTOP, signal.SIGKILL):
            for pid in pids:
                os.kill(pid, number)
        os.waitpid(pids[-1], 0)
        # nobody is left who could do anything
        assert plain.pids()
        # whoever connects next ends it
        with LinkedPart(
            plain.machine(), [process('arm│b', 'echo b')]
        ) as another:
            another.wait_for(lambda: another.out('arm│b'))
            another.finish()
        plain.wait_until_empty()


LAUNCHER = """
import os, sys, time
sys.path[:0] = {path!r}
from pathlib import Path
from support.linked_part import *
from colcon_yamllaunch.deployment.deployment import Machine
machine = Machine('arm', 'connect', {words!r})
contact = MachineConnection(machine)
SLOW = {slow!r}
{code}
"""
SLOW = """
import subprocess
def wait(arguments, say):
    child = subprocess.Popen(['setsid', 'sleep', '99'])
    say('now')
    child.wait()
"""
PHASES = {
    'connected': 'contact.connect()\nprint("now", flush=True)\ntime.sleep(99)',
    'asking': (
        'contact.connect()\n'
        'modules = Path(machine.words[2][5:]).glob(\n'
        '    ".cache/colcon-launch/program/*/*/remote/sync")\n'
        '(next(modules) / "inspection.py").write_text(SLOW)\n'
        'contact.ask("inspection.wait", {},\n'
        '    lambda line: print(line, flush=True))'
    ),
    'streaming': (
        'contact.connect()\n'
        'null = os.open(os.devnull, os.O_RDONLY)\n'
        'words = ["sh", "-c", "echo now; sleep 99"]\n'
        'contact.run_program(words, null, 1)'
    ),
    'started': (
        'contact.connect()\n'
        'plan = Plan((process("arm│a", "sleep 99"),))\n'
        'contact.start_part(plan, PartSettings("arm"))\n'
        'print("now", flush=True)\ntime.sleep(99)'
    ),
    'running': (
        'part = LinkedPart(machine, [process("arm│a", "echo; sleep 99")])\n'
        'with part:\n'
        '    part.wait_for(part.out)\n'
        '    print("now", flush=True)\n'
        '    part.wait_for(lambda: False, 99)\n'
    ),
}


@pytest.mark.parametrize('number', [signal.SIGKILL, signal.SIGINT], ids=str)
@pytest.mark.parametrize('phase', PHASES)
def test_launcher_ended_in_any_phase_leaves_nothing(
    plain: PlainMachine, phase: str, number: int
) -> None:
    code = LAUNCHER.format(
        path=[p for p in sys.path if p],
        words=plain.words,
        slow=SLOW,
        code=PHASES[phase],
    )
    with subprocess.Popen(
        [sys.executable, '-c', code],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    ) as launcher:
        assert launcher.stdout is not None
        assert launcher.stdout.readline() == b'now\n'
        assert plain.pids()
        launcher.send_signal(number)
        # it may end first what another test has left, which takes some; its
        # launcher's silence is noticed after 30 s
        with within(DEADLINE if phase == 'running' else 20):
            plain.wait_until_empty()
        launcher.wait()
