# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Runs the plan that a JSON file describes; the tests start it."""

import json
import os
from pathlib import Path
import sys
from typing import Any

from colcon_yamllaunch.common import files as common_files
from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.control import socket_folder
from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.exit_conditions import ExitConditions
from colcon_yamllaunch.engine.line_pattern import LinePattern
from colcon_yamllaunch.engine.state import About
from colcon_yamllaunch.observers.presentation import Presentation
from colcon_yamllaunch.plan.plan import (
    ChangeState,
    Component,
    Entry,
    Message,
    ParameterFile,
    Plan,
    Process,
    Shutdown,
    SignalProcess,
    Timer,
    WorkerCall,
)
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.run import run, RunContext

_WITH_POSITION = {
    'call': WorkerCall,
    'change_state': ChangeState,
    'signal': SignalProcess,
}


def entry_of(data: dict[str, Any]) -> Entry:
    """Return the entry of a plan that one object stands for."""
    kind = data.pop('kind', 'process')
    if kind == 'message':
        return Message(**data)
    if kind == 'shutdown':
        return Shutdown(**data)
    if kind == 'timer':
        entries = tuple(entry_of(e) for e in data.pop('entries'))
        return Timer(entries=entries, **data)
    if kind in _WITH_POSITION:
        position = Position('/ws/demo.launch.py', 7, 9)
        return _WITH_POSITION[kind](position=position, **data)
    if kind == 'component':
        position = Position('/ws/demo.yaml', 7, 9)
        return Component(position=position, **data)
    data['argv'] = tuple(
        a if isinstance(a, str) else ParameterFile(a['content'])
        for a in data['argv']
    )
    data['environment'] = tuple(data.get('environment', {}).items())
    data.setdefault('cwd', '/')
    return Process(position=Position('/ws/demo.yaml', 14, 5), **data)


def main() -> int:
    """Run the plan, and return the exit code."""
    # sockets and parameter files are where TMPDIR says, and nowhere else
    socket_folder.USER_FOLDERS = '/does/not/exist'
    common_files.SHARED_FOLDERS = ()
    data = json.loads(Path(sys.argv[1]).read_text(encoding='utf-8'))
    if 'FAKE_ROS' in os.environ:
        from colcon_yamllaunch.engine import ros_link

        limits.HELPER_RESTARTS = 2
        ros_link.PROGRAM = Path(__file__).with_name('fake_ros_client.py')
    log_folder = data.get('log_folder')
    participants = ()
    if 'source' in data:
        from played_source import PlayedFeed, PlayedWorker

        limits.WORKER_ANSWER_TIMEOUT = data.get(
            'patience', limits.WORKER_ANSWER_TIMEOUT
        )
        participants = (
            PlayedFeed(
                PlayedWorker(data['source'], data.get('wanted', ()), entry_of)
            ),
        )
    context = RunContext(
        environment=dict(os.environ),
        log_folder=None if log_folder is None else Path(log_folder),
        color=data.get('color'),
        **{name: data[name] for name in ('tty', 'log_limit') if name in data},
        about=About(**data['about']) if 'about' in data else None,
        attach=data.get('attach'),
        conditions=ExitConditions(
            map(LinePattern, data.get('until', ())), data.get('timeout')
        ),
        presentation=Presentation(
            data.get('verbosity', 'normal'), status=data.get('status', False)
        ),
        participants=participants,
    )
    return run(Plan(tuple(entry_of(e) for e in data['entries'])), context)


if __name__ == '__main__':
    try:
        sys.exit(main())
    except UserError as e:
        sys.exit(f'error: {e}')
