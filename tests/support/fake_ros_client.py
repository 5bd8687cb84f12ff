# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
A client that speaks with no ROS, but with files in the folder `FAKE_ROS`.

The container `/box` is there while the process runs whose id is in the file
`box.there`, and a line of `box.loaded` is a component that it has loaded. The
plugin `Nope` is none, and `Slow` is loaded once there is a file `slow`. A node
`/lc` is there alike; while there is a file `bad`, its transitions fail. With a
file `broken` a client dies at once, with `unready` a bit later.
"""

import json
import os
from pathlib import Path
import select
import sys
from typing import Any

_STATES = {
    'configure': ('configuring', 'inactive'),
    'activate': ('activating', 'active'),
}
FOLDER = Path(os.environ['FAKE_ROS'])


def say(**message: Any) -> None:
    print(json.dumps(message), flush=True)


class Client:
    """What it was asked for, and what it has seen."""

    def __init__(self) -> None:
        self.loads: dict[str, list[dict[str, Any]]] = {}
        self.changes: list[dict[str, Any]] = []
        self.seen: dict[str, bool] = {}
        self.followed: dict[str, bool] = {}

    def take(self, request: dict[str, Any]) -> None:
        """Do what can be done at once, and note the rest."""
        number, do = request['id'], request['do']
        if 'container' in request:
            self.seen.setdefault(request['container'], False)
        if do == 'load':
            self.loads.setdefault(request['container'], []).append(request)
        elif do == 'cancel':
            for queue in self.loads.values():
                queue[:] = [r for r in queue if r['id'] != request['request']]
        elif do == 'change_state':
            self.changes.append(request)
        elif do == 'follow':
            self.followed[request['node']] = False
            say(id=number, ok=True)
        elif do == 'list':
            nodes = self.nodes(request['container'])
            if nodes is None:
                say(id=number, ok=False, reason='not there')
            else:
                say(id=number, ok=True, nodes=nodes)
        elif do == 'unload':
            nodes = self.nodes(request['container']) or []
            nodes = [n for n in nodes if n[1] != request['unique_id']]
            self.store(request['container'], nodes)
            say(id=number, ok=True)

    def look(self) -> None:
        """Do what can be done now."""
        for container, before in self.seen.items():
            now = self.is_present(container)
            if now != before:
                self.seen[container] = now
                say(event='container', container=container, there=now)
        for container, queue in self.loads.items():
            while queue and self.seen[container]:
                if not self.load(container, queue[0]):
                    break
                del queue[0]
        for node, before in self.followed.items():
            self.followed[node] = self.is_present(node)
            if self.followed[node] and not before:
                say(event='state', node=node, state='unconfigured')
        changes, self.changes = self.changes, []
        for request in changes:
            if not self.is_present(request['node']):
                self.changes.append(request)
            elif (FOLDER / 'bad').exists():
                say(id=request['id'], ok=False, reason='it is bad')
            else:
                before, state = _STATES[request['transition']]
                say(
                    event='state',
                    node=request['node'],
                    state=state,
                    **{'from': before},
                )
                say(id=request['id'], ok=True)

    def load(self, container: str, request: dict[str, Any]) -> bool:
        """Load a component; return whether that is over."""
        plugin, number = request['plugin'], request['id']
        if plugin == 'Slow' and not (FOLDER / 'slow').exists():
            (FOLDER / 'loading').touch()
            return False
        if plugin == 'Nope':
            say(id=number, ok=False, reason='there is no such plugin')
            return True
        nodes = self.nodes(container) or []
        unique_id = max([n[1] for n in nodes], default=0) + 1
        name = f'{request["namespace"]}/{request["name"]}'
        self.store(container, [*nodes, [name, unique_id]])
        say(id=number, ok=True, full_name=name, unique_id=unique_id)
        return True

    @staticmethod
    def is_present(name: str) -> bool:
        try:
            pid = (FOLDER / f'{name[1:]}.there').read_text()
            os.kill(int(pid), 0)
        except (FileNotFoundError, ProcessLookupError, ValueError):
            return False
        return True

    def nodes(self, container: str) -> list[list[Any]] | None:
        if not self.is_present(container):
            return None
        try:
            text = (FOLDER / f'{container[1:]}.loaded').read_text()
        except FileNotFoundError:
            return []
        return [json.loads(line) for line in text.splitlines()]

    @staticmethod
    def store(container: str, nodes: list[list[Any]]) -> None:
        lines = ''.join(json.dumps(node) + '\n' for node in nodes)
        (FOLDER / f'{container[1:]}.loaded').write_text(lines)


def main() -> None:
    if (FOLDER / 'broken').exists():
        sys.exit('it is broken')
    (FOLDER / 'pid').write_text(str(os.getpid()))
    missing = set(os.environ.get('FAKE_MISSING', '').split())
    found = [name for name in sys.argv[1:] if name in missing]
    say(event='found', missing=found)
    if found:
        return
    if (FOLDER / 'unready').exists():
        sys.exit('it does not get ready')
    say(event='ready')
    client = Client()
    data = b''
    while True:
        client.look()
        if select.select([0], [], [], 0.01)[0]:
            piece = os.read(0, 65536)
            if not piece:
                return
            *lines, data = (data + piece).split(b'\n')
            for line in lines:
                client.take(json.loads(line))


if __name__ == '__main__':
    main()
