# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Plans in which stands what only a launch may find out."""

from colcon_yamllaunch.language.policies.evaluate import evaluate, Evaluation
import pytest
from support.language_fixtures import Launcher

OPEN = """
launch:
- let: {name: x, value: "$(command 'cat x')"}
"""


def planned(launcher: Launcher, text: str) -> Evaluation:
    return evaluate(launcher.request(OPEN + text), runs=False)


@pytest.mark.parametrize(
    ('text', 'shown'),
    [
        ('$(var x)', "$(command 'cat x')"),
        ('a$(var x)b', "a$(command 'cat x')b"),
        (
            '"$(equals $(var x) b)"',
            "$(equals '$(command '\"'\"'cat x'\"'\"')' b)",
        ),
        (
            '"$(eval \'1 + $(var x)\')"',
            "$(eval '1 + $(command '\"'\"'cat x'\"'\"')')",
        ),
    ],
)
def test_what_is_made_of_it_is_left_open_too(
    launcher: Launcher, text: str, shown: str
) -> None:
    evaluation = planned(launcher, f'- executable: {{cmd: [echo, {text}]}}')
    assert evaluation.errors == ()
    (process,) = evaluation.plan.processes()
    assert process.argv == ('echo', shown)
    assert evaluation.plan.left_open == ("$(command 'cat x')",)


def test_it_may_be_one_of_the_choices(launcher: Launcher) -> None:
    launcher.write(
        'child.yaml', 'launch: [arg: {name: c, choice: [{value: a}]}]'
    )
    text = '- include: {file: child.yaml, arg: [{name: c, value: $(var x)}]}'
    assert planned(launcher, text).errors == ()


@pytest.mark.parametrize('condition', ['$(var x)', '"$(equals $(var x) b)"'])
def test_a_condition_must_be_known(launcher: Launcher, condition: str) -> None:
    text = f'- log: {{message: hello, if: {condition}}}'
    (problem,) = planned(launcher, text).errors
    assert "what the condition 'if' comes to is left open" in problem.message
    assert problem.hint is not None
    assert '--run-commands' in problem.hint
