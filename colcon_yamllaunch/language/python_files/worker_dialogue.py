# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The requests to the worker for Python launch files, and its answers.

An answer is a series of messages, which become entries of the plan in their
order. `python_launch/worker/channel.py` lists the messages.
"""

from collections.abc import Iterable, Mapping
from contextlib import ExitStack
from dataclasses import replace
from functools import lru_cache
import math
import os
from pathlib import Path
from typing import Any

from colcon_yamllaunch.common.files import text_of
from colcon_yamllaunch.language.actions.process_actions import through_shell
from colcon_yamllaunch.language.evaluation.budget import EndlessError
from colcon_yamllaunch.language.evaluation.findings import (
    ExecutableUse,
    PluginUse,
)
from colcon_yamllaunch.language.evaluation.request import (
    LaunchWorker,
    WorkerMessage,
)
from colcon_yamllaunch.language.evaluation.scope import AlreadyReportedError
from colcon_yamllaunch.language.evaluation.walk import Walk
from colcon_yamllaunch.language.python_files.worker_scope import (
    apply_scope,
    content,
    scope_as_json,
)
from colcon_yamllaunch.language.syntax.diagnostics import error, LaunchError
from colcon_yamllaunch.language.syntax.source_text import Source
from colcon_yamllaunch.language.vocabulary.parameter import Parameter
from colcon_yamllaunch.plan.plan import (
    ChangeState,
    Component,
    Entry,
    EvaluatedCondition,
    EventHandler,
    Message,
    OUTPUT_MODES,
    ParameterFile,
    Process,
    SetParameter,
    Shutdown,
    SignalProcess,
    Timer,
    WorkerCall,
)
from colcon_yamllaunch.plan.position import Position, Span

#: How many lines of a call are searched for a text.
MAXIMUM_CALL_LINES = 40


class WorkerDialogue:
    """
    All that a walk asks the worker.

    :param walk: What is done with the launch files
    :param worker: The worker, which forgets what it knew before
    """

    def __init__(self, walk: Walk, worker: LaunchWorker) -> None:
        self.walk = walk
        self.worker = worker
        self._requests = 0
        #: The ends of other answers that came while one was waited for.
        self.passed: list[WorkerMessage] = []
        #: What ROS 2 calls the processes that the worker knows by a number.
        self.names: dict[int, str] = {}
        #: The same the other way round.
        self.ids: dict[str, int] = {}
        self._handlers: list[WorkerMessage] = []
        #: Whether there are event handlers.
        self.has_handlers = False
        self._outputs: list[int] = []
        #: The launch arguments that are declared.
        self.declared: dict[str, WorkerMessage] = {}
        #: The blocks in which something was left to be called.
        self.calls: dict[int, int | None] = {}
        packages = walk.packages
        self.send(
            {
                'do': 'start',
                'log_folder': walk.log_folder or '',
                'arguments': [
                    f'{name}:={value.text}'
                    for name, value in walk.given.items()
                ],
                'packages': {
                    name: {
                        'prefix': prefix,
                        'built': os.path.isdir(
                            os.path.join(prefix, 'share', name)
                        ),
                    }
                    for name in packages.own_names()
                    if (prefix := packages.prefix(name)) is not None
                },
            }
        )

    def send(self, request: Mapping[str, Any]) -> int:
        """
        Send a request, and return its number.

        :raises WorkerError: when there is no worker
        """
        self._requests += 1
        self.worker.send({**request, 'id': self._requests})
        return self._requests

    def ask(self, request: Mapping[str, Any], origin: Span) -> WorkerMessage:
        """
        Ask for something in the scope that there is, and do what it says.

        :param origin: What asks for it
        :return: The end of the answer, with the text of a `value` if it had
          one; the scope is taken over
        :raises WorkerError: when there is no worker, or it does not answer
        :raises LaunchError: when the launch cannot go on
        """
        number = self.send({**request, 'scope': scope_as_json(self.walk)})
        with Intake(self, origin) as intake:
            while True:
                message = self.worker.receive()
                if message.get('say') == 'done':
                    if message.get('id') == number:
                        break
                    self.passed.append(message)
                    continue
                intake.receive(message)
        intake.finish()
        if 'scope' in message:
            apply_scope(self.walk, message['scope'], origin)
        return {**message, 'value': intake.value}

    @property
    def goes_on(self) -> bool:
        """Whether there is something left to be asked while the plan runs."""
        return bool(self.has_handlers or self.calls)

    @property
    def handlers(self) -> tuple[EventHandler, ...]:
        """The event handlers that there are."""
        return tuple(
            EventHandler(
                said['event'],
                tuple(
                    self.names.get(who, f'process {who}')
                    if isinstance(who, int)
                    else str(who)
                    for who in said.get('processes') or ()
                ),
                said.get('condition') or '',
                tuple(map(str, said.get('actions', ()))),
                position_of(said, Position('', 1, 1), self.walk),
            )
            for said in self._handlers
        )

    @property
    def wants_output(self) -> frozenset[str]:
        """What ROS 2 calls the processes whose output the worker wants."""
        return frozenset(
            self.names[who] for who in self._outputs if who in self.names
        )

    def note_handlers(self, said: WorkerMessage) -> None:
        """Record the current event handlers."""
        handlers = said['handlers']
        self.has_handlers = bool(handlers)
        if isinstance(handlers, list):
            self._handlers = handlers
        self._outputs = list(said.get('output', ()))

    def forget_handlers(self) -> None:
        """Record that no event handlers are left."""
        self.has_handlers, self._outputs = False, []


class Intake:
    """
    The messages of one answer, which become entries of the plan.

    :param origin: What has asked
    """

    def __init__(self, dialogue: WorkerDialogue, origin: Span) -> None:
        self._dialogue = dialogue
        self._walk = dialogue.walk
        self._origin = origin
        self._open: list[tuple[WorkerMessage, ExitStack, list[Entry]]] = []
        self._failure: Exception | None = None
        # that of the last message, or else what has asked
        self._position = origin.position
        #: The text that was asked for.
        self.value: str | None = None

    def __enter__(self) -> 'Intake':
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Leave the files, groups and timers that were not ended."""
        while self._open:
            self._open.pop()[1].close()

    def finish(self) -> None:
        """
        Raise the error that occurred, if any.

        :raises LaunchError: when it was an error
        :raises EndlessError: when the launch would hardly ever end
        """
        if self._failure is not None:
            raise self._failure

    def receive(self, message: WorkerMessage) -> None:
        """
        Do what a message says.

        :raises WorkerError: when there is no worker any more
        """
        if self._failure is not None:
            # what is asked must be answered all the same
            if 'ask' in message:
                self._answer(message, {'failed': True})
            return
        # the messages are listed in `python_launch/worker/channel.py`
        receive = getattr(self, f'_on_{message.get("say")}', None)
        if receive is None:
            return
        origin = self._origin.position
        self._position = position_of(message, origin, self._walk)
        try:
            self._walk.budget.count_action(self._position)
            _check_seconds(message, self._position)
            receive(message)
        except (LaunchError, AlreadyReportedError, EndlessError) as e:
            self._failure = e
            if 'ask' in message:
                self._answer(message, {'failed': True})

    def _answer(
        self, message: WorkerMessage, answer: Mapping[str, Any]
    ) -> None:
        self._dialogue.worker.send({'answer': message['ask'], **answer})

    def _on_begin(self, message: WorkerMessage) -> None:
        draft = self._walk.draft
        kind, title = message['kind'], message.get('title') or ''
        stack = ExitStack()
        entries: list[Entry] = []
        if kind in ('timer', 'settled'):
            entries = stack.enter_context(draft.collect())
        if kind == 'timer':
            title = title or f'{message["period"]:g} s'
        if kind != 'settled':
            stack.enter_context(
                draft.within_block(kind, title, self._position)
            )
        if kind == 'file':
            source = Source(title, title, '')
            stack.enter_context(self._walk.within(source, self._position))
        self._open.append((message, stack, entries))

    def _on_end(self, message: WorkerMessage) -> None:
        begun, stack, entries = self._open.pop()
        if message.get('title'):
            self._walk.draft.name_block(message['title'])
        stack.close()
        if begun['kind'] == 'timer':
            self._add(
                Timer(
                    float(begun.get('period') or 0.0),
                    tuple(entries),
                    begun.get('cancel_on_shutdown') is not False,
                    begun.get('on_ros_time') is True,
                )
            )
        elif begun['kind'] == 'settled':
            number = begun['number']
            self._dialogue.calls.pop(number, None)
            draft = self._walk.draft
            draft.entries[:] = _without_call(draft.entries, number, entries)

    def _add(self, entry: Entry) -> None:
        self._walk.draft.entries.append(entry)

    def _on_process(self, message: WorkerMessage) -> None:
        walk = self._walk
        name = walk.draft.process_name(message['program'])
        self._dialogue.names[message['id']] = name
        self._dialogue.ids[name] = message['id']
        node = message.get('node')
        is_container = message.get('is_container') is True
        output = message.get('output')
        argv = [
            one
            if isinstance(one, str)
            else ParameterFile(
                one['content'], self._as_set(one.get('parameters'))
            )
            for one in message['argv']
        ]
        self._add(
            Process(
                label=name,
                argv=tuple(
                    through_shell(argv) if message.get('shell') else argv
                ),
                cwd=os.path.normpath(
                    os.path.join(walk.cwd, message.get('cwd') or '')
                ),
                position=self._position,
                name=name,
                environment=tuple(
                    sorted(
                        (n, v)
                        for n, v in message.get('environment', {}).items()
                        if walk.environment.get(n) != v
                    )
                ),
                output=output if output in OUTPUT_MODES else 'both',
                package=message.get('package'),
                node_name=node,
                parameters=self._as_set(message.get('parameters')),
                block=walk.draft.block,
                is_container=is_container,
                **{n: message[n] for n in _PROCESS_FIELDS if n in message},
            )
        )
        if node is not None:
            walk.note_node(node, self._position)
        elif is_container:
            walk.may_have_others = True

    def _as_set(
        self, said: list[WorkerMessage] | None
    ) -> tuple[SetParameter, ...]:
        return tuple(p.as_set() for p in self._parameters(said))

    def _parameters(self, said: list[WorkerMessage] | None) -> list[Parameter]:
        """Return parameters; one without a position is at its node."""
        return [
            Parameter(
                one['name'],
                value,
                position_of(one, self._position, self._walk),
            )
            for one in said or ()
            if (value := content(one['value'])) not in (None, ())
        ]

    def _on_component(self, message: WorkerMessage) -> None:
        walk = self._walk
        package, plugin = message['package'], message['plugin']
        container = message['container']
        walk.plugins.append(
            PluginUse(
                package,
                plugin,
                written_at(plugin, self._position),
                written_at(package, self._position),
            )
        )
        if not walk.never:
            walk.targets.append((container, walk.place_of(self._position)))
        parameters = self._parameters(message['parameters'])
        extra = self._parameters(message.get('extra_arguments'))
        component = Component(
            label=walk.draft.component_label(plugin),
            package=package,
            plugin=plugin,
            container=container,
            position=self._position,
            name=message.get('name') or '',
            namespace=message.get('namespace') or '',
            remaps=tuple(map(str, message.get('remaps', ()))),
            parameters=tuple(p.as_json() for p in parameters),
            extra_arguments=tuple(p.as_json() for p in extra),
            block=walk.draft.block,
            is_lifecycle=message.get('is_lifecycle') is True,
            autostart=message.get('autostart') is True,
        )
        self._add(component)
        if component.node_name is not None:
            walk.note_node(component.node_name, self._position)

    def _on_message(self, message: WorkerMessage) -> None:
        self._add(Message(message['level'], message['text']))

    def _on_shutdown(self, message: WorkerMessage) -> None:
        self._add(Shutdown(message.get('reason') or ''))

    def _on_change_state(self, message: WorkerMessage) -> None:
        node, transition = message['node'], message['transition']
        self._add(ChangeState(node, transition, self._position))

    def _on_signal(self, message: WorkerMessage) -> None:
        name = self._dialogue.names.get(message['process'])
        if name is not None:
            self._add(SignalProcess(name, message['signal'], self._position))

    def _on_call(self, message: WorkerMessage) -> None:
        number, title = message['number'], message['title']
        self._dialogue.calls[number] = self._walk.draft.block
        self._add(WorkerCall(number, title, self._position))

    def _on_condition(self, message: WorkerMessage) -> None:
        self._walk.draft.conditions.append(
            EvaluatedCondition(
                message['text'],
                message['taken'] is True,
                self._position,
            )
        )

    def _on_package(self, message: WorkerMessage) -> None:
        name = message['name']
        if self._walk.packages.prefix(name) is not None:
            position = written_at(name, self._position)
            self._walk.use_package(name, position)

    def _on_executable(self, message: WorkerMessage) -> None:
        name = message['name']
        self._walk.executables.append(
            ExecutableUse(
                message['package'],
                name,
                message['path'],
                written_at(name, self._position),
            )
        )

    def _on_file(self, message: WorkerMessage) -> None:
        path = self._walk.files.source_path(message['path'])
        self._walk.files.note_python(path)

    def _on_read(self, message: WorkerMessage) -> None:
        self._walk.inputs[message['path']] = None

    def _on_warning(self, message: WorkerMessage) -> None:
        self._walk.warn(message['text'], self._position)

    def _on_argument(self, message: WorkerMessage) -> None:
        self._dialogue.declared.setdefault(message['name'], message)

    def _on_value(self, message: WorkerMessage) -> None:
        self.value = message['text']

    def _on_handlers(self, message: WorkerMessage) -> None:
        self._dialogue.note_handlers(message)

    def _on_locate(self, message: WorkerMessage) -> None:
        located = self._walk.packages.locate(message['path'])
        path = None if located is None else located[1]
        self._answer(message, {'path': path})

    def _on_include(self, message: WorkerMessage) -> None:
        """Go through a launch file in YAML or XML that Python includes."""
        walk = self._walk
        path = message['path']
        candidate = walk.absolute(path)
        located = walk.packages.locate(candidate)
        if located is None:
            text, hint = walk.no_launch_file(path, candidate)
            raise error(text, self._position, hint=hint)
        before = walk.error_count()
        with walk.within_scope(walk.scope.inner()):
            apply_scope(walk, message['scope'], self._position)
            walk.visit_included(*located, self._position)
            scope = scope_as_json(walk)
        if walk.error_count() > before:
            self._answer(message, {'failed': True})
        else:
            self._answer(message, {'scope': scope})


