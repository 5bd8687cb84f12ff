# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
A machine that answers up to some point, and then does harm.

Run as a program it stands for the machine, as `connect:` reaches it.
"""

from collections.abc import Callable
import os
import sys
import time
from typing import Any

from colcon_yamllaunch.control import protocol
from colcon_yamllaunch.control.protocol import MessageReader
from colcon_yamllaunch.deployment.deployment import Machine
from colcon_yamllaunch.remote.connection import bootstrap

#: What it may do: say nothing more after the first word or after it has
#: answered what it is like or been asked to start; leave out what it has
#: started; or send heartbeats and read nothing.
WAYS = (
    'silent after have',
    'silent after hello',
    'silent after start',
    'starts nothing',
    'reads nothing',
)
_HELLO = {
    **dict.fromkeys(('python', 'executable', 'system', 'architecture'), '?'),
    'host': 'arm',
    'home': '/',
    'workspace': None,
    'has_workspace': False,
    'programs': {},
    'clock': 0,
    'took': 0,
}


def hostile_machine(way: str) -> Machine:
    """Return a machine, one of `WAYS`."""
    words = (sys.executable, __file__, way)
    return Machine('arm', 'connect', words, sync='none')


class _HostileMachine:
    def __init__(self, way: str) -> None:
        self._way = way
        self._reader = MessageReader()

    def run(self) -> None:
        script = b''
        while not script.endswith(b'exit 0\n}\n'):
            script += self._read()
        os.write(1, bootstrap.MARK + b'have\n')
        self._silent_after('have')
        while True:
            for message in self._reader.feed(self._read()):
                self._take(message)

    def _take(self, content: dict[str, Any]) -> None:
        match content:
            case {'request': 'hello', 'id': number}:
                self._say(reply=number, result=_HELLO)
                self._silent_after('hello')
                if self._way == 'reads nothing':
                    _for_ever(lambda: self._say(beat=0))
            case {'request': 'start', 'id': number}:
                self._silent_after('start')
                result = {'identity': 'i', 'boot': 'b'}
                if self._way == 'starts nothing':
                    result.clear()
                self._say(reply=number, result=result)
            case {'request': _, 'id': number}:
                self._say(reply=number, result={})
            case {'relay': _}:
                self._say(relay=True)
                answer = b'{"ok": true, "id": "subscribed", "asked": 0}\n'
                os.write(1, answer)
                _for_ever(lambda: os.write(1, b'{"pong": null}\n'))

    def _silent_after(self, what: str) -> None:
        if self._way == f'silent after {what}':
            _for_ever(bool)

    def _read(self) -> bytes:
        data = os.read(0, 1 << 16)
        if not data:
            sys.exit()
        return data

    def _say(self, **content: Any) -> None:
        try:
            os.write(1, protocol.encode(content))
        except BrokenPipeError:
            sys.exit()


def _for_ever(act: Callable[[], object]) -> None:
    # it ends with the test in any case
    parent = os.getppid()
    while os.getppid() == parent:
        act()
        time.sleep(0.1)
    sys.exit()


if __name__ == '__main__':
    _HostileMachine(sys.argv[1]).run()
