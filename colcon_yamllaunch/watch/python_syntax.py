# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Whether a Python file compiles, before a process is restarted with it."""

from collections.abc import Mapping
from contextlib import suppress
import os
import shutil
import subprocess
import warnings

from colcon_yamllaunch.common.files import content_of
from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic
from colcon_yamllaunch.plan.position import Position

_PYTHON = 'python3'
_SUFFIX = '.py'
#: Prints line, column and message of the error in a file, if it has one.
_PROGRAM = """\
import sys
path = sys.argv[1]
with open(path, 'rb') as file:
    text = file.read()
try:
    compile(text, path, 'exec', dont_inherit=True)
except SyntaxError as e:
    print('%d %d %s' % (e.lineno or 1, e.offset or 1, e.msg))
except ValueError as e:
    print('1 1 %s' % e)
"""
#: Seconds that this may take.
_TIMEOUT = 10.0


def compiles(path: str) -> bool:
    """
    Return whether a file compiles with the Python of this process.

    It may be for another Python, see :func:`source_error`. A file that is not
    Python code compiles.
    """
    try:
        text = content_of(path)
    except OSError:
        return True
    if not _interpreter(path, text):
        return True
    try:
        with warnings.catch_warnings():
            warnings.simplefilter('ignore')
            compile(text, path, 'exec', dont_inherit=True)
    except (SyntaxError, ValueError):
        return False
    except (RecursionError, MemoryError):
        pass
    return True


def source_error(
    path: str, environment: Mapping[str, str]
) -> Diagnostic | None:
    """
    Return the syntax error of a file according to the Python that runs it.

    :param environment: The environment of the processes
    """
    with suppress(OSError, subprocess.SubprocessError):
        program = shutil.which(
            _interpreter(path, content_of(path)), path=environment.get('PATH')
        )
        if program is None:
            return None
        found = subprocess.run(
            [program, '-I', '-S', '-W', 'ignore', '-c', _PROGRAM, path],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            timeout=_TIMEOUT,
            errors='replace',
            text=True,
        ).stdout
        if found:
            line, column, message = found.rstrip().split(' ', 2)
            position = Position(path, int(line), int(column))
            return Diagnostic('error', message, position)
    return None


def _interpreter(path: str, text: bytes) -> str:
    """Return the Python that runs a file; empty if it is not Python code."""
    line = os.fsdecode(text.partition(b'\n')[0])
    if not line.startswith('#!'):
        return _PYTHON if path.endswith(_SUFFIX) else ''
    words = line.removeprefix('#!').split()
    names = (w for w in words if 'python' in os.path.basename(w))
    return next(names, '')
