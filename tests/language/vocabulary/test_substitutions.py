# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What each substitution comes to."""

from pathlib import Path
import time

from colcon_yamllaunch.language.vocabulary.parameter import parse_boolean
from colcon_yamllaunch.language.vocabulary.substitutions import KINDS
import pytest

VALUES = {
    # var
    '$(var a)': 'A',
    '$(var a default)': 'A',
    "$(var b '')": '',
    '$(var b $(var a))': 'A',
    '$(var $(var name))': 'A',
    'x$(var a)y$(var a)': 'xAyA',
    # env
    '$(env SET)': 'value',
    '$(env SET default)': 'value',
    '$(env UNSET default)': 'default',
    # eval
    "$(eval '1 + 1')": '2',
    "$(eval '4 / 2')": '2.0',
    "$(eval 'None')": 'None',
    "$(eval '1 == 2')": 'False',
    "$(eval 'sqrt(16) + math.pi * 0')": '4.0',
    '$(eval \'os.path.join(\\"a\\", \\"b\\")\' os)': 'a/b',
    "$(eval 'sys.byteorder in json.dumps(sys.byteorder)' 'sys, json')": 'True',
    "$(eval '[x * 2 for x in (1, 2)]')": '[2, 4]',
    "$(eval '[pi > 3 for _ in (1,)]')": '[True]',
    "$(eval '\\'$(var a)\\' == \\'A\\'')": 'True',
    # command
    "$(command 'echo a b')": 'a b\n',
    '$(command \'printf %s \\"a  b\\"\')': 'a  b',
    '$(command \'sh -c \\"echo e >&2; echo o\\"\' ignore)': 'o\n',
    '$(command \'sh -c \\"echo e >&2; echo o\\"\' capture)': 'e\no\n',
    "$(command 'printenv SET')": 'value\n',
    # packages and files
    '$(find-exec sh)': '/usr/bin/sh',
    '$(find-pkg-prefix alpha)': '/install/alpha',
    '$(find-pkg-share alpha)': '/install/alpha/share/alpha',
    '$(exec-in-pkg talker alpha)': '/install/alpha/lib/alpha/talker',
    '$(dirname)': '{folder}',
    '$(filename)': '{folder}/main.yaml',
    '$(log_dir)': '/logs',
    '$(launch_log_dir)': '/logs',
    '$(file-content content.txt)': 'content\n',
    '$(file-content $(dirname)/content.txt)': 'content\n',
    # logic
    '$(not true)': 'false',
    '$(not off)': 'true',
    '$(not 0)': 'true',
    '$(and true 1)': 'true',
    '$(and True no)': 'false',
    '$(or false 0)': 'false',
    '$(or false yes)': 'true',
    '$(any false false true)': 'true',
    '$(any)': 'false',
    '$(all true true false)': 'false',
    '$(all)': 'true',
    '$(equals a a)': 'true',
    '$(equals a A)': 'false',
    '$(equals 1 true)': 'true',
    '$(equals TRUE true)': 'true',
    '$(equals 0 1)': 'false',
    '$(equals 1.0 1)': 'true',
    '$(equals 1e3 1000)': 'true',
    "$(equals '' '')": 'true',
    '$(not-equals a b)': 'true',
    '$(not-equals 2 2.0)': 'false',
    '$(if true a b)': 'a',
    '$(if no a b)': 'b',
    '$(if false a)': '',
    # only the side that is chosen is evaluated
    '$(if true a $(env UNSET))': 'a',
    '$(if false $(var nope) b)': 'b',
    # parameters
    '$(param p)': '1',
    '$(param flag)': 'True',
    '$(param nope default)': 'default',
    # texts
    '$(string-join , a b c)': 'a,b,c',
    "$(string-join '' a b)": 'ab',
    '$(string-join - a)': 'a',
    '$(path-join a b c.yaml)': 'a/b/c.yaml',
    '$(path-join a /b)': '/b',
    "$(path-join '')": '.',
    "$(string-strip '  a b ')": 'a b',
    # results are not read again
    '$(var text)': '$(var a) \\n',
}
BEFORE = """\
- let: {name: a, value: A}
- let: {name: name, value: a}
- let: {name: text, value: '\\$(var a) \\\\n'}
- set_parameter: {name: p, value: 1}
- set_parameter: {name: p, value: 2}
- set_parameter: {name: flag, value: true}
"""


@pytest.mark.parametrize('text', VALUES)
def test_value(launcher, text):
    if text == '$(find-exec sh)':
        launcher.environment['PATH'] = '/usr/bin'
    launcher.write('content.txt', 'content\n')
    expected = VALUES[text].replace('{folder}', str(launcher.folder))
    assert launcher.value(block(text), BEFORE) == expected


def block(text):
    """Write a text so that YAML takes all of it as it is."""
    return f'|-\n      {text}'


def test_each_substitution_has_a_test():
    # anon is random, and for-var and index need a loop around them
    tested = {'anon', 'for-var', 'index'}
    tested |= {name for name in KINDS if any(f'({name}' in t for t in VALUES)}
    assert tested == set(KINDS)


