# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The visit of a launch description: requests, scopes and arguments."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
import contextlib
import importlib
import os
import sys
import threading
from typing import Any, TYPE_CHECKING

from .channel import Json
from .descriptions import as_json, as_written
from .errors import (
    ArgumentError,
    described,
    Failed,
    frame_of,
    frames_of_thread,
    no_action,
    note_entity,
    plainly_described,
    VisitRefused,
)
from .packages import Packages
from .positions import Positions

if TYPE_CHECKING:
    from .channel import Channel


class Marker:
    """
    Stands among entities for something to be done when its turn comes.

    :param do: What to do
    """

    def __init__(self, do: Callable[[], object]) -> None:
        self._do = do

    def visit(self, context: object) -> None:  # noqa: ARG002 - launch calls it
        """Do it."""
        self._do()

    def get_asyncio_future(self) -> None:
        """Return nothing, as it is done at once."""


def declared_arguments(description: Any) -> list[tuple[Any, Any]]:
    """Return the arguments that are declared, with the includes of each."""
    name = 'get_launch_arguments_with_include_launch_description_actions'
    return list(getattr(description, name)())


class Visitor:
    """
    Visits entities, and tells the launcher what they come to.

    What a request is about, and what replaces the actions of ROS 2, comes
    from other modules: they put it into `requests`, `before_done` and
    `forget`, and patch the classes of `launch`.
    """

    def __init__(self, channel: Channel) -> None:
        self.channel = channel
        #: The launch context, one for all requests.
        self.context: Any = None
        self.scopes: Any = None
        self.positions = Positions()
        self.packages = Packages(self)
        #: Does what a request asks for, by its `do`.
        self.requests: dict[str, Callable[[Json], object]] = {
            'start': self._start,
            'visit': self._visit_file,
            'arguments': lambda request: _report_arguments(self, request),
        }
        #: Called before a `done` without error, such as to tell `handlers`.
        self.before_done: list[Callable[[], object]] = []
        #: Says whether siblings are left to a time that is still to come.
        self.postpone: Callable[[Sequence[Any]], bool] = lambda _: False
        #: Called when a new round of evaluation begins.
        self.forget: list[Callable[[], object]] = []
        #: The actions of processes by their `id`.
        self.started: dict[int, Any] = {}
        #: The working directory of the launch.
        self.folder = os.getcwd()
        #: Whether the launch runs, and all files have been read.
        self.is_running = False
        #: The entity that is being visited.
        self.entity: Any = None
        #: What `launch` logged as errors: it raises most of them as well.
        self.logged: list[tuple[str, str]] = []
        self._last_id = 0
        self._depth = 0
        self._refusal: str | None = None
        #: What the command line gives, if the launcher says so.
        self._given: list[str] | None = None
        #: Whether YAML and XML files are read here, to list their arguments.
        self.reads_frontends = False
        channel.where = self._where

    def run(self) -> None:
        """Do requests, as long as this program lives."""
        while True:
            self.serve(self.channel.receive())

    def serve(self, request: Json) -> None:
        """Do a request and answer it with `done`."""
        number = request.get('id')
        entity, otherwise = self.entity, self.positions.otherwise
        undo = self._undo(request['do'])
        is_outermost = self._depth == 0
        if is_outermost:
            self._refusal = None
        self._depth += 1
        try:
            if 'scope' in request:
                self.scopes.enter(request['scope'])
            self.requests[request['do']](request)
            if self._refusal is not None:
                raise VisitRefused(self._refusal)
            for call in self.before_done:
                call()
            scope = self.scopes.current() if self.scopes else {}
        except VisitRefused as e:
            undo()
            self.say('done', id=number, refused=str(e))
        except Failed:
            undo()
            self.say('done', id=number, failed=True)
        except BaseException as e:  # noqa: BLE001 - anything of the user's
            undo()
            if self._refusal is not None:
                self.say('done', id=number, refused=self._refusal)
            else:
                try:
                    error = described(e, self.positions, self.packages)
                except Exception:  # noqa: BLE001 - its text may be anyone's
                    error = plainly_described(e, self.positions)
                self.say('done', id=number, error=error)
        else:
            self.say('done', id=number, scope=scope)
        finally:
            self._depth -= 1
            self.entity, self.positions.otherwise = entity, otherwise

    def _where(self) -> list[Json]:
        """Return what is being done, from another thread."""
        main = threading.main_thread().ident
        assert main is not None
        frames = frames_of_thread(main, self.positions)
        if frames:
            return frames
        return [frame_of(self.entity, self.positions)] if self.entity else []

    def say(self, what: str, **fields: Any) -> None:
        """Send a message, after what was logged before it."""
        logged, self.logged = self.logged, []
        if what != 'done' or 'scope' in fields:
            for level, text in logged:
                self.channel.say('message', level=level, text=text)
        self.channel.say(what, **fields)

    def marker(self, what: str, **fields: Any) -> Marker:
        """Return what says something when its turn comes."""
        return Marker(lambda: self.say(what, **fields))

    def ask(self, what: str, **fields: Any) -> Json:
        """Ask the launcher, and do what it asks for before it answers."""
        return self.channel.ask(what, self.serve, **fields)

    def visit(self, entity: Any) -> None:
        """
        Visit an entity and what comes of it, as `ros2 launch` does.

        :raises PlainError: when what comes of it is no action
        :raises VisitRefused: when it needs the loop of `ros2 launch`
        """
        outer = self.entity
        self.entity = entity
        try:
            children = entity.visit(self.context)
            future = entity.get_asyncio_future()
            if hasattr(future, 'get_loop') and not future.done():
                self.refuse('goes on in the event loop')
            children = () if children is None else tuple(children)
        except Exception as e:
            note_entity(e, entity)
            raise
        finally:
            self.entity = outer
        for index, child in enumerate(children):
            if not hasattr(child, 'visit'):
                raise no_action(child, self.positions.of(child, entity))
            self.positions.pass_on(entity, child)
            if self.postpone(children[index:]):
                break
            self.visit(child)

    def position(self, made: object = None) -> list[object] | None:
        """Return the position of an object, or of what is being visited."""
        return self.positions.of(made, self.entity)

    def here(self) -> list[object] | None:
        """Return the position of the user's code that runs, or the same."""
        return self.positions.here() or self.position()

    def new_id(self, started: object) -> int:
        """Return an `id` for the action of a process."""
        self._last_id += 1
        self.started[self._last_id] = started
        return self._last_id

    def text_of(self, substitutions: Any) -> str:
        """Return what a text with substitutions, or a plain one, comes to."""
        utilities = importlib.import_module('launch.utilities')
        normalized = utilities.normalize_to_list_of_substitutions(
            substitutions
        )
        text = utilities.perform_substitutions(self.context, normalized)
        assert isinstance(text, str)
        return text

    def refuse(self, why: str) -> None:
        """
        Request that `ros2 launch` runs the file.

        :param why: What the entity that is visited does
        :raises VisitRefused: always, before the launch runs
        :raises RuntimeError: when it runs, so that it is too late
        """
        name = type(self.entity).__name__
        if self.is_running:
            raise RuntimeError(
                f"{name} {why} of 'ros2 launch', which cannot take over a "
                "launch that runs: run the launch file with 'ros2 launch'"
            )
        place = ''
        position = self.position()
        if position is not None:
            file = os.path.basename(str(position[0]))
            place = f' ({file}:{position[1]})'
        self._refusal = f"{name}{place} {why} of 'ros2 launch'"
        raise VisitRefused(self._refusal)

    def _start(self, request: Json) -> None:
        log: Any = importlib.import_module('launch.logging')
        # not by its setter: the folder is made later, or in a look never
        log.launch_config._log_dir = request.get('log_folder')
        self._given = request.get('arguments')
        packages = request.get('packages') or {}
        self.packages.set(packages)
        os.chdir(self.folder)
        self.positions.set_prefixes(self.packages.prefixes.values())
        self.positions.forget()
        self.started.clear()
        self.renew_context()
        for call in self.forget:
            call()

    def _visit_file(self, request: Json) -> None:
        path = request['path']
        self.positions.otherwise = [path, 1, 1]
        given = self._given
        if given is None:
            pairs = self.context.launch_configurations.items()
            given = [f'{n}:={v}' for n, v in pairs if isinstance(v, str)]
        # some launch files look for what was given there
        sys.argv[:] = ['ros2', 'launch', path, *given]
        if self._depth == 1:
            self.packages.begin()
            self.context._LaunchContext__argv = given
        description = self.description(path)
        self._check_arguments(description)
        self.within_file(path, description)

    def _check_arguments(self, description: Any) -> None:
        """
        Check for required arguments that are not given.

        :raises ArgumentError: for the first of them
        """
        given = set(self.context.launch_configurations)
        for argument, includes in declared_arguments(description):
            has_default = argument.default_value is not None
            if has_default or argument._conditionally_included:
                continue
            for include in includes or ():
                names = include._try_get_arguments_names_without_context()
                given.update(names or ())
            if argument.name not in given:
                error = ArgumentError(argument.name)
                note_entity(error, argument)
                raise error

    def description(self, path: str) -> Any:
        """
        Return the description that a launch file in Python generates.

        :raises PlainError: when there is none
        """
        sources = importlib.import_module('launch.launch_description_sources')
        source = sources.PythonLaunchDescriptionSource(path)
        return source.get_launch_description(self.context)

    def within_file(self, path: str, description: Any) -> None:
        """Visit the description of a file; afterwards it is another's turn."""
        with self.file(path):
            self.visit(description)

    @contextlib.contextmanager
    def file(self, path: str) -> Iterator[None]:
        """Be in a launch file for the time of the context."""
        self.context._push_locals()
        try:
            self.enter_file(path)
            yield
        finally:
            self.context._pop_locals()

    def enter_file(self, path: str) -> None:
        """Make a file the current one."""
        path = os.path.abspath(path)
        self.context.extend_locals(
            {
                'current_launch_file_path': path,
                'current_launch_file_directory': os.path.dirname(path),
            }
        )

    def renew_context(self) -> None:
        """Make a launch context, in the environment of this program."""
        if self.scopes is not None:
            # it is what the context resets to
            self.scopes.restore()
        launch = importlib.import_module('launch')
        self.context = launch.LaunchContext()
        self.scopes = Scopes(self.context)
        self.context._set_asyncio_loop(_Loop(self))

    def _undo(self, do: str) -> Callable[[], None]:
        """Return what undoes a request, as far as others would notice."""
        if self.context is None or do in ('event', 'call'):
            # what happened, happened
            return lambda: None
        handlers = list(self.context._event_handlers)
        queue = self.context._event_queue
        events, last_id = queue.copy(), self._last_id

        def undo() -> None:
            self.context._event_handlers.clear()
            self.context._event_handlers.extend(handlers)
            queue.restore(events)
            for number in [n for n in self.started if n > last_id]:
                del self.started[number]

        return undo


