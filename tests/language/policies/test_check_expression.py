# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The expressions that a check may compute."""

from colcon_yamllaunch.language.actions.expressions import (
    compute,
    ExpressionError,
)
import pytest


@pytest.mark.parametrize(
    ('expression', 'result'),
    [
        ('1 + 2', '3'),
        (' 1 / 2', '0.5'),
        ("'a' == 'b'", 'False'),
        ("'sim' in ['sim', 'real'] and not False", 'True'),
        ("'Left'.lower() + '_arm'", 'left_arm'),
        ('cos(0) * 2', '2.0'),
        ("int('5') if 1 < 2 else None", '5'),
        ("'mode/fast'.split('/')[0]", 'mode'),
        ("'mode'[1:3]", 'od'),
        ("len(set('a_b'.split('_')).intersection(['a', 'c'])) > 0", 'True'),
        ('any([1, 0]) and sorted(list((2, 1)))', '[1, 2]'),
    ],
)
def test_a_result(expression: str, result: str) -> None:
    assert compute(expression) == result


@pytest.mark.parametrize(
    'expression',
    [
        "__import__('os').system('true')",
        "open('x')",
        '().__class__',
        "'{0.real}'.format(1)",
        "f'{1}'",
        '9 ** 9 ** 9',
        'pow(9, 999999999)',
        'factorial(999999999)',
        '1 << 999999999',
        "'a' * 999999999",
        "'%999999999d' % 1",
        'str(1) * 999999999',
        '[0] * 999999999',
        "list('a') * 999999999",
        "tuple('a') * 999999999",
        "sorted('a') * 999999999",
        '[x for x in range(9)]',
        '(lambda: 1)()',
        '1' + ' + 1' * 10_000,
        '-' * 1_900 + '1',
    ],
)
def test_what_only_a_launch_may_compute(expression: str) -> None:
    assert compute(expression) is None


@pytest.mark.parametrize('expression', ['', '1 +', '1 / 0', "'a' + 1", '\0'])
def test_a_failure(expression: str) -> None:
    with pytest.raises(ExpressionError):
        compute(expression)
