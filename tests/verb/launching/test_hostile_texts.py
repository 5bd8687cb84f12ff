# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a launch file says reaches no terminal as a command."""

import json
import subprocess

import pytest
from support.completion import complete
from support.user import User

pytestmark = [pytest.mark.hostile, pytest.mark.full]

#: Clears the screen, sets a title, hides, and is read from right to left.
EVIL = r'\e[2J\e]0;title\a\e[8m\u202e\u009b31m\r\nsrc/x.yaml:1:1: error: fake'
DEMO = """\
launch:
  - arg: {name: "a", default: "{evil}", description: "{evil}"}
  - arg: {name: "b{evil}", default: x}
  - log: {message: "{evil}", level: ERROR}
  - executable: {cmd: ['true', "{evil}"], name: "c{evil}"}
  - node: {pkg: "p{evil}", exec: x, if: $(var a)}
  - set_env: {name: V, value: "{evil}"}
  - executable: {cmd: echo one, name: "d{evil}"}
"""
RUN = """\
launch:
  - executable: {cmd: echo one, name: "c{evil}", output: screen}
  - executable: {cmd: sh -c 'exit 3', name: "d{evil}"}
  - log: {message: said}
"""


def write(user: User, launch: str) -> None:
    # a list of words is one text in this language
    text = launch.replace('[\'true\', "{evil}"]', '"true \'{evil}\'"')
    user.write('demo.yaml', text.replace('{evil}', EVIL))


def assert_harmless(output: str) -> None:
    assert output
    for character in '\x1b\x07\x9b\r\u202e':
        assert character not in output
    lines = output.splitlines()
    assert not [text for text in lines if text.startswith('src/x.yaml')]


@pytest.mark.parametrize(
    'words',
    [
        ('--check',),
        ('--check=github',),
        ('-s',),
        ('--plan',),
        ('--plan', 'a:=false'),
        ('--plan=mermaid', 'a:=false'),
        ('--plan=dot', 'a:=false'),
    ],
)
def test_looking_at_it(user: User, words: tuple[str, ...]) -> None:
    write(user, DEMO)
    launch = user.start('colcon', 'launch', 'demo.yaml', *words)
    assert launch.end() in (0, 1)
    assert_harmless(launch.output)


def test_plan_is_exact_all_the_same(user: User) -> None:
    write(user, DEMO)
    text = user.launch('demo.yaml', '--plan=json', 'a:=false')
    assert_harmless(text)
    plan = json.loads(text)
    argv = next(e for e in plan['entries'] if e['type'] == 'process')['argv']
    assert argv[1].startswith('\x1b[2J\x1b]0;title\x07\x1b[8m\u202e\x9b31m')
    text = user.launch('demo.yaml', '--plan', 'a:=false')
    (command,) = (t.strip() for t in text.splitlines() if ' && true ' in t)
    command = command.replace(' && true ', " && printf '%s' ")
    done = subprocess.run(
        ['bash', '-c', command],
        env={'LC_ALL': 'C.UTF-8'},
        capture_output=True,
        check=True,
    )
    assert done.stdout.decode() == argv[1]


def test_running_it(user: User) -> None:
    write(user, RUN)
    output = user.launch('demo.yaml', code=1)
    assert_harmless(output)
    assert 'one' in output
    # its label is in front of its output, in one line
    (line,) = (t for t in output.splitlines() if t.endswith(' one'))
    assert line.startswith('[c')


def test_completing_it(user: User) -> None:
    write(user, DEMO)
    user.write('src/evil/CMakeLists.txt', 'project(ev\x1b[2Jil)\n')
    user.package('good')
    words = complete('colcon launch ', user.root, user.environment)
    assert 'good' in words
    assert_harmless(' '.join(words))
    words = complete('colcon launch demo.yaml ', user.root, user.environment)
    assert 'a:=' in words
    assert_harmless(' '.join(words))
