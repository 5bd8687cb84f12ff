# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A plan for people to read."""

from collections.abc import Iterable, Iterator, Mapping
import shlex
import signal

from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.plan.member_settings import MemberSettings
from colcon_yamllaunch.plan.member_settings_text import settings_as_text
from colcon_yamllaunch.plan.plan import (
    AfterReady,
    ChangeState,
    Component,
    Entry,
    EventHandler,
    Message,
    ParametersOf,
    Plan,
    Process,
    SetParameter,
    Shutdown,
    SignalProcess,
    Timer,
    UNLIMITED_RETRIES,
    Variables,
    WorkerCall,
)
from colcon_yamllaunch.plan.position import shown_position
from colcon_yamllaunch.plan.start_order import (
    cycle_in,
    dependencies_of,
    stages_of,
)

_INDENT = '    '
#: Who does what when an event handler acts, by the event.
_OCCASIONS = {
    'start': ('a process', 'starts'),
    'exit': ('a process', 'ends'),
    'output': ('a process', 'writes something'),
    'complete': ('something', 'is done'),
    'shutdown': ('the launch', 'ends'),
    'state': ('a lifecycle node', 'changes its state'),
}


def plan_to_text(
    plan: Plan,
    cwd: str,
    setup: str | None = None,
    machines: Mapping[str, str] | None = None,
    parameters_of: ParametersOf = lambda process: process.parameters,
) -> str:
    """
    Describe what a plan would do, in order.

    Each command can be pasted into bash, in a shell that has sourced the
    workspace; how, stands first. That of a component loads it into its
    container once that runs.

    :param cwd: The folder that paths are shown relative to
    :param setup: The setup script of the workspace, if there is one
    :param machines: The machines of what runs elsewhere, by its label
    :param parameters_of: Returns the parameters of a process
    """
    machines = machines or {}

    def inner_lines(entry: Timer | AfterReady) -> Iterator[str]:
        for inner in entry.entries:
            yield from (_INDENT + line for line in described(inner))

    def described(entry: Entry) -> Iterator[str]:
        match entry:
            case Process():
                lines = process_as_text(entry, cwd, parameters_of)
            case Component():
                lines = _component_as_text(entry, cwd)
            case Timer():
                clock = ' on /clock' if entry.on_ros_time else ''
                yield f'after {entry.period:g} s{clock}:'
                yield from inner_lines(entry)
                return
            case AfterReady():
                are = 'is' if len(entry.labels) == 1 else 'are'
                yield f'once {", ".join(entry.labels)} {are} ready:'
                yield from inner_lines(entry)
                return
            case _:
                yield _step_as_text(entry, cwd)
                return
        yield next(lines)
        if entry.label in machines:
            yield f'{_INDENT}machine: {machines[entry.label]}'
        yield from lines

    lines = [one_line(text) for e in plan.entries for text in described(e)]
    for handler in plan.handlers:
        lines += map(one_line, _handler_as_text(handler, cwd))
    if not lines:
        lines = ['nothing would run']
    if setup is not None and any(True for _ in plan.processes()):
        lines = [
            'before you paste a command, source the workspace in that shell:',
            f'{_INDENT}. {quoted(setup)}',
            '',
            *lines,
        ]
    lines += map(one_line, _stages_as_text(plan))
    if plan.conditions:
        lines += ['', 'conditions:']
    for condition in plan.conditions:
        taken = 'taken' if condition.taken else 'not taken'
        place = shown_position(condition.position, cwd)
        text = one_line(condition.text)
        lines.append(f'{_INDENT}{text}  {taken}  ({place})')
    return '\n'.join(lines)


def _stages_as_text(plan: Plan) -> Iterator[str]:
    """Describe what starts together, if some wait for others."""
    after = dependencies_of(plan.members())
    if not any(after.values()) or cycle_in(after):
        return
    yield ''
    yield 'stages:'
    for number, labels in enumerate(stages_of(after), 1):
        yield f'{_INDENT}{number}: {", ".join(labels)}'


def command(process: Process) -> str:
    """
    Return a process's command line, ready to be pasted into bash.

    A file with parameters that exists only while a launch runs becomes `-p`
    arguments, which mean the same to a node.
    """
    words: list[str] = []
    for argument in process.argv:
        if isinstance(argument, str):
            words.append(quoted(argument))
        elif argument.parameters and words[-1] == '--params-file':
            words.pop()
            for p in argument.parameters:
                words += ['-p', quoted(f'{p.name}:={p.value}')]
        else:
            content = quoted(argument.content)
            words.append(f'<(printf %s {content})')
    variables = _variables(process.environment)
    folder = quoted(process.cwd)
    return f'(cd {folder} && {" ".join([*variables, *words])})'


def quoted(word: str) -> str:
    """Return a word as bash reads it, in one line that can be shown."""
    if one_line(word) == word:
        return shlex.quote(word)
    return f"$'{''.join(map(_in_quotes, word))}'"


def _in_quotes(character: str) -> str:
    if character in "\\'":
        return f'\\{character}'
    if one_line(character) == character:
        return character
    if character == '\n':
        return r'\n'
    if character.isascii():
        return f'\\x{ord(character):02x}'
    return f'\\U{ord(character):08x}'


def _variables(environment: Variables) -> Iterator[str]:
    unset = [name for name, value in environment if value is None]
    if unset:
        yield 'env'
    for name in unset:
        yield f'-u {quoted(name)}'
    for name, value in environment:
        if value is not None:
            yield f'{name}={quoted(value)}'


