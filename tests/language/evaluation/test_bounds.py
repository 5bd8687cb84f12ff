# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launch files that would take for ever, or all memory, end with an error."""

import json
import os
import resource
import signal

from colcon_yamllaunch.language.actions import commands, expressions
from colcon_yamllaunch.language.policies.check import check
import pytest
from support.time_limits import within

pytestmark = pytest.mark.hostile

#: What the launch files of this module may take: what is promised is a second
#: and 200 MB, of which Python itself takes a part.
SECONDS = 10
MEMORY = 200_000_000


@pytest.fixture(autouse=True)
def bounds():
    """Have a test fail that takes too long or too much."""

    def over(_number, _frame):
        pytest.fail('it takes too long')

    before = signal.signal(signal.SIGVTALRM, over)
    limits = resource.getrlimit(resource.RLIMIT_AS)
    with open('/proc/self/statm', 'rb') as file:
        used = int(file.read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, limits[1]))
    signal.setitimer(signal.ITIMER_VIRTUAL, SECONDS)
    yield
    signal.setitimer(signal.ITIMER_VIRTUAL, 0)
    resource.setrlimit(resource.RLIMIT_AS, limits)
    signal.signal(signal.SIGVTALRM, before)


def message(text):
    quoted = json.dumps(text, ensure_ascii=False)
    return f'launch:\n- log_info: {{message: {quoted}}}\n'


def nested(levels, inner):
    """Return a YAML mapping that has 10^levels values."""
    texts = [f'a: &a0 [{", ".join([inner] * 10)}]']
    for level in range(1, levels):
        aliases = ', '.join([f'*a{level - 1}'] * 10)
        texts.append(f'a{level}: &a{level} [{aliases}]')
    return f'{{{", ".join(texts)}}}'


@pytest.mark.parametrize(
    'expression',
    [
        'round(1, -999999999)',
        '9 ** 9 ** 9',
        '1 << 10 ** 10',
        "'a' * 10 ** 10",
        '[[0] * 10 ** 4] * 10 ** 5',
        'str(1).ljust(10 ** 10)',
        "'%1000000000d' % 1",
        "format(1, '1000000000')",
        "'{:1000000000}'.format(1)",
        'sum(range(10 ** 12))',
        '[x for x in range(10 ** 9)]',
        'max(range(10 ** 12))',
        'factorial(10 ** 7)',
        'math.comb(10 ** 7, 5 * 10 ** 6)',
        '(lambda f: f(f))(lambda f: f(f))',
        '10 ** 5000',
        'str(1) * 20000000',
    ],
)
def test_an_expression(launcher, expression, monkeypatch):
    monkeypatch.setattr(expressions, 'MAXIMUM_TIME', 0.05)
    expression = expression.replace("'", "\\'")
    (error,) = launcher.evaluate(message(f"$(eval '{expression}')")).errors
    assert 'expression' in error.message
    assert 'fails: ' in error.message


@pytest.mark.parametrize('digits', ['-999999999', '999999999'])
def test_rounding_for_ever_is_an_error_of_a_check(launcher, digits):
    request = launcher.request(message(f"$(eval 'round(1, {digits})')"))
    (error,) = check(request, portable=False).errors
    assert f'to round to {digits} digits would take for ever' in error.message
    result = check(
        launcher.request(message("$(eval 'round(12.34, -1)')")), portable=False
    )
    assert not result.diagnostics


@pytest.mark.parametrize(
    ('expression', 'expected'),
    [
        ('2 ** 10', '1024'),
        ("'ab' * 2", 'abab'),
        ("'%.2f' % 1", '1.00'),
        ('sum(x * x for x in range(4))', '14'),
        ("', '.join(sorted({'b', 'a'}))", 'a, b'),
        ("'ü\U0001f916' * 2", 'ü\U0001f916' * 2),
    ],
)
def test_what_is_computed_apart(launcher, expression, expected):
    expression = expression.replace("'", "\\'")
    result = launcher.evaluate(message(f"$(eval '{expression}')"))
    assert result.plan.entries[0].text == expected


def test_what_is_computed_apart_again_is_known(launcher, monkeypatch):
    computed = []
    apart = expressions.compute_in_child
    monkeypatch.setattr(
        expressions,
        'compute_in_child',
        lambda *words: computed.append(words) or apart(*words),
    )
    result = launcher.evaluate(
        'launch:\n- for: {name: i, len: 3, children: '
        "[{log_info: {message: $(eval '2 ** 4')}}]}\n"
    )
    assert [entry.text for entry in result.plan.entries] == ['16'] * 3
    assert len(computed) == 1


