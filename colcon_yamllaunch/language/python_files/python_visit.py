# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the host is asked, and what becomes of its failures."""

import os

from colcon_yamllaunch.language.evaluation.launch_worker import NoWorkerError
from colcon_yamllaunch.language.evaluation.launch_worker import WorkerError
from colcon_yamllaunch.language.evaluation.launch_worker import WorkerMessage
from colcon_yamllaunch.language.evaluation.launch_worker import (
    WorkerTimeoutError,
)
from colcon_yamllaunch.language.evaluation.values import AlreadyReportedError
from colcon_yamllaunch.language.evaluation.walk import Walk
from colcon_yamllaunch.language.python_files.python_errors import at_frames
from colcon_yamllaunch.language.python_files.python_errors import is_no_choice
from colcon_yamllaunch.language.python_files.python_errors import python_error
from colcon_yamllaunch.language.python_files.python_errors import (
    TIMEOUT_VARIABLE,
)
from colcon_yamllaunch.language.python_files.worker_dialogue import (
    WorkerDialogue,
)
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.source_text import Source
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.plan.position import Span


class NotTakenOverError(Exception):
    """
    A launch file in Python cannot be a part of the plan.

    :param reason: Why, or None when there is no host
    """

    def __init__(self, reason: str | None) -> None:
        super().__init__()
        self.reason = reason


def visit_in_python(walk: Walk, what: str, path: str, origin: Span) -> None:
    """
    Have the host read a launch file in Python.

    :param what: What to do with it: `visit` or `arguments`
    :param path: The launch file
    :param origin: Where it is included, else its start
    :raises NotTakenOverError: when there is no host, or the host cannot
    :raises LaunchError: when the launch cannot go on
    """
    start = Position(walk.source_path(path), 1, 1)
    is_first = not walk.depth
    walk.note_python(start.path)
    problem = None
    with walk.within(
        Source(start.path, path, ''), None if is_first else origin
    ):
        try:
            message = _asked(walk, {'do': what, 'path': path}, origin, start)
            if 'error' in message:
                if is_no_choice(walk, message['error'], start):
                    raise AlreadyReportedError
                raise python_error(walk, message['error'], start)
        except LaunchError as e:
            problem = e
    if problem is not None or message.get('failed'):
        # it may have set anything
        walk.scope.configurations.is_open = True
    if problem is not None:
        raise problem if is_first else problem.included_from(origin.position)
    if 'refused' in message:
        raise NotTakenOverError(str(message['refused']))
    if message.get('failed'):
        raise AlreadyReportedError


def ask_worker(walk: Walk, request: WorkerMessage, origin: Span) -> str | None:
    """
    Ask the host for something in the scope that there is, and do what it says.

    :param request: What it is asked for, without number and scope
    :param origin: What asks for it
    :return: The text of a `value`, if the answer has one
    :raises NotTakenOverError: when there is no host, or the host cannot
    :raises LaunchError: when it fails
    """
    message = _asked(walk, request, origin, origin.position)
    if 'error' in message:
        raise python_error(walk, message['error'], origin.position)
    if 'refused' in message:
        raise NotTakenOverError(str(message['refused']))
    if message.get('failed'):
        raise AlreadyReportedError
    value = message.get('value')
    return None if value is None else str(value)


def finish(walk: Walk, path: str) -> None:
    """
    Tell the host that all is read, where there is something left to be done.

    :param path: The outermost launch file
    :raises LaunchError: when the launch cannot go on
    """
    if walk.dialogue is not None and walk.dialogue.goes_on:
        start = Position(path, 1, 1)
        try:
            ask_worker(walk, {'do': 'finish'}, start)
        except NotTakenOverError as e:
            raise error(str(e.reason), start) from e


def _asked(
    walk: Walk, request: WorkerMessage, origin: Span, start: Position
) -> WorkerMessage:
    """
    Ask the host.

    :param start: The start of the launch file that it is about
    :raises NotTakenOverError: when there is none
    :raises LaunchError: when the launch cannot go on
    """
    if walk.open_worker is None:
        raise NotTakenOverError(None)
    host = walk.open_worker()
    try:
        if walk.dialogue is None:
            walk.dialogue = WorkerDialogue(walk, host)
        return walk.dialogue.ask(request, origin)
    except NoWorkerError as e:
        raise NotTakenOverError(None) from e
    except WorkerTimeoutError as e:
        frames = host.doing().get('frames') or ()
        name = os.path.basename(start.path)
        text = f"the launch file '{name}' takes {e} to be read"
        hint = f'{TIMEOUT_VARIABLE}=SECONDS gives it more time'
        if frames:
            text += ', and is here'
        raise at_frames(walk, frames, text, hint, start) from e
    except WorkerError as e:
        if walk.has_lost_worker:
            raise AlreadyReportedError from e
        walk.has_lost_worker = True
        raise error(
            f'the process that reads launch files in Python {e}', start
        ) from e
