# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
A launch file with the processes that must come of it.

A case NAME is `cases/NAME.yaml` and `expected/NAME.json`, and may have

- `cases/NAME.args`: launch arguments, one a line,
- `cases/NAME.env`: environment variables, one `NAME=value` a line,
- `cases/NAME.interrupt`: how many processes have to run before the launch gets
  SIGINT; without it the launch ends by itself.

The expected outcomes are as ROS 2's own launcher has them; where this one
differs on purpose, the file says why.
"""

from collections.abc import Callable
from dataclasses import dataclass
import json
import os
from pathlib import Path
import signal
import subprocess
import sys
import time
from typing import Any

from support.forks import Forks

HERE = Path(__file__).parent
#: Where the installed command is.
PROGRAMS = Path(sys.executable).parent
#: Seconds that a launch may take; most take half a second.
TIMEOUT = 120
#: The variables of the environment that could change a case's outcome.
FOREIGN = ('AMENT_', 'CMAKE_PREFIX_', 'COLCON_', 'OVERRIDE_', 'ROS_', 'T_')
#: What the installed command does, for a process that has it imported.
COLCON = """\
import sys
from colcon_core.command import main
sys.argv = {argv!r}
sys.exit(main())
"""

CASES = sorted(path.stem for path in (HERE / 'expected').glob('*.json'))


@dataclass(frozen=True)
class Launched:
    """
    What came of a launch.

    :param returncode: The exit code of the launcher
    :param output: What it showed
    :param records: What the processes wrote down, in the order of their start
    :param signals: The signals that a stubborn process got
    """

    returncode: int
    output: str
    records: list[dict[str, Any]]
    signals: list[str]


def expected(name: str) -> dict[str, Any]:
    """Return the expected outcome of a case."""
    path = HERE / 'expected' / f'{name}.json'
    outcome: dict[str, Any] = json.loads(path.read_text(encoding='utf-8'))
    outcome.pop('why', None)
    return outcome


def launch(
    name: str, cases: Path, prefix: Path, folder: Path, forks: Forks
) -> Launched:
    """
    Launch a case with the installed command.

    :param cases: The folder with the cases
    :param prefix: The prefix of the installed packages
    :param folder: An empty folder for this case alone
    """
    cwd, records = folder / 'cwd', folder / 'records'
    for path in (cwd, records):
        path.mkdir()
    environment = {
        **environment_of(name, cases, prefix, folder),
        'PROBE_FOLDER': str(records),
    }
    screen = folder / 'screen'
    argv = [str(PROGRAMS / 'colcon'), 'launch', f'{cases / name}.yaml']
    argv += lines(cases / f'{name}.args')
    counts = lines(cases / f'{name}.interrupt')
    if counts:
        returncode = _interrupted(
            argv, cwd, environment, screen, records, int(counts[0])
        )
    else:
        code = COLCON.format(argv=argv)
        returncode = forks.run(code, cwd, environment, screen, TIMEOUT)
    return Launched(
        returncode,
        screen.read_text(encoding='utf-8', errors='replace'),
        [
            without_places(
                json.loads(path.read_text(encoding='utf-8')),
                cases,
                prefix,
                cwd,
            )
            for path in sorted(records.glob('*.json'))
        ],
        lines(records / 'signals'),
    )


def _interrupted(
    argv: list[str],
    cwd: Path,
    environment: dict[str, str],
    screen: Path,
    records: Path,
    count: int,
) -> int:
    """Send SIGINT once so many processes have started; return the code."""
    with screen.open('wb') as output:
        popen = subprocess.Popen(
            argv,
            cwd=cwd,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
    try:
        _wait_until(lambda: len(list(records.glob('*.json'))) >= count, popen)
        popen.send_signal(signal.SIGINT)
        return popen.wait(TIMEOUT)
    finally:
        if popen.poll() is None:
            os.killpg(popen.pid, signal.SIGKILL)
            popen.wait()


def _wait_until(
    condition: Callable[[], bool], popen: subprocess.Popen[bytes]
) -> None:
    deadline = time.monotonic() + TIMEOUT
    while not condition():
        assert popen.poll() is None, 'the launch ended too early'
        assert time.monotonic() < deadline, 'it did not happen'
        time.sleep(0.01)


def environment_of(
    name: str, cases: Path, prefix: Path, home: Path
) -> dict[str, str]:
    """Return the environment that a case is launched in."""
    environment = {
        variable: value
        for variable, value in os.environ.items()
        if not variable.startswith(FOREIGN)
    }
    path = [str(prefix / 'bin'), str(PROGRAMS), environment['PATH']]
    return {
        **environment,
        'PATH': os.pathsep.join(path),
        'AMENT_PREFIX_PATH': str(prefix),
        'HOME': str(home),
        **dict(line.split('=', 1) for line in lines(cases / f'{name}.env')),
    }


def lines(path: Path) -> list[str]:
    """Return the lines of a file that may be missing."""
    if not path.exists():
        return []
    return path.read_text(encoding='utf-8').splitlines()


def without_places(record: Any, cases: Path, prefix: Path, cwd: Path) -> Any:
    """Put the names of the folders for their paths, in all texts."""
    places = {str(prefix): '$PREFIX', str(cases): '$CASES', str(cwd): '$CWD'}
    return _replace(record, places)


def _replace(value: Any, places: dict[str, str]) -> Any:
    if isinstance(value, str):
        for path, name in places.items():
            value = value.replace(path, name)
        return value
    if isinstance(value, list):
        return [_replace(item, places) for item in value]
    if isinstance(value, dict):
        return {
            _replace(key, places): _replace(item, places)
            for key, item in value.items()
        }
    return value
