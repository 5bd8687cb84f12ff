# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The connection of the keyboard to one process of another launch."""

from collections.abc import Sequence
from contextlib import suppress
import os
import select
import signal

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.messages import say, show, show_bytes
from colcon_yamllaunch.common.suggestions import listing
from colcon_yamllaunch.control import protocol
from colcon_yamllaunch.control.client import (
    ControlError,
    LaunchEndedError,
    RunningLaunch,
)
from colcon_yamllaunch.control.orphaned_launches import ONLY_STOPS
from colcon_yamllaunch.control.protocol import ProtocolError
from colcon_yamllaunch.control.selection import Candidate
from colcon_yamllaunch.engine.loop import caught, received, STOPPING
from colcon_yamllaunch.engine.state import ComponentState, MemberState
from colcon_yamllaunch.terminal.keyboard import (
    ESCAPE,
    ESCAPE_NAME,
    Keyboard,
    need_terminal,
)


def attach(chosen: Candidate, members: Sequence[MemberState]) -> int:
    """
    Connect the terminal to a process of a launch; return the exit code.

    :param members: The process that is meant
    :raises UserError: when there are more of them, or no keyboard
    :raises ControlError: when the launch refuses
    """
    if len(members) != 1:
        names = listing(p.label for p in members)
        raise UserError(f'--attach takes one process, not {names}')
    process = members[0]
    if isinstance(process, ComponentState):
        raise UserError(
            f'{process.label} is a component: --attach takes a process, such '
            f'as its container {process.process or process.container}'
        )
    keyboard = Keyboard(need_terminal())
    if not isinstance(chosen.launch, RunningLaunch):
        raise ControlError(ONLY_STOPS)
    chosen.launch.request('attach', process=process.label)
    greeting = (
        f'attached to {process.label} of {chosen.state.title}: {ESCAPE_NAME} '
        'detaches, and so does Ctrl-C; Ctrl-Z suspends this terminal only'
    )
    try:
        reason = _converse(chosen.launch, keyboard, greeting)
    finally:
        keyboard.release()
        show('')
    say(f'{process.label}: {reason}')
    return 0


def _converse(launch: RunningLaunch, keyboard: Keyboard, greeting: str) -> str:
    """
    Pass on keys one way and output the other; return the reason to end that.

    :param greeting: A line to print when the terminal is connected
    """
    poll = select.poll()
    poll.register(launch, select.POLLIN)

    def listen() -> None:
        # unless another job has the terminal
        if keyboard.grab():
            poll.register(keyboard.descriptor, select.POLLIN)
        else:
            with suppress(KeyError):
                poll.unregister(keyboard.descriptor)

    with caught() as signals:
        poll.register(signals, select.POLLIN)
        listen()
        say(greeting)
        while True:
            ready = dict(poll.poll())
            for number in received(signals) if signals in ready else ():
                if number in STOPPING:
                    return 'detached'
                if number == signal.SIGTSTP:
                    keyboard.release()
                    os.kill(os.getpid(), signal.SIGSTOP)
                elif number == signal.SIGCONT:
                    listen()
            if keyboard.descriptor in ready:
                try:
                    keys, escape, _ = keyboard.keys().partition(ESCAPE)
                except OSError:
                    return 'detached'
                if keys:
                    launch.send({'keys': protocol.text_of(keys)})
                if escape:
                    return 'detached'
            if launch.fileno() in ready:
                try:
                    ending = _show_output(launch)
                except LaunchEndedError as e:
                    return str(e)
                if ending is not None:
                    return ending


def _show_output(launch: RunningLaunch) -> str | None:
    """Print new output; return how the process ended, None if it runs."""
    launch.read()
    while (message := launch.next_message()) is not None:
        if 'output' in message:
            try:
                data = protocol.bytes_of(message['output'])
            except ProtocolError as e:
                raise ControlError(str(e)) from e
            show_bytes(data)
        elif 'skipped' in message:
            say(f'\n[{message["skipped"]} bytes skipped]')
        elif message.get('again') and 'ended' in message:
            say(f'\n[{message["ended"]}; it starts again]')
        elif 'ended' in message:
            return str(message['ended'])
    return None
