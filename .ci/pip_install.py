#!/usr/bin/env python3
# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Run `pip install` with the given arguments, and show how far it is.

What pip writes is only shown when it fails.
"""

import re
import subprocess
import sys

#: Without a terminal, one line for so many packages.
STEP = 25
CLEAR = '\r\033[K'


def main() -> int:
    """Install, and return the exit code of pip."""
    command = [sys.executable, '-m', 'pip', '--disable-pip-version-check']
    command += ['install', '--progress-bar', 'off', *sys.argv[1:]]
    with subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors='replace',
    ) as pip:
        assert pip.stdout is not None
        lines = []
        names: set[str] = set()
        for line in pip.stdout:
            lines.append(line)
            if line.startswith('Collecting '):
                name = re.split(r'[^\w.-]', line.split()[1])[0]
                names.add(name)
                _show(f'package {len(names)}: {name}', len(names))
            elif line.startswith('Installing collected') and len(names) > 1:
                _show(f'unpacking {len(names)} packages', 0)
    if sys.stdout.isatty():
        print(end=CLEAR)
    if pip.returncode:
        print(''.join(lines), file=sys.stderr)
    return pip.returncode


def _show(text: str, count: int) -> None:
    if sys.stdout.isatty():
        print(f'{CLEAR}  {text}', end='', flush=True)
    elif count % STEP == 0:
        print(f'  {text}', flush=True)


if __name__ == '__main__':
    sys.exit(main())
