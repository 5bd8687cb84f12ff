# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The files besides launch files that a plan depends on."""

import pytest
from support.language_fixtures import Launcher

NODE = '- node: {{pkg: alpha, exec: talker, param: [{{from: p.yaml{}}}]}}'
COMPONENT = """
- node_container:
    {pkg: alpha, exec: talker, name: box, namespace: '', composable_node: [
      {pkg: alpha, plugin: 'a::B', param: [{from: p.yaml}]}]}
"""


@pytest.mark.parametrize(
    ('text', 'is_present', 'expected'),
    [
        # the node reads it, and it is in the plan
        (NODE.format(''), True, False),
        # it is left out
        (NODE.format(''), False, True),
        (NODE.format(', allow_substs: true'), True, True),
        (COMPONENT, True, True),
        (
            "- log: {level: info, message: $(file-content 'p.yaml')}",
            True,
            True,
        ),
        (
            "- log: {level: info, message: $(file-content 'p.yaml')}",
            False,
            True,
        ),
        ('- include: {file: p.yaml}', False, True),
        ('- log: {level: info, message: p.yaml}', True, False),
    ],
)
def test_what_is_read_or_looked_for_in_vain(
    launcher: Launcher, text: str, is_present: bool, expected: bool
) -> None:
    path = launcher.folder / 'p.yaml'
    if is_present:
        launcher.write('p.yaml', '/**: {ros__parameters: {a: 1}}')
    evaluation = launcher.evaluate(f'launch:\n{text}\n')
    assert (str(path) in evaluation.inputs) == expected
    assert not evaluation.has_run_programs


def test_programs_that_are_run_may_read_more(launcher: Launcher) -> None:
    text = "launch:\n- let: {name: x, value: $(command 'echo x')}\n"
    assert launcher.evaluate(text).has_run_programs


def test_launch_files_in_python_may_read_more(launcher: Launcher) -> None:
    path = launcher.write('x.launch.py', '')
    text = 'launch:\n- include: {file: x.launch.py}\n'
    evaluation = launcher.evaluate(text)
    assert str(path) in evaluation.inputs
    assert evaluation.has_run_programs
