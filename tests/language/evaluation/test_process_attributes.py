# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a launch file may say of any process."""

from colcon_yamllaunch.plan.plan import OUTPUT_MODES, ParameterFile
import pytest
from support.language_fixtures import Marked


def process(launcher, *attributes, before='', **arguments):
    lines = ''.join(f'    {line}\n' for line in attributes)
    text = f'launch:\n{before}- executable:\n    cmd: echo a\n{lines}'
    return launcher.process(text, **arguments)


def test_defaults(launcher):
    found = process(launcher)
    assert found.argv == ('echo', 'a')
    assert found.cwd == str(launcher.folder)
    assert found.environment == ()
    assert found.output == 'both'
    assert not found.emulate_tty
    assert not found.respawn
    assert found.respawn_delay == 0
    assert found.respawn_max_retries == -1
    assert found.sigterm_timeout == found.sigkill_timeout == 5
    assert not found.on_exit_shutdown


@pytest.mark.parametrize(
    ('attribute', 'field', 'expected'),
    [
        ('respawn: true', 'respawn', True),
        ('respawn: "on"', 'respawn', True),
        ('respawn: "0"', 'respawn', False),
        ('respawn: $(var v)', 'respawn', True),
        ('respawn_delay: 2', 'respawn_delay', 2.0),
        ('respawn_delay: 0.5', 'respawn_delay', 0.5),
        ('respawn_delay: "1e-1"', 'respawn_delay', 0.1),
        ('respawn_max_retries: 3', 'respawn_max_retries', 3),
        ('respawn_max_retries: $(var v)', 'respawn_max_retries', 1),
        ('sigterm_timeout: 0', 'sigterm_timeout', 0.0),
        ('sigkill_timeout: $(var v)', 'sigkill_timeout', 1.0),
        ('emulate_tty: yes', 'emulate_tty', True),
        ('emulate_tty: "false"', 'emulate_tty', False),
        ('on_exit: shutdown', 'on_exit_shutdown', True),
        *((f'output: {mode}', 'output', mode) for mode in OUTPUT_MODES),
        ('output: $(var o)', 'output', 'screen'),
        ('cwd: /', 'cwd', '/'),
        ('cwd: sub/..', 'cwd', '{folder}'),
        ('cwd: $(dirname)/sub', 'cwd', '{folder}/sub'),
    ],
)
def test_attribute(launcher, attribute, field, expected):
    before = '- let: {name: v, value: 1}\n- let: {name: o, value: screen}\n'
    found = getattr(process(launcher, attribute, before=before), field)
    if isinstance(expected, str):
        expected = expected.format(folder=launcher.folder)
    assert found == expected
    assert type(found) is type(expected)


@pytest.mark.parametrize(
    ('attribute', 'message'),
    [
        ('respawn: «maybe»', "'respawn' wants a boolean, not 'maybe'"),
        ('respawn_delay: «-1»', "'respawn_delay' wants a number of seconds"),
        ('respawn_delay: «soon»', "'respawn_delay' wants a number of seconds"),
        ('respawn_delay: «.inf»', "'respawn_delay' wants a number of seconds"),
        ('respawn_max_retries: «1.5»', 'wants a whole number'),
        ('sigterm_timeout: «nan»', "'sigterm_timeout' wants a number"),
        ('sigkill_timeout: «$(env SET)»', "'sigkill_timeout' wants a number"),
        ('shell: «2»', "'shell' wants a boolean"),
        ('output: «scren»', "'output' cannot be 'scren'"),
        ('launch-prefix: «"a \'b"', 'open quote'),
    ],
)
def test_wrong_attribute(launcher, attribute, message):
    text = f'launch:\n- executable:\n    cmd: echo\n    {attribute}\n'
    assert message in launcher.error(text).message


@pytest.mark.parametrize('cmd', ["''", '[]', "'  '"])
def test_empty_command(launcher, cmd):
    (error,) = launcher.errors(f'launch:\n- executable: {{cmd: {cmd}}}\n')
    assert "'cmd' is empty" in error.message


@pytest.mark.parametrize(
    'cmd',
    [
        '«no-such-program» a $(env SET)',
        '"«no-such-program» a"',
        '\'«"no such"» a\'',
        '«no$(env SET)/x» --a b',
        '>-\n    «./$(env SET)/x» --a\n    --b\n ',
        '[«no-such-program», a]',
        '«./no-such-program»',
        '«/bin»',
        '«data.txt»',
    ],
)
def test_missing_command_does_not_stop_the_evaluation(launcher, cmd):
    launcher.write('data.txt', '')
    # what starts it warns of it, as it knows on which machine it runs
    mark = Marked.of(f'launch:\n- executable:\n   cmd: {cmd}\n')
    (use,) = launcher.good(mark.text).programs.values()
    mark.check(use.place)


def test_missing_program_of_a_package_by_its_path(launcher, monkeypatch):
    monkeypatch.setattr(launcher.packages, 'may_appear', lambda _path: False)
    path = '«$(find-pkg-prefix alpha)/lib/alpha/nope»'
    error = launcher.error(f'launch:\n- executable: {{cmd: {path}}}\n')
    assert 'there is no executable' in error.message
    assert error.may_pass_after_build


