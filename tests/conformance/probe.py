# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The program of the conformance cases: it writes down how it was started.

The record goes to a file in the folder that PROBE_FOLDER names. What the
program does then is in its arguments: `--say TEXT`, `--warn TEXT`,
`--sleep SECONDS`, `--exit CODE`, or `--stubborn` to ignore SIGINT and SIGTERM.
"""

from collections.abc import Mapping
import json
import os
from pathlib import Path
import signal
import sys
import time
from types import FrameType
from typing import Any

#: The variables that a case may look at.
KEPT = ('T_', 'ROS_', 'OVERRIDE_')
#: Those of them that depend on where and with what the launch runs.
DROPPED = ('ROS_HOME', 'ROS_LOG_DIR', 'ROS_PYTHON_VERSION', 'ROS_VERSION')


def main() -> None:
    folder = Path(os.environ['PROBE_FOLDER'])
    arguments = sys.argv[1:]
    if '--stubborn' in arguments:
        note_signals(folder)
    else:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    write_record(folder, arguments)
    act(arguments)


def note_signals(folder: Path) -> None:
    def note(number: int, _frame: FrameType | None) -> None:
        with (folder / 'signals').open('a', encoding='ascii') as file:
            file.write(f'{signal.Signals(number).name[3:]}\n')

    signal.signal(signal.SIGINT, note)
    signal.signal(signal.SIGTERM, note)


def write_record(folder: Path, arguments: list[str]) -> None:
    program = Path(sys.argv[0]).absolute()
    record = record_of(program, arguments, os.getcwd(), os.environ)
    # a reader must never see half of it
    unfinished = folder / f'{os.getpid()}.unfinished'
    unfinished.write_text(json.dumps(record), encoding='utf-8')
    unfinished.rename(folder / f'{time.monotonic_ns()}-{os.getpid()}.json')


def record_of(
    program: Path,
    arguments: list[str],
    cwd: str,
    environment: Mapping[str, str],
) -> dict[str, Any]:
    """Return what the program writes down when it is started like this."""
    arguments = list(arguments)
    return {
        'exe': program.name,
        'from': program.parent.name,
        'params': take_parameter_files(arguments),
        'args': arguments,
        'cwd': cwd,
        'env': {
            name: value
            for name, value in environment.items()
            if name.startswith(KEPT) and name not in DROPPED
        },
    }


def take_parameter_files(arguments: list[str]) -> list[Any]:
    """Read the parameter files, and put their numbers for their paths."""
    contents: list[Any] = []
    for index, argument in enumerate(arguments[:-1], 1):
        if argument == '--params-file':
            # few cases have one
            import yaml

            path = Path(arguments[index])
            try:
                contents.append(yaml.safe_load(path.read_bytes()))
            except OSError as e:
                contents.append(repr(e))
            arguments[index] = str(len(contents) - 1)
    return contents


def act(arguments: list[str]) -> None:
    for option, value in zip(arguments, [*arguments[1:], ''], strict=True):
        if option == '--say':
            print(value, flush=True)
        elif option == '--warn':
            print(value, file=sys.stderr, flush=True)
        elif option == '--sleep':
            time.sleep(float(value))
        elif option == '--exit':
            sys.exit(int(value))
        elif option == '--stubborn':
            while True:
                signal.pause()


if __name__ == '__main__':
    main()