class _Loop:
    """Stands where the event loop of `ros2 launch` is, which is not there."""

    def __init__(self, visitor: Visitor) -> None:
        self._visitor = visitor

    def __getattr__(self, name: str) -> Any:
        self._visitor.refuse('needs the event loop')


#: What launch_ros keeps among the launch configurations.
NAMESPACE = 'ros_namespace'
PARAMETERS = 'global_params'
REMAPS = 'ros_remaps'
#: The variable with which `launch` counts processes.
_COUNTER = '_executable_process_counter'


class Scopes:
    """
    Puts scopes into the context of `launch`, and reads them from there.

    :param context: The launch context
    """

    def __init__(self, context: Any) -> None:
        self._context = context
        self._environment = dict(os.environ)
        #: Whether SetUseSimTime said so; ROS 2 has one for the whole launch.
        self.uses_sim_time = False

    def enter(self, scope: Json) -> None:
        """Set the scope of the context."""
        configurations = self._context.launch_configurations
        others = {
            name: value
            for name, value in configurations.items()
            if not isinstance(value, str)
            and name not in (NAMESPACE, PARAMETERS, REMAPS)
        }
        configurations.clear()
        configurations.update(others)
        configurations.update(scope.get('configurations') or {})
        if scope.get('namespace') is not None:
            configurations[NAMESPACE] = scope['namespace']
        if scope.get('parameters'):
            configurations[PARAMETERS] = [
                one['file'] if 'file' in one else (one['name'], one['value'])
                for one in scope['parameters']
            ]
        if scope.get('remaps'):
            configurations[REMAPS] = [(a, b) for a, b in scope['remaps']]
        self.uses_sim_time = bool(scope.get('uses_sim_time'))
        if 'processes' in scope:
            # ROS 2 counts all processes of a launch
            module = importlib.import_module('launch.descriptions.executable')
            setattr(module, _COUNTER, scope['processes'])
        wanted = dict(self._environment)
        for name, value in (scope.get('environment') or {}).items():
            if value is None:
                wanted.pop(name, None)
            else:
                wanted[name] = value
        set_environment(wanted)

    def restore(self) -> None:
        """Restore the environment of this program."""
        set_environment(self._environment)

    def current(self) -> Json:
        """Return the scope that the context is in."""
        configurations = self._context.launch_configurations
        return {
            'configurations': {
                name: value
                for name, value in configurations.items()
                if isinstance(name, str)
                and isinstance(value, str)
                and name != NAMESPACE
            },
            'environment': self.changes(os.environ),
            'namespace': configurations.get(NAMESPACE),
            'parameters': [
                {'name': str(one[0]), 'value': as_json(one[1])}
                if isinstance(one, tuple)
                else {'file': os.path.abspath(one)}
                for one in configurations.get(PARAMETERS) or ()
            ],
            'remaps': [
                [str(old), str(new)]
                for old, new in configurations.get(REMAPS) or ()
            ],
            'uses_sim_time': self.uses_sim_time,
        }

    def changes(self, variables: Any) -> Json:
        """Return the variables that differ from those of this program."""
        changed: Json = {
            name: value
            for name, value in variables.items()
            if self._environment.get(name) != value
        }
        for name in self._environment:
            if name not in variables:
                changed[name] = None
        return changed


