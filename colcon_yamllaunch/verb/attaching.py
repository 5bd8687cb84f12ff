# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Connecting the terminal to one process."""

from collections.abc import Sequence
from contextlib import suppress
import os
import select
import signal

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.suggestions import listing
from colcon_yamllaunch.control import protocol
from colcon_yamllaunch.control.client import (
    ControlError,
    LaunchEndedError,
    RunningLaunch,
)
from colcon_yamllaunch.control.orphaned_launches import ONLY_STOPS
from colcon_yamllaunch.control.process_names import meant_by, ProcessNames
from colcon_yamllaunch.control.protocol import ProtocolError
from colcon_yamllaunch.engine.loop import caught, received, STOPPING
from colcon_yamllaunch.engine.state import ComponentState, Part
from colcon_yamllaunch.engine.terminals import with_terminals
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.terminal.keyboard import ESCAPE, ESCAPE_NAME, Keyboard
from colcon_yamllaunch.verb.messages import say, show, show_bytes
from colcon_yamllaunch.verb.selecting import Candidate


def need_terminal() -> int:
    """
    Return the descriptor of the keyboard.

    :raises UserError: when there is none
    """
    if not os.isatty(0):
        raise UserError(
            '--attach needs a keyboard, but standard input is no terminal'
        )
    return 0


def with_terminal(plan: Plan, name: str) -> tuple[Plan, str]:
    """
    Return the plan with a terminal for the attached process, and its label.

    :param name: Its name, or a glob
    :raises UserError: when not exactly one is meant
    """
    known = [ProcessNames.of_plan(p) for p in plan.processes()]
    labels = [names.label for names in known]
    meant = [labels[index] for index in meant_by(name, known)]
    if len(meant) != 1:
        raise UserError(
            f'--attach {name} means {listing(meant)}: it takes one process'
            if meant
            else f"--attach: there is no process '{name}'; there is "
            f'{listing(labels) or "none"}'
        )
    return with_terminals(plan, meant[0]), meant[0]


def attach(chosen: Candidate, parts: Sequence[Part]) -> int:
    """
    Connect the terminal to a process of a launch; return the exit code.

    :param parts: The process that is meant
    :raises UserError: when there are more of them, or no keyboard
    :raises ControlError: when the launch refuses
    """
    if len(parts) != 1:
        names = listing(p.label for p in parts)
        raise UserError(f'--attach takes one process, not {names}')
    process = parts[0]
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
        reason = _Conversation(chosen.launch, keyboard).run(greeting)
    finally:
        keyboard.release()
        show('')
    say(f'{process.label}: {reason}')
    return 0


class _Conversation:
    """Passes on keys one way, and output the other."""

    def __init__(self, launch: RunningLaunch, keyboard: Keyboard) -> None:
        self._launch = launch
        self._keyboard = keyboard
        self._poll = select.poll()
        self._poll.register(launch.connection, select.POLLIN)

    def run(self, greeting: str) -> str:
        """
        Go on until there is a reason to end, and return it.

        :param greeting: What to say once keys and signals are taken
        """
        with caught() as signals:
            self._poll.register(signals, select.POLLIN)
            self._listen()
            say(greeting)
            while True:
                ready = dict(self._poll.poll())
                if signals in ready and self._is_over(received(signals)):
                    return 'detached'
                if self._keyboard.descriptor in ready and self._is_left():
                    return 'detached'
                if self._launch.connection.fileno() in ready:
                    try:
                        ending = self._show_output()
                    except LaunchEndedError as e:
                        return str(e)
                    if ending is not None:
                        return ending

    def _listen(self) -> None:
        """Read keys, unless another job has the terminal."""
        if self._keyboard.grab():
            self._poll.register(self._keyboard.descriptor, select.POLLIN)
        else:
            with suppress(KeyError):
                self._poll.unregister(self._keyboard.descriptor)

    def _is_over(self, numbers: list[int]) -> bool:
        for number in numbers:
            if number == signal.SIGTSTP:
                self._keyboard.release()
                os.kill(os.getpid(), signal.SIGSTOP)
            elif number == signal.SIGCONT:
                self._listen()
        return any(number in STOPPING for number in numbers)

    def _is_left(self) -> bool:
        """Pass on keys, and tell whether there will be no more."""
        try:
            keys, escape, _ = self._keyboard.keys().partition(ESCAPE)
        except OSError:
            return True
        if keys:
            self._launch.send({'keys': protocol.text_of(keys)})
        return bool(escape)

    def _show_output(self) -> str | None:
        """Show what was sent; return how the process ended for good."""
        self._launch.read()
        while (message := self._launch.next_message()) is not None:
            _show(message)
            if 'ended' in message and not message.get('again'):
                return str(message['ended'])
        return None


def _show(message: dict[str, object]) -> None:
    if 'output' in message:
        try:
            data = protocol.bytes_of(message['output'])
        except ProtocolError as e:
            raise ControlError(str(e)) from e
        show_bytes(data)
    elif 'skipped' in message:
        say(f'\n[{message["skipped"]} bytes skipped]')
    elif 'ended' in message and message.get('again'):
        say(f'\n[{message["ended"]}; it starts again]')
