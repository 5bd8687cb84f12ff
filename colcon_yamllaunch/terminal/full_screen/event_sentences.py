# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Events of a launch, as lines among its output."""

from collections.abc import Mapping
from typing import Any

from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.observers.log_levels import Level
from colcon_yamllaunch.observers.log_levels import level_of

#: What each event says, with its fields of `events.jsonl` in braces; nothing
#: where it says nothing of its own.
SENTENCES: Mapping[str, str] = {
    'started': 'started, pid {pid}',
    'start_failed': 'could not be started: {reason}',
    'held': 'held by {signal}',
    'continued': 'goes on',
    'silent': 'no output for {seconds:g} s',
    'requested': '{action} requested',
    'attached': 'attached to a terminal',
    'detached': 'detached',
    'left_behind': 'pid {pid} cannot be stopped, not even by SIGKILL',
    'loaded': 'loaded into {container}',
    'load_failed': 'could not be loaded into {container}: {reason}',
    'unloaded': 'unloaded from {container}: {reason}',
    'state_changed': '{state}',
    'transition_failed': "the transition '{transition}' failed: {reason}",
    'ros_lost': '{reason}; no component is loaded any more',
    'link_lost': '{machine}: the link is lost: {reason}',
    'link_back': '{machine}: the link is back after {seconds:.1f} s',
    'machine_gone': '{machine} is gone: {reason}',
    'watched': '{text}',
    'plan_failed': '{text}',
    'host_lost': 'the host of launch files in Python {reason}',
    'message': '{text}',
    'warning': 'warning: {text}',
    'shutdown': 'stopping: {reason}',
    'ended': 'the launch has ended, exit code {exit_code}',
    # what others say already, or the list of processes shows
    **dict.fromkeys(('planned', 'dropped', 'respawned', 'signalled'), ''),
    **dict.fromkeys(('changed', 'built', 'replanned', 'restarted'), ''),
    # these take more than their fields
    'exited': '',
    'checked': '',
}
_FAILURES = frozenset(
    (
        'host_lost',
        'left_behind',
        'load_failed',
        'machine_gone',
        'plan_failed',
        'ros_lost',
        'start_failed',
        'transition_failed',
    )
)


def sentence_of(name: str, fields: Mapping[str, Any]) -> str:
    """
    Return what an event says, without whom it is about.

    It is empty where there is nothing to say.
    """
    try:
        if name == 'requested' and fields['action'] == 'change':
            return ''
        if name == 'exited':
            text = _ending(fields)
        elif name == 'checked':
            text = 'green: all was seen' if fields['passed'] else _red(fields)
        else:
            text = SENTENCES.get(name, '').format_map(fields)
    except (KeyError, TypeError, ValueError):
        # that of a later version
        return name
    delay = fields.get('respawn_delay')
    if delay is not None:
        text += ', starts again' + (f' in {delay:g} s' if delay else '')
    return one_line(text)


def level_of_event(name: str, fields: Mapping[str, Any]) -> Level:
    """Return how severe an event is."""
    if name == 'message':
        return level_of(f'[{fields.get("level")}]'.encode()) or Level.INFO
    if name == 'warning':
        return Level.WARN
    failed = (
        name in _FAILURES
        or fields.get('failed') is True
        or fields.get('passed') is False
        or (name == 'ended' and fields.get('exit_code') != 0)
    )
    return Level.ERROR if failed else Level.INFO


def _ending(fields: Mapping[str, Any]) -> str:
    if fields['signal'] is not None:
        text = f'died by {fields["signal"]}'
    elif fields['exit_code']:
        text = f'exited with code {fields["exit_code"]}'
    elif fields['exit_code'] is None:
        # nobody knows how, as it ran on a machine that is gone
        text = 'lost'
    else:
        text = 'finished'
    if fields['asked'] and not fields['failed']:
        text = 'stopped'
    return f'{text} after {fields["seconds"]:.1f} s'


def _red(fields: Mapping[str, Any]) -> str:
    missing = [f"'{text}' was not seen" for text in fields['missing']]
    return f'red: {", ".join((*fields["failures"], *missing))}'