def set_environment(wanted: dict[str, str]) -> None:
    """Replace the environment variables."""
    for name in set(os.environ) - set(wanted):
        del os.environ[name]
    for name, value in wanted.items():
        if os.environ.get(name) != value:
            os.environ[name] = value


def _report_arguments(visitor: Visitor, request: Json) -> None:
    """Report the launch arguments of a file and of what it includes."""
    path = request['path']
    visitor.positions.otherwise = [path, 1, 1]
    visitor.reads_frontends = True
    try:
        arguments = declared_arguments(visitor.description(path))
    finally:
        visitor.reads_frontends = False
    for argument, includes in arguments:
        default = argument.default_value
        choices = argument.choices
        # one that is declared in YAML or XML has none
        position = visitor.positions.of(argument, *(includes or ()))
        visitor.say(
            'argument',
            name=argument.name,
            default=None if default is None else as_written(default),
            description=_description(argument),
            choices=None if choices is None else [str(c) for c in choices],
            conditional=bool(argument._conditionally_included),
            position=position,
            file=os.path.abspath(str(position[0] if position else path)),
        )


def _description(argument: Any) -> str:
    """Return a description without what `launch` adds to it."""
    text = str(argument.description or '')
    if text == 'no description given':
        return ''
    if argument.choices is not None:
        choices = str(argument.choices)
        if text == f'One of: {choices}':
            return ''
        end = f' Valid choices are: {choices}'
        if text.endswith(end):
            text = text[: -len(end)]
    return text
