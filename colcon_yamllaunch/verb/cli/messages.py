# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the verbs say to the user."""

from collections.abc import Callable
from collections.abc import Iterable
from collections.abc import Iterator
from contextlib import contextmanager
import logging
import os
import signal
import sys

import colcon_core
from colcon_core.location import get_log_path
import colcon_yamllaunch
from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.common.printable import printable
from colcon_yamllaunch.common.printable import printable_json

#: The exit code after Ctrl-C before anything runs (128 + SIGINT).
INTERRUPTED = 130

# those that end a process that does nothing about them
_SIGNALS = (signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)

logger = logging.getLogger('colcon.colcon_yamllaunch')


def say(text: str) -> None:
    """Print lines for the user, apart from the output of processes."""
    sys.stdout.flush()
    print(printable(text), file=sys.stderr, flush=True)


def say_line(text: str) -> None:
    """Print a line likewise; nothing that is in it makes it two."""
    say(one_line(text))


def show(text: str) -> None:
    """Print what the user asked to see."""
    print(printable(text), flush=True)


def show_json(text: str) -> None:
    """Print JSON that the user asked for; its values are exact."""
    print(printable_json(text), flush=True)


def enumeration(items: Iterable[str]) -> str:
    """Return items as a sentence has them; there is at least one."""
    *first, last = items
    return f'{", ".join(first)} and {last}' if first else last


def show_versions() -> int:
    """Do what `--version` asks for, and return the exit code."""
    print(
        f'colcon-yamllaunch {colcon_yamllaunch.__version__}, '
        f'colcon-core {colcon_core.__version__}',
        flush=True,
    )
    return 0


@contextmanager
def _ended_by_signals() -> Iterator[None]:
    """
    Let signals end us as an exception does, which ends what we wait for.

    A command of a launch file would go on otherwise. Builds and launches
    that run have handlers of their own.

    :raises SystemExit: when one arrives
    """
    taken = [n for n in _SIGNALS if signal.getsignal(n) is signal.SIG_DFL]
    for number in taken:
        signal.signal(number, _end)
    try:
        yield
    finally:
        for number in taken:
            signal.signal(number, signal.SIG_DFL)


def _end(number: int, _frame: object) -> None:
    raise SystemExit(128 + number)


def report_errors(verb: str, action: Callable[[], int]) -> int:
    """
    Do what a verb does, and say in one message what went wrong.

    Return the exit code.
    """
    try:
        with _ended_by_signals():
            return action()
    except UserError as e:
        say(f'colcon {verb}: error: {e}')
        return 1
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        # nobody reads what is shown; Python would complain of it at its end
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except Exception as e:
        # a defect of ours: the user gets one line, the log the traceback
        logger.debug('unexpected exception', exc_info=True)
        say(
            f'colcon {verb}: internal error: {type(e).__name__}: {e}\n'
            '  help: please report it with logger_all.log from '
            f'{get_log_path() or "the log folder"}'
        )
        return 1
