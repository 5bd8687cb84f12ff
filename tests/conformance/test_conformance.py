# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launch files come to the same processes as with ROS 2's own launcher."""

import json
from pathlib import Path
import re
import shutil
from typing import Any

from colcon_yamllaunch.deployment.machine_settings import deployed_on
from colcon_yamllaunch.deployment.placement import place
from colcon_yamllaunch.language.policies.evaluate import evaluate
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.plan_json import plan_to_json
import pytest
from support.forks import Forks

from tests.conformance.case import CASES, expected, launch
from tests.conformance.outcome import outcome
from tests.conformance.planned import ONLY_LAUNCHED, plan, request
from tests.conformance.prefix import install_packages

CASES_FOLDER = Path(__file__).with_name('cases')


def _as_json(value: Any) -> str:
    return json.dumps(value, sort_keys=True)


@pytest.fixture(scope='session')
def installed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Give a folder with the cases, and the prefix of their packages."""
    # outside of the checkout, which a launch could take for its workspace
    folder = tmp_path_factory.mktemp('conformance')
    shutil.copytree(CASES_FOLDER, folder / 'cases')
    install_packages(folder / 'prefix')
    return folder / 'cases', folder / 'prefix'


def test_that_each_case_has_a_launch_file_and_an_outcome() -> None:
    assert [p.stem for p in sorted(CASES_FOLDER.glob('*.yaml'))] == CASES


@pytest.mark.parametrize('name', CASES)
def test_case(
    name: str, installed: tuple[Path, Path], tmp_path: Path, forks: Forks
) -> None:
    launched = launch(name, *installed, tmp_path, forks)
    found = outcome(launched.returncode, launched.records, launched.signals)
    assert found == expected(name), launched.output
    # in Python 1, 1.0 and True are equal; to a node they are not
    assert _as_json(found) == _as_json(expected(name))
    assert 'Traceback (most recent' not in launched.output
    assert 'internal error' not in launched.output
    if not found['exit_ok'] and not found['processes']:
        # it was refused, or nothing could be started: it has to say why
        assert re.search('error: |could not be started', launched.output)


@pytest.mark.parametrize('name', sorted({*CASES} - ONLY_LAUNCHED))
def test_plan(name: str, installed: tuple[Path, Path], tmp_path: Path) -> None:
    planned = plan(name, *installed, tmp_path)
    found = outcome(planned.returncode, planned.records, planned.signals)
    # a plan is not stopped
    wanted = expected(name) | {'signals': []}
    assert found == wanted, planned.output
    assert _as_json(found) == _as_json(wanted)


@pytest.mark.parametrize('name', CASES)
def test_plan_of_another_machine(
    name: str, installed: tuple[Path, Path], tmp_path: Path
) -> None:
    wanted = evaluate(request(name, *installed, tmp_path)).plan
    placed = place(wanted, deployed_on('x@y'))
    # what --plan=json shows
    assert plan_to_json(placed.whole) == plan_to_json(wanted)
    # and nothing that it starts is lost, or stays here
    assert not list(placed.local.processes())
    assert not list(placed.local.components())
    part = placed.parts.get('y', Plan())
    assert list(part.processes()) == list(wanted.processes())
    assert list(part.components()) == list(wanted.components())
