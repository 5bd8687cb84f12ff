# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launch files in Python: their visit, their arguments and their errors."""

from collections.abc import Iterable
import os
import re
import shutil

from colcon_yamllaunch.language.actions.process_actions import general_timeout
from colcon_yamllaunch.language.evaluation.budget import EndlessError
from colcon_yamllaunch.language.evaluation.findings import DeclaredArgument
from colcon_yamllaunch.language.evaluation.request import (
    NoWorkerError,
    WorkerError,
    WorkerMessage,
    WorkerTimeoutError,
)
from colcon_yamllaunch.language.evaluation.scope import (
    AlreadyReportedError,
    environment_changes,
)
from colcon_yamllaunch.language.evaluation.walk import Walk
from colcon_yamllaunch.language.python_files.python_source import (
    named_packages,
    written_arguments,
)
from colcon_yamllaunch.language.python_files.worker_dialogue import (
    position_of,
    WorkerDialogue,
    written_at,
)
from colcon_yamllaunch.language.syntax.diagnostics import (
    Diagnostic,
    error,
    LaunchError,
)
from colcon_yamllaunch.language.syntax.source_text import Source
from colcon_yamllaunch.plan.plan import (
    DEFAULT_SIGKILL_TIMEOUT,
    DEFAULT_SIGTERM_TIMEOUT,
    Process,
)
from colcon_yamllaunch.plan.position import Position, Span

#: The variable with the seconds that the worker may take.
TIMEOUT_VARIABLE = 'COLCON_LAUNCH_PYTHON_TIMEOUT'
# of an exception that no build helps against
_CERTAIN = ('SyntaxError:', 'IndentationError:', 'TabError:')

# what DeclareLaunchArgument says
_NO_CHOICE = re.compile(
    'RuntimeError: Argument "(?P<name>[^"]+)" provided value "(?P<value>.*)" '
    r'is not valid. Valid options are: \[(.*)\]',
    re.DOTALL,
)
_QUOTED = re.compile(r"'([^']*)'|\"([^\"]*)\"")


class MissingArgumentError(LaunchError):
    """A launch argument that has no default is not given."""


def python_error(
    walk: Walk, said: WorkerMessage, start: Position
) -> LaunchError:
    """
    Return the error that the end of an answer tells.

    :param said: Its `error`
    :param start: The start of the launch file
    """
    text, hint = str(said['text']), said.get('hint')
    may_pass = not text.startswith(_CERTAIN) and may_be_built(walk)
    package, argument = said.get('package'), said.get('argument')
    word = argument
    if argument is not None:
        text = f"launch argument '{argument}' is required, and was not given"
        hint = f'give it: {argument}:=…'
        may_pass = False
    elif package is not None and walk.packages.prefix(package) is None:
        text, hint = walk.no_package(package)
        may_pass, word = False, package
    frames = said.get('frames') or ()
    problem = at_frames(
        walk, frames, text, hint, start, may_pass=may_pass, word=word
    )
    if may_pass:
        # what launch files name, so that all of it is built at once
        own = set(walk.packages.own_names())
        for path in walk.files.python:
            for name, position in named_packages(path):
                if name in own:
                    walk.use_package(name, position)
    if package is not None and may_pass:
        walk.use_package(package, problem.diagnostics[0].position or start)
    if argument is not None:
        return MissingArgumentError(*problem.diagnostics)
    return problem


def report_invalid_choice(
    walk: Walk, said: WorkerMessage, start: Position
) -> bool:
    """
    Report an error about a choice where its launch argument was given.

    Return False for other errors, which are not reported.

    :param said: The `error` of an answer
    :param start: The start of the launch file
    """
    found = _NO_CHOICE.match(str(said['text']))
    value = found and walk.scope.configurations.get(found['name'])
    if not found or value is None or value.text != found['value']:
        return False
    at = at_frames(walk, said.get('frames') or (), '', None, start)
    choices = [first or second for first, second in _QUOTED.findall(found[3])]
    place = at.diagnostics[0].position or start
    walk.fail_choice(found['name'], value, choices, place)
    return True


