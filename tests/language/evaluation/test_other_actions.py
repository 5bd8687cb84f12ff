# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Environment variables, messages, shutdowns, timers and loops."""

from colcon_yamllaunch.plan.plan import Message, Shutdown, Timer
import pytest


@pytest.mark.parametrize(
    ('actions', 'name', 'expected'),
    [
        (['set_env: {name: A, value: 1}'], 'A', '1'),
        (['set_env: {name: SET, value: $(env SET)2}'], 'SET', 'value2'),
        (['unset_env: {name: SET}'], 'SET', 'none'),
        (['unset_env: {name: NOPE}'], 'SET', 'value'),
        (['append_env: {name: A, value: b}'], 'A', 'b'),
        (['append_env: {name: SET, value: b}'], 'SET', 'value:b'),
        (
            ['append_env: {name: SET, value: b, prepend: true}'],
            'SET',
            'b:value',
        ),
        (
            ['append_env: {name: SET, value: b, prepend: "false"}'],
            'SET',
            'value:b',
        ),
        (
            ['append_env: {name: SET, value: b, separator: ", "}'],
            'SET',
            'value, b',
        ),
        (
            ['append_env: {name: SET, value: b, separator: ""}'],
            'SET',
            'valueb',
        ),
        (
            [
                'set_env: {name: A, value: 1}',
                'unset_env: {name: SET}',
                'reset_env: {}',
            ],
            'SET',
            'value',
        ),
        (['set_env: {name: A, value: 1}', 'reset_env: {}'], 'A', 'none'),
        (['set_ros_log_dir: {new_log_dir: /x}'], 'ROS_LOG_DIR', '/x'),
        (['set_ros_log_dir: {new_log_dir: x}'], 'ROS_LOG_DIR', '/logs/x'),
        (
            [
                'set_ros_log_dir: {new_log_dir: /x}',
                'set_ros_log_dir: {new_log_dir: y}',
            ],
            'ROS_LOG_DIR',
            '/x/y',
        ),
    ],
)
def test_environment(launcher, actions, name, expected):
    before = ''.join(f'- {action}\n' for action in actions)
    assert launcher.value(f'$(env {name} none)', before) == expected


def test_log_folder_must_be_absolute(launcher):
    launcher.environment['ROS_LOG_DIR'] = 'relative'
    (error,) = launcher.errors('- set_ros_log_dir: {new_log_dir: x}\n')
    assert "'relative/x' is not an absolute path" in error.message


@pytest.mark.parametrize(
    ('action', 'level'),
    [
        ('log: {message: m}', 'INFO'),
        ('log: {message: m, level: debug}', 'DEBUG'),
        ('log: {message: m, level: WARN}', 'WARNING'),
        ('log: {message: m, level: Fatal}', 'CRITICAL'),
        ('log: {message: m, level: $(var l)}', 'ERROR'),
        ('log_info: {message: m}', 'INFO'),
        ('log_warning: {message: m}', 'WARNING'),
        ('log_error: {message: m}', 'ERROR'),
        ('log_debug: {message: m}', 'DEBUG'),
    ],
)
def test_log(launcher, action, level):
    text = f'launch:\n- let: {{name: l, value: error}}\n- {action}\n'
    assert launcher.good(text).plan.entries == (Message(level, 'm'),)


def test_wrong_level(launcher):
    error = launcher.error('launch:\n- log: {message: m, level: «eror}\n')
    assert error.hint == "did you mean 'ERROR'?"


def test_order_of_entries(launcher):
    text = (
        'launch:\n- log: {message: 5}\n'
        '- timer:\n    period: 2\n    children:\n'
        '    - log: {message: late}\n'
        '    - timer: {period: $(var p), cancel_on_shutdown: no,'
        ' children: [shutdown: {}]}\n'
        '- shutdown: {reason: $(env SET)}\n- log: {message: after}\n'
    )
    entries = launcher.good(text, p='.5').plan.entries
    inner = Timer(0.5, (Shutdown(''),), cancel_on_shutdown=False)
    assert entries == (
        Message('INFO', '5'),
        Timer(2.0, (Message('INFO', 'late'), inner)),
        Shutdown('value'),
        Message('INFO', 'after'),
    )


@pytest.mark.parametrize('period', ['«-1»', '«soon»', "«''»", '«.nan»'])
def test_wrong_period(launcher, period):
    error = launcher.error(
        f'launch:\n- timer:\n    period: {period}\n    children: []\n'
    )
    assert "'period' wants a number of seconds" in error.message


def said(launcher, text, **arguments):
    entries = launcher.good(text, **arguments).plan.entries
    return [entry.text for entry in entries]


LOOP = """\
launch:
- let: {name: n, value: 2}
- for_each:
    values: %s
    children:
    - log: {message: $(for-var a none)-$(for-var b none)}
- log: {message: end $(for-var a none)}
"""


@pytest.mark.parametrize(
    ('values', 'expected'),
    [
        ("'{a: 1, b: x};{a: 2}'", ['1-x', '2-none']),
        ("'{a: $(var n)}'", ['2-none']),
        ("'{}'", ['none-none']),
        ('\'{a: true};  {a: "x y"}  \'', ['True-none', 'x y-none']),
    ],
)
def test_for_each(launcher, values, expected):
    assert said(launcher, LOOP % values) == [*expected, 'end none']


def test_for_each_without_values(launcher):
    assert (
        "'for_each' has no values" in launcher.warning(LOOP % "«''»").message
    )


@pytest.mark.parametrize(
    'values', ["«'a'»", "«'{a: 1};'»", "«'[1]'»", "«'{a: 1'»", "«'*a'»"]
)
def test_wrong_values(launcher, values):
    assert 'no YAML mapping' in launcher.error(LOOP % values).message


def test_for(launcher):
    text = (
        'launch:\n- for:\n    len: 2\n    name: i\n    children:\n'
        '    - for:\n        len: $(index i)\n        name: j\n'
        '        children: [log: {message: $(index i) $(index j)}]\n'
        '    - let: {name: last, value: $(index i)}\n'
        '- log: {message: $(var last)}\n'
    )
    assert said(launcher, text) == ['1 0', '1']


@pytest.mark.parametrize(('length', 'count'), [('0', 0), ('-1', 0), ('3', 3)])
def test_length_of_for(launcher, length, count):
    text = f'launch:\n- for: {{len: {length}, name: i, children: [log: M]}}\n'
    text = text.replace('log: M', 'log: {message: m}')
    assert len(said(launcher, text)) == count


def test_wrong_length_of_for(launcher):
    error = launcher.error(
        'launch:\n- for: {len: «many», name: i, children: []}\n'
    )
    assert "'len' wants a whole number, not 'many'" in error.message


def test_all_errors_of_an_evaluation_are_shown(launcher):
    errors = launcher.errors(
        'launch:\n- log: {message: $(var a)}\n'
        '- group: [log: {message: $(env NO)}, node: {pkg: nope, exec: nope}]\n'
        '- timer: {period: x, children: [log: {message: $(var b)}]}\n'
        '- log: {message: $(not x)}\n'
    )
    assert [e.position.line for e in errors] == [2, 3, 3, 4, 5]
