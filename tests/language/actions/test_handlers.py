# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""There is one handler for each action, which no policy passes over."""

from pathlib import Path

import colcon_yamllaunch
from colcon_yamllaunch.language.actions.component_actions import (
    COMPONENT_HANDLERS,
)
from colcon_yamllaunch.language.actions.handlers import HANDLERS, PASSIVE
from colcon_yamllaunch.language.actions.process_actions import PROCESS_HANDLERS
from colcon_yamllaunch.language.actions.substitution_makers import MAKERS
from colcon_yamllaunch.language.evaluation.attributes import Attributes
from colcon_yamllaunch.language.evaluation.walk import Walk
from colcon_yamllaunch.language.policies.check import check, find_declarations
from colcon_yamllaunch.language.policies.evaluate import evaluate
from colcon_yamllaunch.language.vocabulary.actions import ACTIONS, COMPONENTS
from colcon_yamllaunch.language.vocabulary.substitutions import KINDS
from launch_examples import EXAMPLES
import pytest
from support.language_fixtures import Launcher

LANGUAGE = Path(colcon_yamllaunch.__file__).parent / 'language'
#: The folders that interpret launch files.
INTERPRETER = ('actions', 'evaluation', 'policies')
#: The shortest text that is taken for a message, in characters.
SHORTEST = 20


def test_that_each_action_has_exactly_one_handler() -> None:
    assert HANDLERS.keys() == {*ACTIONS, *COMPONENTS}
    assert HANDLERS.items() >= PROCESS_HANDLERS.items()
    assert HANDLERS.keys() >= COMPONENT_HANDLERS.keys()


def test_that_each_substitution_has_a_maker() -> None:
    assert MAKERS.keys() == KINDS.keys()


@pytest.mark.parametrize('name', ACTIONS)
def test_that_each_policy_comes_to(
    name: str, launcher: Launcher, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[type[Walk]] = []
    handler = HANDLERS[name]

    def spy(walk: Walk, attributes: Attributes) -> None:
        seen.append(type(walk))
        handler(walk, attributes)

    monkeypatch.setitem(HANDLERS, name, spy)  # type: ignore[misc]
    launcher.packages.programs = {'my_pkg': {'driver', 'planner'}}
    request = launcher.request(f'launch:\n{EXAMPLES[name]}')
    evaluate(request)
    check(request, portable=True)
    find_declarations(request)

    missed = {'Walk', '_Check', '_Listing'} - {p.__name__ for p in seen}
    may_miss = set()
    if name in PASSIVE:
        may_miss.add('_Listing')
    if ' if: ' in EXAMPLES[name]:
        may_miss.add('Walk')
    assert missed <= may_miss
