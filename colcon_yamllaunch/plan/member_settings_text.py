# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The settings of a deployment file for people to read."""

from collections.abc import Iterator, Mapping

from colcon_yamllaunch.common.table import size
from colcon_yamllaunch.plan.member_settings import (
    MemberSettings,
    OnTimeout,
    READY_TIMEOUT,
    ReadyCondition,
    ResourceLimits,
    Restart,
    Scheduling,
)

_ON_TIMEOUT: Mapping[OnTimeout, str] = {
    'warn': 'what waits for it goes on waiting',
    'fail': 'the launch ends',
    'start': 'what waits for it starts all the same',
}
_BEYOND = {'fail': 'the launch ends', 'leave': 'it stays down'}
_WHEN = {'always': 'whenever it ends', 'failure': 'when it fails'}


def settings_as_text(settings: MemberSettings) -> Iterator[str]:
    """Describe the settings of a process or component, line by line."""
    if settings.after:
        yield f'after: {", ".join(settings.after)}'
    if settings.ready:
        yield f'ready: {conditions_as_text(settings.ready)}'
    timeout = settings.ready_timeout, settings.on_timeout
    if timeout != (READY_TIMEOUT, 'warn'):
        what = _ON_TIMEOUT[settings.on_timeout]
        yield f'not ready after {settings.ready_timeout:g} s: {what}'
    if settings.restart is not None:
        yield f'restart: {_restart(settings.restart)}'
    if settings.critical:
        yield 'critical: the launch ends when it fails'
    if settings.optional:
        yield 'optional: its failure does not count'
    if settings.limits is not None:
        yield f'limits: {", ".join(_limits(settings.limits))}'
    if settings.user:
        yield f'user: {settings.user}'


def conditions_as_text(conditions: tuple[ReadyCondition, ...]) -> str:
    """Return readiness conditions as a part of a sentence."""
    return ' and '.join(map(str, conditions))


def _restart(restart: Restart) -> str:
    if restart.when == 'never':
        return 'never'
    text = _WHEN[restart.when]
    if restart.first_delay or restart.longest_delay:
        text += f', after {restart.first_delay:g} s'
    if restart.longest_delay > restart.first_delay:
        text += f', doubled up to {restart.longest_delay:g} s'
    if restart.limit >= 0:
        text += f', at most {restart.limit} times'
        if restart.window is not None:
            text += f' in {restart.window:g} s'
        text += f', else {_BEYOND[restart.beyond]}'
    if restart.command:
        text += f', once this succeeds: {" ".join(restart.command)}'
    if restart.together:
        text += f', together with {", ".join(restart.together)}'
    return text


def _limits(limits: ResourceLimits) -> Iterator[str]:
    if limits.memory is not None:
        yield f'memory {size(limits.memory)}'
    if limits.memory_high is not None:
        yield f'memory_high {size(limits.memory_high)}'
    if limits.cpu is not None:
        yield f'cpu {limits.cpu * 100:g}%'
    if limits.cpus:
        yield f'cpus {" ".join(map(str, limits.cpus))}'
    for key in ('io', 'tasks', 'nice'):
        value = getattr(limits, key)
        if value is not None:
            yield f'{key} {value}'
    if limits.scheduling is not None:
        yield f'scheduling {_scheduling(limits.scheduling)}'
    if limits.oom is not None:
        yield f'oom {limits.oom}'


def _scheduling(scheduling: Scheduling) -> str:
    if scheduling.policy != 'deadline':
        return f'{scheduling.policy} {scheduling.priority}'
    times = scheduling.runtime, scheduling.deadline, scheduling.period
    return f'deadline {", ".join(f"{seconds:g} s" for seconds in times)}'