@pytest.mark.parametrize('kind', ['named pipe', 'device', 'large', 'folder'])
@pytest.mark.parametrize('way', ['content', 'parameters', 'include'])
def test_a_file_that_is_none(launcher, tmp_path, kind, way):
    file = tmp_path / 'file.yaml'
    if kind == 'named pipe':
        os.mkfifo(file)
    elif kind == 'device':
        file.symlink_to('/dev/zero')
    elif kind == 'folder':
        file.mkdir()
    else:
        with file.open('wb') as large:
            large.truncate(10**12)
    result = launcher.evaluate(
        {
            'content': message(f'$(file-content {file})'),
            'parameters': 'launch:\n- node: {pkg: alpha, exec: talker, '
            f'param: [{{from: {file}, allow_substs: true}}]}}\n',
            'include': f'launch:\n- include: {{file: {file}}}\n',
        }[way]
    )
    (problem,) = result.diagnostics
    assert str(file) in problem.message


def test_a_process_substitution_is_read(launcher):
    reader, writer = os.pipe()
    os.write(writer, b'hello\r\n')
    os.close(writer)
    result = launcher.evaluate(message(f'<$(file-content /dev/fd/{reader})>'))
    os.close(reader)
    assert result.plan.entries[0].text == '<hello\n>'


DOUBLING = {
    'let': ['let: {name: a, value: $(var a x)$(var a x)}'] * 59,
    'env': ["append_env: {name: A, value: $(env A x), separator: ''}"] * 59,
    'join': ['let: {name: a, value: $(string-join $(var a x) 1 2 3)}'] * 59,
}


@pytest.mark.parametrize('way', DOUBLING)
@pytest.mark.parametrize('look', [False, True])
def test_a_text_that_grows(launcher, way, look):
    text = 'launch:\n' + ''.join(f'- {line}\n' for line in DOUBLING[way])
    result = (
        check(launcher.request(text), portable=False)
        if look
        else launcher.evaluate(text)
    )
    if look:
        # what gets too long is not known before a launch
        return
    (error,) = result.errors
    assert 'characters' in error.message


LOOPS = {
    'huge': '- for: {name: i, len: "%s", children: [{reset_env: {}}]}'
    % ('9' * 400),
    'empty': '- for: {name: i, len: 199999, children: '
    '[{for: {name: j, len: 199999, children: []}}]}',
    'itself': '- include: {file: $(filename)}\n' * 3,
}


@pytest.mark.parametrize('way', ['huge', 'empty', 'itself'])
@pytest.mark.parametrize('look', [False, True])
def test_a_loop(launcher, way, look):
    text = f'launch:\n{LOOPS[way]}\n'
    if look:
        check(launcher.request(text), portable=False)
        return
    errors = launcher.evaluate(text).errors
    assert len(errors) == 1


@pytest.mark.parametrize(
    'text',
    [
        f'x: {nested(9, "1")}\n',
        f'launch:\n- for_each: {{values: "{nested(9, "1")}", children: []}}\n',
        'launch:\n- set_parameter: {name: a, value: "$(env NO '
        f"'{nested(9, '1')}')\"}}\n",
        'launch:\n- set_parameter: {name: a, value: $(env NO '
        f'{"9" * 5000})}}\n',
        f'launch: {"[" * 100_000}\n',
    ],
)
def test_yaml_that_explodes(launcher, text):
    (error,) = launcher.evaluate(text).errors
    assert len(error.message) < 1000


def test_a_command_that_writes_without_end(launcher):
    with within(60):
        (error,) = launcher.evaluate(message('$(command yes)')).errors
    assert 'writes more than 16777216 bytes' in error.message


@pytest.mark.parametrize('mode', ['capture', 'ignore'])
def test_a_command_that_complains_without_end(launcher, mode, monkeypatch):
    monkeypatch.setattr(commands, 'MAXIMUM_OUTPUT', 1_000_000)
    script = 'head -c 9999999 /dev/zero >&2; echo end'
    text = f"$(command 'sh -c \\'{script}\\'' {mode})"
    result = launcher.evaluate(message(text))
    if mode == 'capture':
        (error,) = result.errors
        assert 'writes more than' in error.message
    else:
        assert result.plan.entries[0].text == 'end\n'