@pytest.mark.parametrize(
    ('text', 'message', 'hint'),
    [
        ('«$(var b)»', "'b' does not exist", "'arg'"),
        ('«$(var nmae)»', "'nmae' does not exist", "did you mean 'name'?"),
        ('a «$(env NO)»', "'NO' does not exist", '$(env NO default)'),
        ('«$(env SETT)»', "'SETT' does not exist", "did you mean 'SET'?"),
        ('$(not «$(var b)»)', "'b' does not exist", ''),
        ('$(var «$(env UNSET)» c)', "'UNSET' does not exist", ''),
        ("«$(eval '1 +')»", 'SyntaxError', ''),
        ("«$(eval '1 / 0')»", 'ZeroDivisionError: division by zero', ''),
        ("«$(eval 'exit(3)')»", 'SystemExit: 3', ''),
        ("«$(eval '1' no.such.module)»", 'ModuleNotFoundError', ''),
        ("«$(eval 'sqrt(4)' os)»", 'NameError', ''),
        ("«$(eval '(')»", 'SyntaxError', ''),
        ('«$(command no-such-program)»', 'cannot be run', ''),
        ('«$(command false)»', 'failed with exit code 1', ''),
        (
            '«$(command \'sh -c \\"echo why >&2; exit 3\\"\' ignore)»',
            'failed with exit code 3: why',
            '',
        ),
        (
            '«$(command \'sh -c \\"echo why >&2\\"\')»',
            'wrote to stderr: why',
            "'ignore'",
        ),
        ('«$(command true what)»', "'what' is no way", 'ignore'),
        ("«$(command '')»", 'the command is empty', ''),
        ("«$(command 'a \\\"')»", 'open quote', ''),
        ('«$(find-exec no-such-program)»', 'on the PATH', ''),
        ('«$(find-pkg-share alhpa)»', "'alhpa'", "did you mean 'alpha'?"),
        ('«$(find-pkg-prefix zzz)»', "no package 'zzz'", ''),
        ('«$(exec-in-pkg walker alpha)»', 'alpha has listener, talker', ''),
        ('«$(exec-in-pkg a zzz)»', "no package 'zzz'", ''),
        ('«$(file-content nowhere)»', 'No such file', ''),
        ('«$(file-content .)»', 'Is a directory', ''),
        ('«$(file-content latin)»', 'not UTF-8', ''),
        ('«$(not maybe)»', "'maybe' is neither true nor false", ''),
        ('«$(and true 2)»', "'2' is neither", ''),
        # both sides are always evaluated
        ("«$(or true '')»", "'' is neither", ''),
        ('«$(if a b)»', "'a' is neither", ''),
        ('«$(param nope)»', "'nope'", '$(param nope default)'),
        ('«$(for-var x)»', "'x'", ''),
        ('«$(index x)»', "'x'", ''),
    ],
)
def test_error(launcher, text, message, hint):
    launcher.write('latin', b'\xe9')
    error = launcher.error(
        f'launch:\n{BEFORE}- executable:\n    cmd: [echo]\n    name: '
        + block(text)
    )
    assert message in error.message
    assert hint in (error.hint or '')


@pytest.mark.parametrize('shell', ['sh', 'setsid -w sh'])
def test_process_left_by_a_command_is_killed(launcher, tmp_path, shell):
    # it has the pipes open, and would be waited for
    script = launcher.write(
        'leave', f'sleep 600 & echo $! > {tmp_path}/pid; echo o\n'
    )
    text = (
        'launch:\n'
        f'- let: {{name: x, value: "$(command \'{shell} {script}\')"}}\n'
    )
    launcher.good(text)
    pid = int((tmp_path / 'pid').read_text())
    deadline = time.monotonic() + 60
    while _runs(pid):
        assert time.monotonic() < deadline
        time.sleep(0.01)


def _runs(pid):
    try:
        return ') Z ' not in Path(f'/proc/{pid}/stat').read_text()
    except (FileNotFoundError, ProcessLookupError):
        return False


def test_stderr_of_a_command_may_be_a_warning(launcher):
    text = block('«$(command \'sh -c \\"echo e >&2; echo o\\"\' warn)')
    warning = launcher.warning(f'launch:\n- log:\n    message: {text}\n')
    assert 'said: e' in warning.message


def test_anonymous_name(launcher):
    text = (
        'launch:\n- let: {name: a, value: $(anon my-node)}\n'
        '- group:\n'
        '  - executable: {cmd: [echo, $(var a), $(anon my-node)]}\n'
        '  - executable: {cmd: [echo, $(anon other), $(anon other)]}\n'
        '- executable: {cmd: [echo, $(anon other), $(var a)]}\n'
    )
    first, second, third = launcher.processes(text)
    # the same within a scope, and fit for a node's name
    assert first.argv[1] == first.argv[2]
    assert first.argv[1].startswith('my_node_')
    assert first.argv[1].isidentifier()
    assert second.argv[1] == second.argv[2] != first.argv[1]
    assert third.argv[1] != second.argv[1]


def test_what_a_launch_configuration_lacked_is_said_once(launcher):
    text = (
        'launch:\n- let: {name: a, value: «$(env UNSET)}\n'
        '- log: {message: $(var a)}\n- let: {name: b, value: $(var a)}\n'
        '- log: {message: $(var b x)}\n'
    )
    assert 'UNSET' in launcher.error(text).message


@pytest.mark.parametrize(
    ('text', 'expected'),
    [
        ('true', True),
        (' True\n', True),
        ('on', True),
        ('1', True),
        ('FALSE', False),
        ('n', None),
        ('no', False),
        ('0', False),
        ('', None),
        ('2', None),
        ('tRUE', None),
    ],
)
def test_parse_boolean(text, expected):
    assert parse_boolean(text) is expected


def test_names_used_are_noted(launcher):
    evaluation = launcher.good(
        'launch:\n- log: {message: $(find-pkg-share my_pkg)}\n'
        '- node: {pkg: alpha, exec: talker}\n'
        '- node: {pkg: alpha, exec: talker}\n'
    )
    lines = {name: p.line for name, p in evaluation.packages.items()}
    assert lines == {'my_pkg': 2, 'alpha': 3}
    assert {use.name for use in evaluation.executables} == {'talker'}
