# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The package flow, built and run where nothing of ROS is in reach."""

from collections.abc import Iterator
import os
from pathlib import Path
import shutil
import signal
import subprocess
import sys

import pytest

from .conftest import BUILD_TIMEOUT
from .conftest import copy_sample_ws
from .conftest import Environment
from .conftest import Start

pytestmark = [pytest.mark.full, pytest.mark.xdist_group('sample_ws')]


def _path_without_this_python() -> Iterator[str]:
    """Leave out the folder where the ROS wheels have their CMake files."""
    own = Path(sys.executable).parent
    for folder in os.environ['PATH'].split(os.pathsep):
        if Path(folder) != own:
            yield folder


@pytest.fixture(scope='module')
def bare_environment() -> Environment:
    return {'PATH': os.pathsep.join(_path_without_this_python())}


@pytest.fixture(scope='module')
def installed(
    tmp_path_factory: pytest.TempPathFactory, bare_environment: Environment
) -> Path:
    """Install flow with CMake alone and return lib/flow."""
    folder = tmp_path_factory.mktemp('flow')
    source = copy_sample_ws(folder / 'ws') / 'flow'
    cmake = shutil.which('cmake', path=_with_own_programs())
    assert cmake is not None
    build, prefix = folder / 'build', folder / 'install'
    for argv in (
        [cmake, '-S', source, '-B', build, f'-DCMAKE_INSTALL_PREFIX={prefix}'],
        [cmake, '--build', build, '--target', 'install'],
    ):
        subprocess.run(
            argv,
            env=bare_environment,
            stdout=subprocess.DEVNULL,
            timeout=BUILD_TIMEOUT,
            check=True,
        )
    return prefix / 'lib/flow'


def _with_own_programs() -> str:
    """Return the PATH on which CMake may come from a wheel."""
    return os.pathsep.join(
        [str(Path(sys.executable).parent), os.environ['PATH']]
    )


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_pump_runs_until_stopped(
    installed: Path,
    bare_environment: Environment,
    start: Start,
    number: signal.Signals,
) -> None:
    pump = start(bare_environment, installed / 'pump', '--period', '0.01')
    pump.wait_for('Pumped 3 l')
    assert pump.stop(number) == 0
    assert pump.lines[:2] == ['Pumped 1 l', 'Pumped 2 l']
    assert pump.lines[-1] == 'Pump stopped'


@pytest.mark.parametrize('period', ['', '0', '-1', 'x', '1s', 'nan', '1e9'])
def test_pump_rejects_a_period(
    installed: Path,
    bare_environment: Environment,
    start: Start,
    period: str,
) -> None:
    pump = start(bare_environment, installed / 'pump', '--period', period)
    assert pump.end() == 2
    [line] = pump.lines
    assert line.startswith('usage: pump')


def test_inspect_says_one_line_and_ends(
    installed: Path, bare_environment: Environment, start: Start
) -> None:
    inspect = start(bare_environment, installed / 'inspect.sh', 'pump-1')
    assert inspect.end() == 0
    assert inspect.lines == ['Inspected pump-1: valve open, tank dry']


def test_launch_file_is_installed(installed: Path) -> None:
    assert (installed.parents[1] / 'share/flow/launch/flow.yaml').is_file()
