# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What both views show of the processes and components of a launch."""

from collections.abc import Iterator, Mapping
import os
import re
import shlex
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.common.table import duration
from colcon_yamllaunch.engine import cgroup, events, limits
from colcon_yamllaunch.engine.state import (
    ComponentState,
    LaunchState,
    MemberCondition,
    MemberState,
    UNKNOWN,
)

if TYPE_CHECKING:
    from colcon_yamllaunch.control import resource_usage
    from colcon_yamllaunch.engine.description import Description, Parameter

#: The keys that choose a process, in the order in which they are assigned:
#: those that mean something for all processes are left out.
KEYS = '1234567890abcdefghijklmnoprsuvxyzABCDFGHIJKNOPQRSTUVWXYZ'
#: The share of a processor from which on it is shown.
MUCH_CPU = 0.5
#: The rank of what is as it should be.
HEALTHY = 2

#: Colours of a terminal (ECMA-48).
DIM, BOLD, REVERSE = '\x1b[2m', '\x1b[1m', '\x1b[7m'
RED, GREEN, YELLOW = '\x1b[31m', '\x1b[32m', '\x1b[33m'
ALARM = '\x1b[1;31m'

#: How a process failed, in full; see `outcome.Outcome`.
_FAILED = re.compile(r'exited with code (\d+)|died by (\w+)( \([^)]*\))?')


@dataclass(frozen=True, slots=True)
class Look:
    """
    How a condition looks.

    :param sign: In a terminal that has more than ASCII
    :param plain_sign: In one that has not
    :param colour: Of the sign in the status block
    :param style: Of the sign on the full screen
    :param text_colour: Of the label in the status block
    :param rank: What comes first where not all fit
    """

    sign: str
    plain_sign: str
    colour: str
    style: str
    text_colour: str = ''
    rank: int = HEALTHY


#: How each condition looks.
LOOKS: dict[MemberCondition, Look] = {
    'waiting': Look('○', '.', DIM, 'bright_black', DIM),
    'starting': Look('◌', ':', YELLOW, 'yellow'),
    'running': Look('●', '*', GREEN, 'green'),
    'stopping': Look('◍', '-', YELLOW, 'yellow', rank=1),
    'held': Look('‖', '|', YELLOW, 'yellow', rank=1),
    'respawn': Look('↻', '@', YELLOW, 'yellow', rank=1),
    'ended': Look('✓', '+', DIM, 'bright_black', DIM),
    'stopped': Look('■', '#', DIM, 'bright_black', DIM),
    'failed': Look('✗', '!', ALARM, 'bold red', ALARM, rank=0),
}


@dataclass(frozen=True, slots=True)
class StatusRow:
    """
    What is shown of a process or component.

    :param label: Its label, None for a row about something else
    :param title: What it is called
    :param look: How it looks
    :param style: The colour of its sign on the full screen
    :param key: The key that chooses it
    :param state: Its state in words
    :param restarts: How often it was started again, empty for never
    :param cpu: Its share of a processor if that is much
    :param lifecycle: The state of its lifecycle node unless that is active
    :param depth: How far it is indented
    """

    label: str | None
    title: str
    look: Look
    style: str = ''
    key: str = ''
    state: str = ''
    restarts: str = ''
    cpu: str = ''
    lifecycle: str = ''
    depth: int = 0

    @property
    def note(self) -> str:
        """Its state, restarts and CPU share."""
        return ' '.join(filter(None, (self.state, self.restarts, self.cpu)))


