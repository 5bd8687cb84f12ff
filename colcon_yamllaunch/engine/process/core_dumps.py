# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The path of a core dump; see core(5)."""

from collections.abc import Callable
import glob
import os
from pathlib import Path
import re
import time

from colcon_yamllaunch.engine import limits

#: Where Linux says what it does with core dumps.
KERNEL = Path('/proc/sys/kernel')


def find_core_dump(
    pid: int,
    cwd: str,
    seconds: float,
    kernel: Path = KERNEL,
    now: Callable[[], float] = time.time,
) -> str | None:
    """
    Return where the core dump of a process is that has just ended.

    That is a path, a command that opens it, or the program that got it; None
    if it is not found.

    :param cwd: The working directory that it was started in
    :param seconds: How long it ran
    """
    pattern = _setting(kernel / 'core_pattern') or 'core'
    if pattern.startswith('|'):
        program = pattern[1:].split()[0]
        if program.endswith('systemd-coredump'):
            return f'coredumpctl debug {pid}'
        return f'passed to {program}'
    path = os.path.join(glob.escape(cwd), _as_glob(pattern, pid))
    if '%p' not in pattern and _setting(kernel / 'core_uses_pid') == '1':
        path += f'.{pid}'
    return _newest(path, now() - seconds)


def _as_glob(pattern: str, pid: int) -> str:
    known = {'%%': '%', '%p': str(pid), '%P': str(pid)}
    return re.sub(
        r'%.|[\[*?]',
        lambda m: known.get(m[0], '*' if m[0][0] == '%' else f'[{m[0]}]'),
        pattern,
    )


def _newest(pattern: str, since: float) -> str | None:
    """Return the newest file, unless it is older than the process."""
    times = {}
    for name in glob.glob(pattern):
        try:
            times[name] = Path(name).stat().st_mtime
        except OSError:
            continue
    newest = max(times, key=times.__getitem__, default=None)
    if newest is None or times[newest] < since - limits.FILE_TIME_STEP:
        return None
    return newest


def _setting(path: Path) -> str:
    try:
        return path.read_text(encoding='utf-8', errors='replace').strip()
    except OSError:
        return ''