def _step_as_text(
    entry: Message | Shutdown | ChangeState | SignalProcess | WorkerCall,
    cwd: str,
) -> str:
    """Describe what is done besides starting and loading nodes."""
    if isinstance(entry, Message):
        return f'{entry.level}: {entry.text}'
    if isinstance(entry, Shutdown):
        return f'the launch ends{f": {entry.reason}" if entry.reason else ""}'
    match entry:
        case ChangeState():
            text = f'{entry.transition} {entry.node}'
        case SignalProcess():
            text = _signal(entry)
        case WorkerCall():
            text = f'at its time: {entry.title}'
    return f'{text}  ({shown_position(entry.position, cwd)})'


def _signal(entry: SignalProcess) -> str:
    if not entry.signal:
        return f'stop {entry.process}'
    try:
        name = signal.Signals(entry.signal).name
    except ValueError:
        name = f'signal {entry.signal}'
    return f'{name} to {entry.process}'


def _handler_as_text(handler: EventHandler, cwd: str) -> Iterator[str]:
    """
    Describe what is done when something happens, line by line.

    :param cwd: The folder that paths are shown relative to
    """
    title = f'{when(handler)}:'
    place = shown_position(handler.position, cwd)
    if len(handler.actions) == 1:
        yield f'{title} {handler.actions[0]}  ({place})'
        return
    yield f'{title}  ({place})'
    for action in handler.actions:
        yield _INDENT + action


def when(handler: EventHandler) -> str:
    """Return when an event handler acts."""
    condition = handler.condition
    if handler.event not in _OCCASIONS:
        return f'when {condition or "something else happens"}'
    who, occasion = _OCCASIONS[handler.event]
    who = ' or '.join(handler.processes) or who
    if handler.event == 'state' and condition and ' ' not in condition:
        return f'when {who} is {condition}'
    rest = f' ({condition})' if condition else ''
    return f'when {who} {occasion}{rest}'


def process_as_text(
    process: Process, cwd: str, parameters_of: ParametersOf
) -> Iterator[str]:
    """
    Describe a process, line by line.

    :param cwd: The folder that paths are shown relative to
    :param parameters_of: Returns its parameters
    """
    facts = [process.label]
    if process.name not in (None, process.label):
        facts.append(f'process {process.name}')
    if process.node_name is not None:
        facts.append(f'node {process.node_name}')
    if process.package is not None:
        facts.append(f'package {process.package}')
    yield f'{", ".join(facts)}  ({shown_position(process.position, cwd)})'
    yield f'{_INDENT}{command(process)}'
    for text in _behaviour(process):
        yield f'{_INDENT}{text}'
    yield from _deployed(process.settings)
    yield from _settings('parameters', parameters_of(process), cwd)


def _component_as_text(component: Component, cwd: str) -> Iterator[str]:
    """
    Describe a component, line by line.

    :param cwd: The folder that paths are shown relative to
    """
    facts = [component.label]
    if component.node_name is not None:
        facts.append(f'node {component.node_name}')
    facts.append(f'package {component.package}')
    facts.append(f'plugin {component.plugin}')
    facts.append(f'loaded into {component.container}')
    yield f'{", ".join(facts)}  ({shown_position(component.position, cwd)})'
    yield f'{_INDENT}{load_command(component)}'
    if component.is_lifecycle:
        yield _INDENT + _lifecycle(autostart=component.autostart)
    yield from _deployed(component.settings)
    yield from _settings('parameters', component.parameters, cwd)
    arguments = component.extra_arguments
    yield from _settings('extra arguments', arguments, cwd)


def load_command(component: Component) -> str:
    """Return what loads a component by hand, ready for bash."""
    words = [component.container, component.package, component.plugin]
    if component.name:
        words += ['-n', component.name]
    if component.namespace:
        words += ['--node-namespace', component.namespace]
    for remap in component.remaps:
        words += ['-r', remap]
    for parameter in component.parameters:
        words += ['-p', f'{parameter.name}:={parameter.value}']
    for argument in component.extra_arguments:
        words += ['-e', f'{argument.name}:={argument.value}']
    return ' '.join(['ros2 component load', *map(quoted, words)])


def _lifecycle(*, autostart: bool) -> str:
    if autostart:
        return 'its node is configured and activated'
    return 'its node stays unconfigured until somebody changes its state'


def _deployed(settings: MemberSettings | None) -> Iterator[str]:
    """Describe what a deployment file sets."""
    if settings is not None:
        yield from (_INDENT + text for text in settings_as_text(settings))


def _settings(
    title: str, parameters: Iterable[SetParameter], cwd: str
) -> Iterator[str]:
    shown = list(parameters)
    if shown:
        yield f'{_INDENT}{title}:'
    for parameter in shown:
        place = shown_position(parameter.position, cwd)
        origins = ''.join(
            f', passed by {shown_position(origin, cwd)}'
            for origin in parameter.origins
        )
        name = f'{parameter.name}: {parameter.value}'
        yield f'{_INDENT * 2}{name}  ({place}{origins})'


def _behaviour(process: Process) -> Iterator[str]:
    if process.output != 'both':
        yield f'output: {process.output}'
    if process.emulate_tty:
        yield 'its output is a terminal'
    is_replaced = process.settings is not None and process.settings.restart
    if process.respawn and not is_replaced:
        often = (
            'without end'
            if process.respawn_max_retries == UNLIMITED_RETRIES
            else f'{process.respawn_max_retries} times'
        )
        yield f'respawn: {often}, after {process.respawn_delay:g} s'
    if process.on_exit_shutdown:
        yield 'the launch ends with it'
    if process.is_lifecycle:
        yield _lifecycle(autostart=process.autostart)
