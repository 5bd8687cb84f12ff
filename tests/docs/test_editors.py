# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The configuration in docs/editors.md fits what the commands do."""

import json
from pathlib import Path
import re
import shlex

from colcon_yamllaunch.verb.options import read_debug
from support.user import User

PAGE = Path(__file__).parents[2].joinpath('docs/editors.md').read_text()
TASKS, LAUNCH = map(json.loads, re.findall(r'```json\n(.*?)```', PAGE, re.S))
# what VS Code's matcher `$gcc` looks for in a line
GCC = r'^(.*):(\d+):(\d+):\s+(?:fatal\s+)?(warning|error):\s+(.*)$'


def test_each_debugger_attaches_where_its_task_lets_one_wait() -> None:
    waiting = {}
    for task in TASKS['tasks'][1:]:
        *command, target = shlex.split(task['command'])
        assert command == ['colcon', 'launch', '--debug']
        waiting[task['label']] = read_debug('--debug', target)
    for entry in LAUNCH['configurations']:
        address = entry.get('miDebuggerServerAddress')
        if address is None:
            connect = entry['connect']
            address = f'{connect["host"]}:{connect["port"]}'
        name, port = waiting.pop(entry['preLaunchTask'])
        assert (entry['name'], address) == (name, f'127.0.0.1:{port}')
    assert not waiting


def test_mistakes_are_marked(user: User) -> None:
    check, *_ = TASKS['tasks']
    assert check['problemMatcher']['base'] == '$gcc'
    user.write('src/one/package.xml', PACKAGE)
    user.write('src/one/launch/a.launch.yaml', 'launch:\n- nod: {}\n')
    output = user.launch(*shlex.split(check['command'])[2:], code=1)
    path, line, column, *_ = re.findall(GCC, output, re.M)[0]
    assert (path, line, column) == ('src/one/launch/a.launch.yaml', '2', '3')


PACKAGE = """\
<package format="3">
  <name>one</name><version>0.0.0</version><description>one</description>
  <maintainer email="a@b.cd">a</maintainer><license>a</license>
</package>
"""