def test_evaluation_notes_where_the_program_is_named(launcher):
    evaluation = launcher.good(
        'launch:\n- executable: {cmd: xterm}\n'
        '- executable: {cmd: sh, launch-prefix: gdb}\n'
        '- node: {exec: talker}\n'
    )
    uses = list(evaluation.programs.values())
    assert list(evaluation.programs) == ['xterm-1', 'sh-2', 'talker-3']
    places = [(u.place.position.line, u.place.position.column) for u in uses]
    assert places == [(2, 21), (3, 40), (4, 16)]
    assert [use.hint for use in uses] == [
        None,
        None,
        "name its package with 'pkg'",
    ]


def test_program_on_the_path_of_its_own_environment(launcher):
    launcher.write('bin/tool', '#!/bin/sh\n').chmod(0o755)
    text = (
        'launch:\n- executable:\n    cmd: tool\n'
        f'    env: [{{name: PATH, value: {launcher.folder}/bin}}]\n'
        '- executable: {cmd: ./tool, cwd: bin}\n'
    )
    assert len(launcher.processes(text)) == 2


def test_environment_is_what_differs_from_the_launch(launcher):
    text = (
        'launch:\n- unset_env: {name: SET}\n- set_env: {name: A, value: 1}\n'
        '- executable:\n    cmd: echo\n    env:\n'
        '    - {name: B, value: $(env A)}\n    - {name: A, value: 2}\n'
        '- executable: {cmd: echo}\n'
    )
    first, second = launcher.processes(text)
    assert first.environment == (('A', '2'), ('B', '1'), ('SET', None))
    assert second.environment == (('A', '1'), ('SET', None))


@pytest.mark.parametrize('name', ["''", 'A=B', '"A\\0"'])
@pytest.mark.parametrize(
    'text',
    [
        '- set_env: {{name: {}, value: x}}\n',
        '- append_env: {{name: {}, value: x}}\n',
        '- executable: {{cmd: echo, env: [{{name: {}, value: x}}]}}\n',
    ],
)
def test_no_process_can_have_such_a_variable(launcher, text, name):
    (error,) = launcher.errors('launch:\n' + text.format(name))
    assert 'there can be no environment variable' in error.message


@pytest.mark.parametrize(
    ('own', 'arguments', 'expected'),
    [
        ('', {'launch__prefix': 'env -i'}, ['env', '-i', 'echo', 'a']),
        ('', {'launch__prefix': ''}, ['echo', 'a']),
        (
            'launch-prefix: nice -n 1',
            {'launch__prefix': 'env'},
            ['nice', '-n', '1', 'echo', 'a'],
        ),
        ("launch-prefix: ''", {'launch__prefix': 'env'}, ['echo', 'a']),
        (
            '',
            {'launch__prefix': 'env', 'launch__prefix__filter': 'ec'},
            ['env', 'echo', 'a'],
        ),
        (
            '',
            {'launch__prefix': 'env', 'launch__prefix__filter': 'cho'},
            ['echo', 'a'],
        ),
        (
            'launch-prefix: env',
            {'launch__prefix': '', 'launch__prefix__filter': 'zzz'},
            ['env', 'echo', 'a'],
        ),
    ],
)
def test_launch_prefix(launcher, own, arguments, expected):
    assert list(process(launcher, own, **arguments).argv) == expected


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        (
            {'launch__prefix': 'env', 'launch__prefix__filter': '('},
            'no regular expression',
        ),
        ({'launch__prefix': "'"}, 'open quote'),
        ({'emulate_tty': 'maybe'}, "'emulate_tty' is 'maybe'"),
        ({'sigterm_timeout': 'soon'}, "'sigterm_timeout' is 'soon'"),
        ({'sigkill_timeout': '-1'}, "'sigkill_timeout' is '-1'"),
        ({'sigkill_timeout': 'inf'}, "'sigkill_timeout' is 'inf'"),
    ],
)
def test_wrong_argument_for_every_process(launcher, arguments, message):
    (error,) = launcher.errors(
        'launch:\n- executable: {cmd: echo}\n', **arguments
    )
    assert message in error.message


def test_arguments_for_every_process(launcher):
    found = process(
        launcher,
        'emulate_tty: false',
        'sigkill_timeout: 3',
        emulate_tty='true',
        sigterm_timeout='1.5',
        sigkill_timeout='9',
    )
    assert found.emulate_tty
    assert found.sigterm_timeout == 1.5
    assert found.sigkill_timeout == 3


def test_output_is_overridden_by_the_environment(launcher):
    launcher.environment['OVERRIDE_LAUNCH_PROCESS_OUTPUT'] = 'own_log'
    assert process(launcher, 'output: screen').output == 'own_log'
    launcher.environment['OVERRIDE_LAUNCH_PROCESS_OUTPUT'] = 'nowhere'
    (error,) = launcher.errors('launch:\n- executable: {cmd: echo}\n')
    assert 'own_log' in error.hint


def test_shell(launcher):
    text = (
        'launch:\n- executable:\n    cmd: [echo, $HOME, a b]\n'
        '    shell: true\n'
    )
    # ROS 2 does not quote the arguments, so that the shell expands them
    assert launcher.process(text).argv == (
        '/bin/sh',
        '-c',
        'echo $HOME a b',
    )


def test_shell_with_parameter_files(launcher):
    text = (
        'launch:\n- node:\n    exec: any program\n    shell: true\n'
        '    param: [{name: a, value: 1}]\n'
    )
    *words, file = launcher.process(text).argv
    assert words == [
        '/bin/sh',
        '-c',
        'any program --ros-args --params-file "${1}"',
        'sh',
    ]
    assert isinstance(file, ParameterFile)