class StatusModel:
    """
    The state of a launch, with a key and the CPU share of each process.

    :param state: The state of the launch
    """

    def __init__(self, state: LaunchState) -> None:
        self._state = state
        #: The shares of a processor, by label; those that are not much are
        #: left out.
        self.cpu: dict[str, float] = {}
        self._keys: dict[str, str] = {}
        self._assigned = -1
        self._measured = 0

    @property
    def state(self) -> LaunchState:
        """The state of the launch."""
        return self._state

    @property
    def version(self) -> tuple[int, int]:
        """Another value whenever something of all this has changed."""
        return self.state.version, self._measured

    @property
    def members(self) -> tuple[MemberState, ...]:
        """The processes and components, in the order of the plan."""
        return tuple(self.state.by_label.values())

    def member(self, label: str | None) -> MemberState | None:
        """Return the process or component with a label."""
        return None if label is None else self.state.by_label.get(label)

    @property
    def keys(self) -> Mapping[str, str]:
        """The keys that choose processes and components, by their labels."""
        self._assign()
        return self._keys

    def label_of(self, key: str) -> str | None:
        """Return the label of what a key chooses."""
        keys = self.keys.items()
        return next((label for label, own in keys if own == key), None)

    def measure(self, shares: Mapping[str, float]) -> None:
        """Show the shares of a processor that processes take, by label."""
        # whole percents, so that small differences are no change
        cpu = {
            label: round(share, 2)
            for label, share in shares.items()
            if share >= MUCH_CPU
        }
        if cpu != self.cpu:
            self.cpu = cpu
            self._measured += 1

    def row(self, member: MemberState, depth: int = 0) -> StatusRow:
        """Return what is shown of a process or component."""
        label, condition = member.label, member.condition
        look = LOOKS[condition]
        has_failed = condition == 'respawn' and member.failure
        cpu = self.cpu.get(label)
        is_steady = member.lifecycle in (None, UNKNOWN, 'active')
        return StatusRow(
            label,
            one_line(label),
            look,
            LOOKS['failed'].style if has_failed else look.style,
            self.keys.get(label, ''),
            # in short: the exit code, or the signal
            _FAILED.sub(lambda m: m[2] or f'exit {m[1]}', state_of(member)),
            f'×{member.restarts}' if member.restarts else '',
            '' if cpu is None else f'{cpu * 100:.0f}%',
            '' if is_steady else member.lifecycle or '',
            depth,
        )

    def _assign(self) -> None:
        """Assign keys to new processes; others keep theirs."""
        if self._assigned == self.state.version:
            return
        self._assigned = self.state.version
        for label in self._keys.keys() - self.state.by_label.keys():
            del self._keys[label]
        used = set(self._keys.values())
        free = [key for key in KEYS if key not in used]
        new = [p for p in self.state.by_label if p not in self._keys]
        self._keys.update(zip(new, free, strict=False))


def readiness_text(state: LaunchState) -> str:
    """Return how much is ready, and what waits; empty once all is ready."""
    if not state.has_readiness or state.stopping:
        return ''
    members = list(state.members())
    count = sum(member.is_ready for member in members)
    if count == len(members):
        return ''
    waiting = [
        f'{one_line(member.label)}: {text}'
        for member in members
        if (text := waiting_text(state, member))
    ]
    if len(waiting) > limits.LISTED_NAMES:
        more = len(waiting) - limits.LISTED_NAMES
        waiting[limits.LISTED_NAMES :] = [f'{more} more wait']
    return ', '.join((f'{count} of {len(members)} ready', *waiting))


def waiting_text(state: LaunchState, member: MemberState) -> str:
    """Return what a member waits for, and for how long; or an empty text."""
    if state.stopping or not (member.waits_for or member.unmet):
        return ''
    seconds = duration(state.seconds_of(member))
    return f'{waiting_for(member)} ({seconds})'


def waiting_for(member: MemberState) -> str:
    """Return what a member waits for; empty if it does not."""
    if member.waits_for:
        return f'waiting for {events.listed(member.waits_for)}'
    return f'waiting for {" and ".join(member.unmet)}' if member.unmet else ''


