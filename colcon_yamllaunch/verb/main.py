# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""From the command line of `colcon launch` to its exit code."""

from collections.abc import Mapping
import logging
import os
from pathlib import Path
import sys
from typing import Any

from colcon_core.location import get_log_path
from colcon_yamllaunch.verb.launching import Launching
from colcon_yamllaunch.verb.launching import log_folder_of
from colcon_yamllaunch.verb.launching import say
from colcon_yamllaunch.verb.options import parse_options
from colcon_yamllaunch.workspace.error import WorkspaceError

#: The exit code after Ctrl-C before anything runs (128 + SIGINT).
INTERRUPTED = 130

logger = logging.getLogger('colcon.colcon_yamllaunch')


def main(known: Any, environment: Mapping[str, str]) -> int:
    """
    Build, source and launch.

    :param known: What colcon's parser has made of the command line
    :param environment: The user's environment
    :returns: The exit code
    """
    if any(word in ('-h', '--help') for word in known.words):
        known.verb_parser.print_help()
        return 0
    try:
        log_folder = log_folder_of(known.log_base, environment)
        options = parse_options(known)
        if options.look == 'schema':
            from colcon_yamllaunch.language.schema import schema_text

            print(schema_text(), end='', flush=True)
            return 0
        launching = Launching(options, Path.cwd(), environment, log_folder)
        if options.look is not None:
            # a launch that runs does without all that this imports
            from colcon_yamllaunch.verb.looking import look

            return look(launching, options)
        if options.plan is not None:
            return launching.run_saved(options.plan)
        return launching.run()
    except WorkspaceError as e:
        say(f'colcon launch: error: {e}')
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
            f'colcon launch: internal error: {type(e).__name__}: {e}\n'
            '  help: please report it with logger_all.log from '
            f'{get_log_path() or "the log folder"}'
        )
        return 1