def at_frames(
    walk: Walk,
    frames: 'list[WorkerMessage] | tuple[()]',
    text: str,
    hint: str | None,
    start: Position,
    *,
    may_pass: bool = False,
    word: str | None = None,
) -> LaunchError:
    """
    Return an error at the innermost of some calls in Python.

    :param start: Where it is when there are none
    :param word: What is wrong in that call, if it is known
    """
    positions = [position_of(frame, start, walk) for frame in frames]
    *calls, position = positions or [start]
    length = 1
    if word is not None and written_at(word, position) != position:
        position, length = written_at(word, position), len(word)
    elif frames and frames[-1].get('end_column'):
        length = max(1, int(frames[-1]['end_column']) - position.column)
    return LaunchError(
        Diagnostic(
            'error',
            text,
            position,
            hint,
            length,
            may_pass_after_build=may_pass,
            calls=tuple(reversed(calls)),
        )
    )


def may_be_built(walk: Walk) -> bool:
    """Return whether packages of the workspace may still be built."""
    for name in walk.packages.own_names():
        prefix = walk.packages.prefix(name) or ''
        return walk.packages.may_appear(os.path.join(prefix, 'share', name))
    return False


class NotTakenOverError(Exception):
    """
    A launch file in Python cannot be a part of the plan.

    :param reason: Why, or None when there is no worker
    """

    def __init__(self, reason: str | None) -> None:
        super().__init__()
        self.reason = reason


def visit_in_python(walk: Walk, what: str, path: str, origin: Span) -> None:
    """
    Make the worker read a launch file in Python.

    :param what: What to do with it: `visit` or `arguments`
    :param path: The launch file
    :param origin: Where it is included, else its start
    :raises NotTakenOverError: when there is no worker, or the worker cannot
    :raises LaunchError: when the launch cannot go on
    """
    start = Position(walk.files.source_path(path), 1, 1)
    is_first = not walk.depth
    walk.files.note_python(start.path)
    source = Source(start.path, path, '')
    try:
        with walk.within(source, None if is_first else origin):
            message = _asked(walk, {'do': what, 'path': path}, origin, start)
            if message.get('failed'):
                # it may have set anything
                walk.scope.configurations.is_open = True
            if 'error' in message and report_invalid_choice(
                walk, message['error'], start
            ):
                raise AlreadyReportedError
            _check_end(walk, message, start)
    except LaunchError as e:
        walk.scope.configurations.is_open = True
        raise (
            e if is_first else e.included_from(origin.position)
        ) from e.__cause__


def ask_worker(walk: Walk, request: WorkerMessage, origin: Span) -> str | None:
    """
    Send the worker a request with the current scope, and execute its answer.

    :param request: What it is asked for, without number and scope
    :param origin: What asks for it
    :return: The text of a `value`, if the answer has one
    :raises NotTakenOverError: when there is no worker, or the worker cannot
    :raises LaunchError: when it fails
    """
    message = _asked(walk, request, origin, origin.position)
    _check_end(walk, message, origin.position)
    value = message.get('value')
    return None if value is None else str(value)


def _check_end(walk: Walk, message: WorkerMessage, start: Position) -> None:
    """
    Raise the error that the end of an answer tells, if any.

    :param start: Where the error is if the answer does not say it
    :raises NotTakenOverError: when the worker cannot do what it was asked for
    :raises LaunchError: when it fails
    :raises AlreadyReportedError: when it fails, and the user was told why
    """
    if 'error' in message:
        raise python_error(walk, message['error'], start)
    if 'refused' in message:
        raise NotTakenOverError(str(message['refused']))
    if message.get('failed'):
        raise AlreadyReportedError


def finish(walk: Walk, path: str) -> None:
    """
    Make the worker finish when all files are read.

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
    Ask the worker.

    :param start: The start of the launch file that it is about
    :raises NotTakenOverError: when there is none
    :raises LaunchError: when the launch cannot go on
    """
    if walk.open_worker is None:
        raise NotTakenOverError(None)
    worker = walk.open_worker()
    try:
        if walk.dialogue is None:
            walk.dialogue = WorkerDialogue(walk, worker)
        return walk.dialogue.ask(request, origin)
    except NoWorkerError as e:
        raise NotTakenOverError(None) from e
    except WorkerTimeoutError as e:
        frames = worker.doing().get('frames') or ()
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
    nothing, or the worker cannot tell.

    :param origin: Where it is included, else its start
    :raises LaunchError: when the worker says that the file has mistakes
    """
    start = Position(walk.files.source_path(path), 1, 1)
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
    arguments = [f'{n}:={v.text}' for n, v in values.items() if v.text]
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
