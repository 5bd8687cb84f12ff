# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The base class of our verbs, which reports their errors."""

import argparse
from collections.abc import Callable, Iterator
from contextlib import contextmanager
import errno
from functools import partial
from importlib import import_module
import logging
import os
import signal
import sys
from typing import Any, TYPE_CHECKING

from colcon_core.location import get_log_path
from colcon_core.plugin_system import satisfies_version
from colcon_core.verb import VerbExtensionPoint

if TYPE_CHECKING:
    from colcon_yamllaunch.verb.options import Verb

#: The exit code after Ctrl-C before anything runs (128 + SIGINT).
INTERRUPTED = 130

# those that end a process that does nothing about them
_SIGNALS = (signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)

logger = logging.getLogger('colcon.colcon_yamllaunch')


class OptionsVerb(VerbExtensionPoint):  # type: ignore[misc]
    """
    A verb: options that are described in `options`, and other words.

    colcon imports the modules of all verbs for every command, so everything
    else is imported when a verb is used.
    """

    NAME: 'Verb'
    USAGE: str
    EPILOG: str
    #: The words that are no options: how many, and their name and help.
    NARGS: str = argparse.REMAINDER
    WORDS: str
    WORDS_HELP: str

    def __init__(self) -> None:
        super().__init__()
        satisfies_version(VerbExtensionPoint.EXTENSION_POINT_VERSION, '^1.0')
        self._environment: dict[str, str] = {}

    def add_arguments(self, *, parser: Any) -> None:  # noqa: D102
        from colcon_yamllaunch.common.messages import open_standard_streams
        from colcon_yamllaunch.verb.command_line import add_options, print_help

        open_standard_streams()
        # on a full disk each message to colcon's log would show a traceback
        logging.raiseExceptions = False
        # what colcon adds to the environment is not the user's
        self._environment = dict(os.environ)
        parser.usage = self.USAGE
        parser.epilog = self.EPILOG
        # an abbreviation could be a word of a program, or a mistake
        parser.allow_abbrev = self.NARGS != argparse.REMAINDER
        parser.add_argument(
            'positionals',
            nargs=self.NARGS,
            metavar=self.WORDS,
            help=self.WORDS_HELP,
        )
        add_options(parser, self.NAME)
        parser.print_help = partial(print_help, parser, self.NAME)
        if '_ARGCOMPLETE' in self._environment:
            from colcon_yamllaunch.verb.completing import complete

            complete(self.NAME, parser, self._environment)

    def main(self, *, context: Any) -> int:  # noqa: D102
        return report_errors(self.NAME, partial(self._execute, context.args))

    def _execute(self, known: Any) -> int:
        """Call `main` of the module for this verb, such as `launch_main`."""
        from colcon_yamllaunch.verb.command_line import read_command_line

        options = read_command_line(known, self.NAME)
        if options is None:
            return 0
        module = import_module(f'{__package__}.{self.NAME}_main')
        return int(module.main(options, known, self._environment))


@contextmanager
def _ended_by_signals() -> Iterator[None]:
    """
    Turn signals into exceptions, so that commands of launch files end, too.

    Builds and running launches have their own handlers.

    :raises SystemExit: when one arrives
    """

    def end(number: int, _frame: object) -> None:
        raise SystemExit(128 + number)

    taken = [n for n in _SIGNALS if signal.getsignal(n) is signal.SIG_DFL]
    for number in taken:
        signal.signal(number, end)
    try:
        yield
    finally:
        for number in taken:
            signal.signal(number, signal.SIG_DFL)


def report_errors(verb: str, action: Callable[[], int]) -> int:
    """
    Call `action`, and report its error in one message.

    Return the exit code.
    """
    from colcon_yamllaunch.common.errors import UserError
    from colcon_yamllaunch.common.messages import (
        flush_or_drop,
        GiveUpError,
        say,
        written,
    )
    from colcon_yamllaunch.engine.loop import accept_signals

    try:
        accept_signals()
        with _ended_by_signals():
            code = action()
        with written():
            sys.stdout.flush()
        return code
    except GiveUpError as e:
        return e.returncode
    except UserError as e:
        say(e.lines(f'colcon {verb}'))
        return 1
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        # the reader of the output has ended
        return 1
    except Exception as e:
        if (lack := _lack(e)) is not None:
            say(f'colcon {verb}: error: {lack}')
            return 1
        # a defect of ours: the user gets one line, the log the traceback
        logger.debug('unexpected exception', exc_info=True)
        say(
            f'colcon {verb}: internal error: {type(e).__name__}: {e}\n'
            '  help: please report it with logger_all.log from '
            f'{get_log_path() or "the log folder"}'
        )
        return 1
    finally:
        flush_or_drop(sys.stdout)
        flush_or_drop(sys.stderr)


def _lack(problem: Exception) -> str | None:
    """Return which limit or device of the system is missing, with the fix."""
    if not isinstance(problem, OSError):
        return None
    if problem.errno in (errno.EMFILE, errno.ENFILE):
        reason = f'{problem.strerror}: a launch needs more of them'
        return f'{reason}\n  help: ulimit -n 1024'
    if problem.filename == os.devnull:
        reason = f"'{os.devnull}' cannot be opened: {problem.strerror}"
        return f'{reason}\n  help: mknod -m 666 {os.devnull} c 1 3, as root'
    return None
