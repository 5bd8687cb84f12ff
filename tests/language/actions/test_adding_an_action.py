# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What CONTRIBUTING.md says of adding an action is all that it takes."""

from pathlib import Path
import re
from textwrap import dedent

from colcon_yamllaunch.language.actions import handlers
from colcon_yamllaunch.language.actions.handlers import HANDLERS
from colcon_yamllaunch.language.policies.check import check, find_declarations
from colcon_yamllaunch.language.vocabulary import actions
from launch_examples import EXAMPLES
import pytest
from support.language_fixtures import Launcher

ROOT = Path(__file__).parents[3]


@pytest.fixture
def name(monkeypatch: pytest.MonkeyPatch) -> str:
    """Add the action of the page, and give its name."""
    page = (ROOT / 'CONTRIBUTING.md').read_text(encoding='utf-8')
    section = page.partition('\n## Add an action\n')[2].partition('\n## ')[0]
    blocks = re.findall(r'(?:^ {7}.*\n)+', section, re.MULTILINE)
    entry, function, example = map(dedent, blocks)
    action = eval(entry, vars(actions))
    made = dict(vars(handlers))
    exec(function, made)
    monkeypatch.setitem(actions.ACTIONS, action.name, action)
    monkeypatch.setitem(HANDLERS, action.name, made[f'_{action.name}'])  # type: ignore[misc]
    for key, text in eval(f'{{{example}}}').items():
        monkeypatch.setitem(EXAMPLES, key, text)
    return str(action.name)


def test_that_it_is_launched(name: str, launcher: Launcher) -> None:
    text = f'launch:\n{EXAMPLES[name]}- log: {{message: $(var rate)}}\n'
    (message,) = launcher.good(text).plan.entries
    assert '10' in str(message)
    (message,) = launcher.good(text, rate='20').plan.entries
    assert '20' in str(message)


def test_that_its_mistakes_are_found(name: str, launcher: Launcher) -> None:
    text = f'launch:\n- {name}: {{name: rate, value: $(var nonesuch)}}\n'
    (error,) = launcher.errors(text)
    assert "'nonesuch' does not exist" in error.message
    checked = check(launcher.request(text), portable=False)
    assert checked.errors == (error,)

    errors = launcher.errors(f'launch:\n- {name}: {{nam: rate}}\n')
    assert "did you mean 'name'?" in [error.hint for error in errors]


def test_that_includes_may_depend_on_it(name: str, launcher: Launcher) -> None:
    launcher.write('sub.yaml', 'launch: [arg: {name: inner}]')
    text = (
        f'launch:\n- {name}: {{name: file, value: sub.yaml}}\n'
        '- include: {file: $(var file)}\n'
    )
    declared = find_declarations(launcher.request(text)).arguments
    assert [argument.name for argument in declared] == ['inner']