def _without_call(
    entries: Iterable[Entry], number: int, instead: list[Entry]
) -> list[Entry]:
    """Return entries with others in the place of a call of the worker."""
    found: list[Entry] = []
    for entry in entries:
        if isinstance(entry, WorkerCall) and entry.number == number:
            found += instead
        elif isinstance(entry, Timer):
            inner = _without_call(entry.entries, number, instead)
            found.append(replace(entry, entries=tuple(inner)))
        else:
            found.append(entry)
    return found


def _check_seconds(message: WorkerMessage, position: Position) -> None:
    """
    Check the times in a message.

    :raises LaunchError: when one of them is no number
    """
    for name in _TIMES:
        value = message.get(name)
        if isinstance(value, float) and math.isnan(value):
            hint = 'it is a number of seconds'
            raise error(f"'{name}' is not a number", position, hint=hint)


def position_of(
    said: WorkerMessage, otherwise: Position, walk: Walk | None = None
) -> Position:
    """
    Return the position in a message.

    :param otherwise: What to take where there is none
    :param walk: Tells the file in a source that is installed there
    """
    match said.get('position'):
        case [str(path), int(line), int(column)]:
            if walk is not None:
                path = walk.files.source_path(path)
            return Position(path, line, column)
    return otherwise


def written_at(text: str, call: Position) -> Position:
    """Return where a text is written within or behind a call, else that."""
    lines = _lines(call.path)[call.line - 1 :][:MAXIMUM_CALL_LINES]
    for number, line in enumerate(lines):
        start = 0 if number else call.column - 1
        for quote in ('"', "'"):
            column = line.find(f'{quote}{text}{quote}', start)
            if column >= 0:
                return Position(call.path, call.line + number, column + 2)
    return call


@lru_cache(maxsize=8)
def _lines(path: str) -> list[str]:
    return text_of(Path(path)).split('\n')


_TIMES = ('period', 'respawn_delay', 'sigterm_timeout', 'sigkill_timeout')
# what is called the same in a process of the plan
_PROCESS_FIELDS = (
    'emulate_tty',
    'respawn',
    'respawn_delay',
    'respawn_max_retries',
    'sigterm_timeout',
    'sigkill_timeout',
    'on_exit_shutdown',
    'is_lifecycle',
    'autostart',
)
