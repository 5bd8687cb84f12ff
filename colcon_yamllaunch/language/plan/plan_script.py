# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A plan as a script for bash, which runs it without colcon."""

from collections.abc import Iterator

from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.language.plan.plan import DEFAULT_SIGKILL_TIMEOUT
from colcon_yamllaunch.language.plan.plan import DEFAULT_SIGTERM_TIMEOUT
from colcon_yamllaunch.language.plan.plan import Entry
from colcon_yamllaunch.language.plan.plan import Message
from colcon_yamllaunch.language.plan.plan import Plan
from colcon_yamllaunch.language.plan.plan import Process
from colcon_yamllaunch.language.plan.plan import Shutdown
from colcon_yamllaunch.language.plan.plan import Timer
from colcon_yamllaunch.language.plan.plan_text import command
from colcon_yamllaunch.language.plan.plan_text import quoted
from colcon_yamllaunch.language.syntax.diagnostics import shown_position

_BEGIN = """\
#!/usr/bin/env bash
# What `colcon launch` would run: each process in the background, all at once.
# It ends when all have ended, and Ctrl-C ends them.
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


def plan_to_script(plan: Plan, cwd: str, setup: str | None = None) -> str:
    """
    Write a script that runs what a plan says.

    Colours, labels, logs and terminals are the business of a launch, and not
    in it.

    :param cwd: The folder that paths in comments are shown relative to
    :param setup: The setup script of the workspace, if there is one
    """
    processes = list(plan.processes())
    times = [
        max((p.sigterm_timeout for p in processes), default=None),
        max((p.sigkill_timeout for p in processes), default=None),
    ]
    lines = [_BEGIN]
    if setup is not None:
        lines.append(f'. {quoted(setup)} || exit\n')
    lines.append(
        _COMMON.format(
            sigterm=DEFAULT_SIGTERM_TIMEOUT if times[0] is None else times[0],
            sigkill=DEFAULT_SIGKILL_TIMEOUT if times[1] is None else times[1],
        )
    )
    lines += _jobs(plan.entries, cwd, 0.0)
    return '\n'.join([*lines, _END.rstrip()])


def _jobs(entries: tuple[Entry, ...], cwd: str, delay: float) -> Iterator[str]:
    for entry in entries:
        if isinstance(entry, Timer):
            yield from _jobs(entry.entries, cwd, delay + entry.period)
            continue
        if isinstance(entry, Process):
            place = one_line(shown_position(entry.position, cwd))
            yield f'# {one_line(entry.label)}  ({place})'
        yield _job(_steps(entry), delay)


def _job(steps: list[str], delay: float) -> str:
    if delay:
        steps = [f'sleep {delay:g}', *steps]
    body = '\n'.join(f'  {step}' for step in steps)
    return f'(\n{body}\n) < /dev/null &\njobs+=($!)\n'


def _steps(entry: Entry) -> list[str]:
    if isinstance(entry, Message):
        text = quoted(f'{entry.level}: {entry.text}')
        return [f"printf '%s\\n' {text}"]
    if isinstance(entry, Shutdown):
        return ['kill -s USR2 $$']
    assert isinstance(entry, Process)
    steps = [command(entry)]
    if entry.on_exit_shutdown:
        end = 'then kill -s USR2 $$; else kill -s USR1 $$; fi'
        return [f'if {steps[0]}; {end}']
    if entry.respawn:
        # a signal ends the rounds, also where the process takes it for its
        # end and returns 0
        retries = entry.respawn_max_retries
        rounds = (
            'while :'
            if retries < 0
            else (f'for ((round = 0; round <= {retries}; round++))')
        )
        steps = [
            "trap 'exit 0' INT TERM",
            f'{rounds}; do {steps[0]}; sleep {entry.respawn_delay:g}; done',
        ]
    return steps
