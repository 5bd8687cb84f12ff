# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the host is asked, and what becomes of its failures."""

from collections.abc import Iterable
import os
import shutil

from colcon_yamllaunch.language.actions.process_actions import general_timeout
from colcon_yamllaunch.language.evaluation.findings import DeclaredArgument
from colcon_yamllaunch.language.evaluation.launch_worker import NoWorkerError
from colcon_yamllaunch.language.evaluation.launch_worker import WorkerError
from colcon_yamllaunch.language.evaluation.launch_worker import WorkerMessage
from colcon_yamllaunch.language.evaluation.launch_worker import (
    WorkerTimeoutError,
)
from colcon_yamllaunch.language.evaluation.scope import environment_changes
from colcon_yamllaunch.language.evaluation.values import AlreadyReportedError
from colcon_yamllaunch.language.evaluation.walk import EndlessError
from colcon_yamllaunch.language.evaluation.walk import Walk
from colcon_yamllaunch.language.python_files.python_errors import at_frames
from colcon_yamllaunch.language.python_files.python_errors import is_no_choice
from colcon_yamllaunch.language.python_files.python_errors import python_error
from colcon_yamllaunch.language.python_files.python_errors import (
    TIMEOUT_VARIABLE,
)
from colcon_yamllaunch.language.python_files.python_errors import (
    written_arguments,
)
from colcon_yamllaunch.language.python_files.worker_dialogue import position_of
from colcon_yamllaunch.language.python_files.worker_dialogue import (
    WorkerDialogue,
)
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.source_text import Source
from colcon_yamllaunch.plan.plan import DEFAULT_SIGKILL_TIMEOUT
from colcon_yamllaunch.plan.plan import DEFAULT_SIGTERM_TIMEOUT
from colcon_yamllaunch.plan.plan import Process
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
    Let the host do what is left to be done when all is read.

    :param path: The outermost launch file
    """
    if walk.dialogue is not None and walk.dialogue.goes_on:
        start = Position(path, 1, 1)
        try:
            ask_worker(walk, {'do': 'finish'}, start)
        except NotTakenOverError as e:
            walk.report(error(str(e.reason), start))
        except LaunchError as e:
            walk.report(e)
        except (AlreadyReportedError, EndlessError):
            pass


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


def declared_arguments(
    walk: Walk, path: str, origin: Span
) -> Iterable[DeclaredArgument] | None:
    """
    Return what a launch file in Python and all that it includes declares.

    Where nothing may be run, it is what stands in the file. None when that is
    nothing, or the host cannot tell.

    :param origin: Where it is included, else its start
    :raises LaunchError: when the host says that the file has mistakes
    """
    start = Position(walk.source_path(path), 1, 1)
    if walk.open_worker is None:
        return list(written_arguments(start.path)) or None
    if walk.dialogue is not None:
        walk.dialogue.declared.clear()
    try:
        visit_in_python(walk, 'arguments', path, origin)
    except NotTakenOverError:
        return None
    assert walk.dialogue is not None
    return [
        DeclaredArgument(
            name,
            position_of(said, start, walk),
            said.get('description') or None,
            said.get('default'),
            tuple(map(str, said.get('choices') or ())),
            said.get('conditional') is True,
        )
        for name, said in walk.dialogue.declared.items()
    ]


#: The program that runs them.
LAUNCHER = 'ros2'
#: The package that has it, which a workspace with all of ROS 2 builds.
LAUNCHER_PACKAGE = 'ros2cli'


def launch_in_python(walk: Walk, path: str, origin: Span) -> bool:
    """
    Do what a launch file in Python says, or else have ROS 2's launcher run it.

    Return whether it is a part of the plan.

    :param path: The launch file
    :param origin: Where it is included, else its start
    :raises LaunchError: when the launch cannot go on
    """
    draft, findings = walk.draft.snapshot(), walk.snapshot()
    try:
        visit_in_python(walk, 'visit', path, origin)
    except NotTakenOverError as e:
        walk.draft.restore(draft)
        walk.restore(findings)
        if e.reason is not None:
            name = os.path.basename(path)
            walk.warn(
                f"'{name}' is run by '{LAUNCHER} launch', as one process: "
                f'{e.reason}',
                origin,
            )
        walk.may_have_others = True
        add_python_launch(walk, path, origin)
        return False
    return True


def add_python_launch(walk: Walk, path: str, origin: Span) -> None:
    """
    Run a launch file in Python as a process of its own.

    It sees what it would see in ROS 2: the environment, all launch
    configurations of the scope, and its namespace, which ROS 2 keeps as the
    launch configuration `ros_namespace`.

    :param path: The launch file
    :param origin: Where it is included, else its start
    :raises LaunchError: when ROS 2's launcher is not there
    """
    program = shutil.which(LAUNCHER, path=walk.search_path())
    if program is None:
        raise error(
            f"a launch file in Python is run by '{LAUNCHER} launch', and "
            f"there is no '{LAUNCHER}' on the PATH",
            origin,
            hint='source a ROS 2 installation that has it, or write the '
            'launch file in YAML or XML, which need none',
            may_pass_after_build=LAUNCHER_PACKAGE in walk.packages.names(),
        )
    _warn_of_lost_changes(walk, origin)
    arguments = _arguments(walk, origin)
    name = walk.draft.process_name(os.path.basename(path))
    walk.draft.entries.append(
        Process(
            label=name,
            argv=(LAUNCHER, 'launch', path, *arguments),
            cwd=walk.cwd,
            position=origin.position,
            name=name,
            environment=environment_changes(
                walk.environment, walk.scope.environment
            ),
            sigterm_timeout=general_timeout(
                walk, 'sigterm_timeout', DEFAULT_SIGTERM_TIMEOUT
            ),
            sigkill_timeout=general_timeout(
                walk, 'sigkill_timeout', DEFAULT_SIGKILL_TIMEOUT
            ),
            block=walk.draft.block,
        )
    )


def _arguments(walk: Walk, origin: Span) -> list[str]:
    values = walk.scope.configurations.all()
    if walk.scope.namespace is not None:
        values['ros_namespace'] = walk.scope.namespace
    for name, value in values.items():
        if value.text == '':
            walk.warn(
                f"the launch configuration '{name}' is empty; the launch file "
                'in Python gets none, and uses its own default',
                origin,
                f"'{LAUNCHER} launch' takes no empty values",
            )
    return [f'{n}:={value.text}' for n, value in values.items() if value.text]


def _warn_of_lost_changes(walk: Walk, origin: Span) -> None:
    for action, changes in (
        ('set_parameter', walk.scope.parameters),
        ('set_remap', walk.scope.remaps),
    ):
        if changes:
            walk.warn(
                f"what '{action}' has set does not reach the nodes of a "
                f"launch file in Python that '{LAUNCHER} launch' runs",
                origin,
                'pass it as a launch argument, or write the launch file '
                'in YAML or XML',
            )
