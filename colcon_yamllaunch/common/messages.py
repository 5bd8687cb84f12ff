# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Messages and results of a command."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
import os
import sys
from typing import Any, TextIO

from colcon_yamllaunch.common.errors import OutputError
from colcon_yamllaunch.common.printable import (
    one_line,
    printable,
    printable_json,
)


class GiveUpError(Exception):
    """
    The verb ends here; the user knows why.

    :param is_build: Whether a build failed
    """

    def __init__(self, returncode: int, *, is_build: bool = False) -> None:
        super().__init__()
        self.returncode = returncode
        self.is_build = is_build


def say(text: str) -> None:
    """Print lines for the user, apart from the output of processes."""
    # errors of standard output are reported by `show`
    with suppress(OSError):
        sys.stdout.flush()
    try:
        print(printable(text), file=sys.stderr, flush=True)
    except OSError:
        # a lost message does not change the result
        _drop(sys.stderr)


def say_line(text: str) -> None:
    """Print a message as one line, whatever characters it contains."""
    say(one_line(text))


def show(text: str, end: str = '\n') -> None:
    """
    Print what the user asked for.

    :raises OutputError: when it cannot be written
    """
    with written():
        print(printable(text), end=end, flush=True)


def show_json(text: str) -> None:
    """
    Print JSON that the user asked for; its values are exact.

    :raises OutputError: when it cannot be written
    """
    with written():
        print(printable_json(text), flush=True)


def show_bytes(data: bytes) -> None:
    """
    Print bytes at once.

    :raises OutputError: when they cannot be written
    """
    with written():
        sys.stdout.buffer.write(data)
        sys.stdout.flush()


@contextmanager
def written() -> Iterator[None]:
    """
    Write to standard output.

    :raises OutputError: when it takes nothing
    :raises BrokenPipeError: when nobody reads it
    """
    try:
        yield
    except OSError as e:
        # Python would try, and complain, once more at its end
        _drop(sys.stdout)
        if isinstance(e, BrokenPipeError):
            raise
        raise OutputError(e) from e


class ForgivingOutput:
    """
    Standard output that ignores errors, for code that cannot handle them.

    Later writes to the real standard output report the error.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write a text if that is possible."""
        with suppress(OSError):
            self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        """Write all if that is possible."""
        with suppress(OSError):
            self._stream.flush()


def _drop(stream: TextIO) -> None:
    """Lead a stream to where everything vanishes."""
    # a stream may be no file of the system
    with suppress(OSError, ValueError):
        descriptor = os.open(os.devnull, os.O_WRONLY | os.O_CLOEXEC)
        os.dup2(descriptor, stream.fileno())
        os.close(descriptor)


def open_standard_streams() -> None:
    """
    Open closed standard input, output and error on the null device.

    Otherwise the next file that is opened would take its place, and there
    would be nothing to print to: for Python, the stream is then None.
    """
    if None not in (sys.stdin, sys.stdout, sys.stderr):
        return
    descriptor = os.open(os.devnull, os.O_RDWR)
    while descriptor <= 2:
        descriptor = os.dup(descriptor)
    os.close(descriptor)
    sys.stdin = sys.stdin or os.fdopen(0, closefd=False)
    sys.stdout = sys.stdout or os.fdopen(1, 'w', closefd=False)
    sys.stderr = sys.stderr or os.fdopen(2, 'w', closefd=False)


def flush_or_drop(stream: TextIO) -> None:
    """Leave nothing that Python would try in vain to write at its end."""
    try:
        stream.flush()
    except OSError:
        # the exit code would be 120 then
        _drop(stream)
    except ValueError:
        # somebody has closed it
        return
