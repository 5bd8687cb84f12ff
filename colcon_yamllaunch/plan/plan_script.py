# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A plan as a script for bash, which runs it without colcon."""

from collections.abc import Iterator

from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.plan.plan import (
    AfterReady,
    ChangeState,
    Component,
    DEFAULT_SIGKILL_TIMEOUT,
    DEFAULT_SIGTERM_TIMEOUT,
    Entry,
    Member,
    Message,
    Plan,
    Process,
    Shutdown,
    SignalProcess,
    Timer,
    WorkerCall,
)
from colcon_yamllaunch.plan.plan_text import command, load_command, quoted
from colcon_yamllaunch.plan.position import shown_position

_BEGIN = """\
#!/usr/bin/env bash
# What `colcon launch` would run: each process in the background, all at once.
# It ends when all have ended, and Ctrl-C ends them.
"""

# Both commands fail at once where no such node runs yet.
_ROS = """\
# Components are loaded, and lifecycle nodes activated, by ros2 (its packages
# ros2component and ros2lifecycle), as soon as their nodes are there, and not
# again when one comes back by respawn.
command -v ros2 > /dev/null || {
  echo 'the command ros2 is needed, and not there' >&2
  exit 1
}
container_runs() {
  until ros2 component list "$1"; do sleep 0.5; done
} > /dev/null 2>&1
change_state() {
  until ros2 lifecycle get "$1"; do sleep 0.5; done > /dev/null 2>&1
  ros2 lifecycle set "$1" "$2"
}
activate() {
  change_state "$1" configure && change_state "$1" activate
}
"""

# Job control gives each job a process group of its own, which signals can be
# sent to, and a SIGINT that is not ignored.
_COMMON = """\
set -m
jobs=()
failed=0
to_all() {{
  local job left=1
  for job in "${{jobs[@]}}"; do kill -s "$1" -- "-$job" && left=0; done
  return "$left"
}} 2> /dev/null
stop() {{
  trap '' INT TERM HUP USR1 USR2
  to_all INT
  {{ sleep {sigterm:g}; to_all TERM; sleep {sigkill:g}; to_all KILL; }} &
  local late=$!
  # wait, as a part of a trap, misses what ends meanwhile
  while to_all 0; do sleep 0.1; done
  kill -s KILL -- "-$late"
  exit "$failed"
}} 2> /dev/null
asked=
trap 'asked=stop' INT TERM HUP USR2
trap 'failed=1; asked=stop' USR1
"""

# A signal may come when a job runs, but is not known yet.
_END = """\
trap stop INT TERM HUP USR2
trap 'failed=1; stop' USR1
$asked
for job in "${jobs[@]}"; do wait "$job" || failed=1; done
exit "$failed"
"""

_ON_SIGNAL = "trap 'exit 0' INT TERM"
_UNNAMED = 'not activated: only the program knows the name of its node'


def plan_to_script(plan: Plan, cwd: str, setup: str | None = None) -> str:
    """
    Write a script that runs what a plan says.

    Colours, labels, logs and terminals are the business of a launch, and not
    in it.

    :param cwd: The folder that paths in comments are shown relative to
    :param setup: The setup script of the workspace, if there is one
    """
    processes = list(plan.processes())
    sigterm = [p.sigterm_timeout for p in processes]
    sigkill = [p.sigkill_timeout for p in processes]
    lines = [_BEGIN]
    if setup is not None:
        lines.append(f'. {quoted(setup)} || exit\n')
    lines.append(
        _COMMON.format(
            sigterm=max(sigterm, default=DEFAULT_SIGTERM_TIMEOUT),
            sigkill=max(sigkill, default=DEFAULT_SIGKILL_TIMEOUT),
        )
    )
    if _needs_ros2(plan):
        lines.append(_ROS)
    lines += _jobs(plan.entries, cwd, 0.0)
    return '\n'.join([*lines, _END.rstrip()])


def _needs_ros2(plan: Plan) -> bool:
    return any(
        isinstance(entry, Component | ChangeState)
        or (
            isinstance(entry, Process)
            and entry.is_lifecycle
            and entry.autostart
        )
        for entry in plan.walk()
    )


def _jobs(entries: tuple[Entry, ...], cwd: str, delay: float) -> Iterator[str]:
    loads: dict[str, list[Component]] = {}
    changes: dict[str, list[str]] = {}
    for entry in entries:
        match entry:
            case Component():
                loads.setdefault(entry.container, []).append(entry)
            case ChangeState():
                changes.setdefault(entry.node, []).append(entry.transition)
            case SignalProcess() | WorkerCall():
                place = one_line(shown_position(entry.position, cwd))
                yield f'# {place}: not done, as only a launch can\n'
            case Timer():
                if entry.on_ros_time:
                    yield (
                        f'# the next {entry.period:g} s are not those of '
                        '/clock: the clock of the system counts them'
                    )
                yield from _jobs(entry.entries, cwd, delay + entry.period)
            case AfterReady():
                names = one_line(', '.join(entry.labels))
                yield f'# {names}: not waited for, as only a launch can\n'
                yield from _jobs(entry.entries, cwd, delay)
            case Message():
                text = quoted(f'{entry.level}: {entry.text}')
                yield _job([f"printf '%s\\n' {text}"], delay)
            case Shutdown():
                yield _job(['kill -s USR2 $$'], delay)
            case Process():
                yield _title(entry, cwd)
                yield _job(_steps(entry), delay)
                if entry.is_lifecycle and entry.autostart:
                    yield _activation(entry, delay)
    for container, components in loads.items():
        yield from (_title(component, cwd) for component in components)
        yield _job(_loading(container, components), delay)
    for node, transitions in changes.items():
        steps = [f'change_state {quoted(node)} {t}' for t in transitions]
        yield _job([_ON_SIGNAL, ' && '.join(steps)], delay)


def _title(entry: Member, cwd: str) -> str:
    place = one_line(shown_position(entry.position, cwd))
    return f'# {one_line(entry.label)}  ({place})'


def _activation(process: Process, delay: float) -> str:
    if process.node_name is None:
        return f'# {_UNNAMED}\n'
    activate = f'activate {quoted(process.node_name)}'
    return _job([_ON_SIGNAL, activate], delay)


def _loading(container: str, components: list[Component]) -> list[str]:
    """Return the steps that load components one after the other."""
    steps = [_ON_SIGNAL, 'failed=0', f'container_runs {quoted(container)}']
    for component in components:
        load = load_command(component)
        if component.autostart and component.node_name is None:
            steps.append(f'# {_UNNAMED}')
        elif component.autostart:
            load = f'{load} && activate {quoted(str(component.node_name))}'
        steps.append(f'{{ {load}; }} || failed=1')
    return [*steps, 'exit "$failed"']


def _job(steps: list[str], delay: float) -> str:
    if delay:
        steps = [f'sleep {delay:g}', *steps]
    body = '\n'.join(f'  {step}' for step in steps)
    return f'(\n{body}\n) < /dev/null &\njobs+=($!)\n'


def _steps(process: Process) -> list[str]:
    run = command(process)
    if process.on_exit_shutdown:
        end = 'then kill -s USR2 $$; else kill -s USR1 $$; fi'
        return [f'if {run}; {end}']
    if not process.respawn:
        return [run]
    retries = process.respawn_max_retries
    rounds = f'for ((round = 0; round <= {retries}; round++))'
    if retries < 0:
        rounds = 'while :'
    # a signal ends the rounds, also where the process takes it for its end
    # and returns 0
    return [
        _ON_SIGNAL,
        f'{rounds}; do {run}; sleep {process.respawn_delay:g}; done',
    ]
