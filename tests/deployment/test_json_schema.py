# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The JSON Schema of deployment files accepts what the reader accepts."""

from pathlib import Path
import re

from colcon_yamllaunch.deployment.deployment_file import deployment_of
from colcon_yamllaunch.deployment.json_schema import json_schema, schema_text
from colcon_yamllaunch.deployment.machine_settings import MACHINE_SETTINGS
from colcon_yamllaunch.deployment.process_settings import (
    CONDITIONS,
    RESTART_KEYS,
    SETTINGS,
)
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.source_text import Source
from jsonschema import Draft7Validator
import pytest
import yaml

ROOT = Path(__file__).parents[2]
VALIDATOR = Draft7Validator(json_schema())
#: Values of each setting of a process: right ones, and wrong ones.
PROCESS = {
    'ready': (
        [
            *('running', '[running]', '{topic: scan}', '{port: 7447}'),
            *('{topic: scan, message: true}', '{service: s}', '{node: /n}'),
            *('{action: a}', '{lifecycle: active}', '{log: up}', '{file: x}'),
            *('{parameter: {name: a, equals: 1}}', '{command: "test -e x"}'),
            *('{transform: [map, base]}', '{port: "h:80"}', '{after: 0.5}'),
            '[{topic: scan}, {log: up}]',
        ],
        [
            *('[]', '{}', 'soon', '{topik: scan}', '{topic: }', '{port: 0}'),
            *('{topic: a, log: b}', '{log: a, message: true}', '{after: -1}'),
            *('{transform: [map]}', '{parameter: {name: a}}', '{port: x}'),
            *('{lifecycle: finalized}', '{parameter: x}', '{topic: [a]}'),
        ],
    ),
    'after': (['a', '[a, "b*"]', '[]'], ['[[]]', '{}', '']),
    'ready_timeout': (['30', '0.5'], ['-1', 'soon', '[]']),
    'on_timeout': (['warn', 'fail', 'start'], ['stop', '1']),
    'restart': (
        [
            *('never', 'always', 'failure', '{}', '{when: always, max: 3}'),
            *('{delay: 1}', '{delay: [0.5, 30]}', '{then: leave, window: 9}'),
            *('{with: a}', '{with: [a, b]}', '{command: [usbreset, x]}'),
            '{command: usbreset x}',
        ],
        [
            *('sometimes', '{when: x}', '{max: -1}', '{max: 0.5}', '[]'),
            *('{delay: [1]}', '{with: []}', '{then: go}', '{often: 1}'),
        ],
    ),
    'critical': (['true', 'false'], ['1', 'maybe']),
    'optional': (['true', 'false'], ['1', '[]']),
    'memory': (['200M', '2G', '1.5gib', '1000'], ['0', '-1', 'much', '2X']),
    'memory_high': (['200M', '2 GiB'], ['[]', 'G']),
    'cpu': (['150%', '1.5', '2'], ['0', 'x', '150 percent']),
    'cpus': (['2', '2-3', '[0, 2]', '"0,2-3"'], ['[]', 'a', '-1', '2000']),
    'io': (['1', '10000'], ['0', '10001', 'x']),
    'tasks': (['1', '500'], ['0', '1.5']),
    'nice': (['-20', '19'], ['20', 'x', '1.5']),
    'scheduling': (
        ['{fifo: 50}', '{rr: 1}', '{deadline: [0.01, 0.02, 0.02]}'],
        ['{fifo: 100}', '{}', '{fifo: 1, rr: 1}', '{deadline: [1]}', 'fifo'],
    ),
    'oom': (['first', 'last', '-500'], ['never', '1001']),
    'env': (['{A: b, C: 1}', '{}'], ['{A-B: c}', '{A: [b]}', '{A: }']),
    'user': (['robot'], ['', '[]']),
    'directory': (['/data', '~/data', '"~"'], ['data', '~you']),
    'output': (['both', 'log'], ['screens']),
}
#: The same of a machine.
MACHINE = {
    'workspace': (['~/ws', '/ws'], ['[]']),
    'sync': (['build', 'none'], ['biuld']),
    'on_lost': (['keep'], ['go']),
    'lost_after': (['0.5'], ['0', 'soon']),
    'env': (['[A, B]', '{A: b, C: }', 'A'], ['{A-B: c}', '[{A: b}]']),
    'setup': (['~/setup.bash'], ['[]']),
    'python': (['/usr/bin/python3'], ['{}']),
}
FILES = (
    [
        'machines: {arm: robot@arm}',
        'machines: {arm: {slurm: }, b: {connect: [docker, exec]}}\n'
        'defaults: {sync: none}',
        'args: {sim: true, rate: 7}',
        'processes: []',
        'processes: [{match: {package: "nav2_*"}, nice: 1}]',
        'machines: {arm: {ssh: arm}}\n'
        'processes: [{match: "*", machine: arm}, {match: a, machine: here}]',
        'profiles: {sim: {args: {sim: true}}, real: {}}',
    ],
    [
        '{}',
        '[]',
        'machines: {here: {ssh: h}}',
        'machines: {a/b: {ssh: h}}',
        'machines: {a: {}}',
        'machines: {a: {ssh: h, slurm: []}}',
        'processes: [{match: a}]',
        'processes: [{nice: 1}]',
        'processes: [{match: {}, nice: 1}]',
        'processes: [{match: {pakage: a}, nice: 1}]',
        'proceses: []',
        'args: []',
        'profiles: {sim: {profiles: {}}}',
    ],
)


