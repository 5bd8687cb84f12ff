# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A check finds errors in the conformance cases that cannot be launched."""

import os
from pathlib import Path
import shutil

from colcon_yamllaunch.language.evaluation.request import Request
from colcon_yamllaunch.language.policies.check import check
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator
from colcon_yamllaunch.workspace.workspace_session import LaunchPackages
import pytest

from tests.conformance.case import CASES, expected
from tests.conformance.prefix import install_packages

CASES_FOLDER = Path(__file__).parents[2] / 'conformance' / 'cases'
#: The cases whose mistake only a launch can see.
ONLY_LAUNCHED = (
    'args_malformed',
    'args_missing_required',
    'env_missing',
    'subst_command_fails',
    'subst_command_stderr_default',
    'subst_command_stderr_fail',
)
#: The cases of a launch that goes on without what a check finds missing.
RUN_WITHOUT_A_PART = ('executable_missing_beside_others',)


@pytest.fixture(scope='module')
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Give a folder with the cases, and the prefix of their packages."""
    folder = tmp_path_factory.mktemp('cases')
    shutil.copytree(CASES_FOLDER, folder / 'cases')
    install_packages(folder / 'prefix')
    return folder


def _lines(path: Path, separator: str) -> dict[str, str]:
    text = path.read_text(encoding='utf-8') if path.exists() else ''
    lines = [line for line in text.splitlines() if separator in line]
    return dict(line.split(separator, 1) for line in lines)


@pytest.mark.parametrize('name', CASES)
def test_case(name: str, installed: Path) -> None:
    file = installed / 'cases' / f'{name}.yaml'
    prefix = installed / 'prefix'
    environment = {
        'PATH': f'{prefix / "bin"}:{os.environ["PATH"]}',
        'AMENT_PREFIX_PATH': str(prefix),
        **_lines(file.with_suffix('.env'), '='),
    }
    locator = PackageLocator((), installed / 'install', False, environment)
    result = check(
        Request(
            str(file),
            str(file),
            packages=LaunchPackages(locator, built=True),
            environment=environment,
            arguments=_lines(file.with_suffix('.args'), ':='),
            cwd=str(installed),
        ),
        portable=False,
    )
    outcome = expected(name)
    is_refused = not outcome['exit_ok'] and not outcome['processes']
    has_errors = is_refused and name not in ONLY_LAUNCHED
    assert bool(result.errors) == (has_errors or name in RUN_WITHOUT_A_PART)