def state_of(member: MemberState) -> str:
    """Return the state of a process or component, as a word or a sentence."""
    if waits := waiting_for(member):
        return one_line(waits)
    if member.phase in ('running', 'loaded') and member.lifecycle is not None:
        return member.lifecycle
    if member.phase == 'respawn':
        return f'respawns ({member.ending})'
    if member.phase == 'failed' or not isinstance(member, ComponentState):
        return one_line(member.ending) or member.phase
    return member.phase


class CpuShares:
    """
    Measures, from time to time, which processes take much of a processor.

    While nothing takes much, that is one short file: of the control group of
    the launch, or else of the whole machine.
    """

    def __init__(self) -> None:
        self._processors = os.cpu_count() or 1
        # the time, and the seconds of processors that were taken until then
        self._before: tuple[float, float] | None = None
        # the same of each process, while they take much
        self._last: resource_usage.UsageSample | None = None
        # of the whole launch
        self._folder: str | None = None

    def measure(
        self, groups: Mapping[str, int], now: float
    ) -> dict[str, float]:
        """
        Return the shares of one processor since the last look, by label.

        What takes little may be missing.

        :param groups: The process groups that run, by label
        :param now: Seconds of a clock that never goes back
        """
        taken = self._processor_seconds(now)
        before, self._before = self._before, (now, taken)
        last, self._last = self._last, None
        if before is None:
            self._folder = _launch_folder(groups)
            self._before = (now, self._processor_seconds(now))
            return {}
        passed = now - before[0]
        if passed <= 0.0 or taken - before[1] < MUCH_CPU * passed:
            return {}
        # imported late, as few launches take much
        from colcon_yamllaunch.control import resource_usage

        self._last = resource_usage.sample_usage(groups.values(), lambda: now)
        if last is None:
            return {}
        used = resource_usage.usage_between(last, self._last)
        return {n: used[g].cpu for n, g in groups.items() if g in used}

    def _processor_seconds(self, now: float) -> float:
        """Return the seconds that the launch has taken, or all has."""
        if self._folder is not None:
            taken = cgroup.processor_time(self._folder)
            if taken is not None:
                return taken
        return self._processors * now - _idle_seconds()


def _launch_folder(groups: Mapping[str, int]) -> str | None:
    """Return the folder of the control group of a launch, if it has one."""
    for group in groups.values():
        folder = cgroup.process_folder(group)
        return None if folder is None else os.path.dirname(folder)
    return None


def _idle_seconds() -> float:
    try:
        with open('/proc/uptime', encoding='ascii') as stream:
            return float(stream.read().split()[1])
    except (OSError, ValueError, IndexError):
        # unknown, so assume that processors are busy
        return 0.0


def description_lines(description: 'Description') -> Iterator[str]:
    """Return lines with all of a process or component, first its name."""
    label = description.label
    name = '' if description.name == label else description.name
    fields = (
        ('node', description.node),
        ('package', description.package),
        ('in ROS 2', name),
        ('from', description.position),
        *(
            (place.kind, _block(place.title, place.position))
            for place in description.within
        ),
        ('command', shlex.join(description.argv)),
        ('plugin', description.plugin),
        ('container', description.container),
        ('folder', description.cwd),
        ('log', description.log),
    )
    yield f'{label}:'
    for field, value in fields:
        if value:
            yield f'  {field}: {value}'
    if description.environment:
        yield '  environment:'
        for variable, text in description.environment:
            yield f'    {variable}' + (
                ' unset' if text is None else f'={shlex.quote(text)}'
            )
    if description.parameters:
        yield '  parameters:'
        yield from map(_parameter, description.parameters)
    if description.remaps:
        yield '  remapping:'
        for rule in description.remaps:
            yield f'    {rule}'


def _block(title: str, position: str) -> str:
    is_told = position.startswith(title)
    return position if is_told else f'{title} ({position})'


def _parameter(parameter: 'Parameter') -> str:
    origins = ''.join(f', from {origin}' for origin in parameter.origins)
    value = f'{parameter.name}: {parameter.value}'
    return f'    {value}  ({parameter.position}{origins})'