def reader_accepts(text: str) -> bool:
    try:
        deployment_of(Source('robot.yaml', 'robot.yaml', text, 'file'))
    except LaunchError:
        return False
    return True


def check(text: str, *, is_right: bool) -> None:
    assert reader_accepts(text) is is_right, text
    assert VALIDATOR.is_valid(yaml.safe_load(text)) is is_right, text


def test_it_is_a_schema() -> None:
    Draft7Validator.check_schema(json_schema())
    assert schema_text().endswith('}\n')


def test_each_key_has_examples() -> None:
    assert PROCESS.keys() == SETTINGS.keys()
    assert MACHINE.keys() == MACHINE_SETTINGS.keys()
    examples = ' '.join(PROCESS['ready'][0])
    assert all(f'{{{kind}: ' in examples for kind in CONDITIONS)


@pytest.mark.parametrize('key', PROCESS)
def test_setting_of_a_process(key: str) -> None:
    for is_right, examples in zip((True, False), PROCESS[key], strict=True):
        for example in examples:
            text = f'processes: [{{match: a, {key}: {example}}}]'
            check(text, is_right=is_right)


@pytest.mark.parametrize('key', MACHINE)
def test_setting_of_a_machine(key: str) -> None:
    for is_right, examples in zip((True, False), MACHINE[key], strict=True):
        for example in examples:
            text = f'machines: {{m: {{ssh: h, {key}: {example}}}}}'
            check(text, is_right=is_right)


def test_whole_files() -> None:
    for is_right, examples in zip((True, False), FILES, strict=True):
        for text in examples:
            check(text, is_right=is_right)


DOCUMENT = (ROOT / 'docs/deployment.md').read_text(encoding='utf-8')
WRITTEN = [
    (ROOT / 'sample_ws/robot.yaml').read_text(encoding='utf-8'),
    *re.findall(r'```yaml\n(.*?)```', DOCUMENT, re.DOTALL),
]


@pytest.mark.parametrize('number', range(len(WRITTEN)))
def test_file_in_the_documents(number: int) -> None:
    text = WRITTEN[number]
    content = yaml.safe_load(text)
    if content is None:
        assert text.startswith('# yaml-language-server: ')
    elif 'include' in content:
        assert VALIDATOR.is_valid(content)
    else:
        check(text, is_right=True)


@pytest.mark.parametrize('key', [*SETTINGS, *RESTART_KEYS])
def test_setting_has_a_row(key: str) -> None:
    rows = [line for line in DOCUMENT.splitlines() if line.startswith('| `')]
    assert any(f'`{key}`' in r or f'`{key}: ' in r for r in rows)
