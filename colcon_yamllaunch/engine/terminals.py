# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The keyboards of the processes that have a terminal.

A process whose output goes to terminals reads from a terminal, too, so that a
keyboard can be connected to it at any time; all others read from /dev/null.
What is echoed stays out of the logs, as this is a terminal of its own.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
import os
import termios
from typing import Any

from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.channels import open_terminal, resize
from colcon_yamllaunch.engine.events import Event, Exited
from colcon_yamllaunch.engine.loop import do_nothing, Loop
from colcon_yamllaunch.engine.relay import Relay, Sink
from colcon_yamllaunch.engine.spawn import StartError
from colcon_yamllaunch.plan.plan import changed_entries, Entry, Plan, Process

_IFLAG, _LFLAG = 0, 3
_ECHOES_LINES = termios.ICANON | termios.ECHO


def with_terminals(plan: Plan, label: str | None = None) -> Plan:
    """
    Return a plan whose processes have terminals.

    :param label: The one process that shall have one; without it all do
    """

    def changed(entry: Entry) -> Entry:
        if isinstance(entry, Process) and label in (None, entry.label):
            return replace(entry, emulate_tty=True)
        return entry

    return replace(plan, entries=changed_entries(plan.entries, changed))


class Keyboards:
    """The keyboards of processes that do not run here; there are none."""

    def has_keyboard(self, label: str) -> bool:  # noqa: ARG002
        """Return whether keys can be typed at a process now."""
        return False

    def input_modes(self, label: str) -> int | None:  # noqa: ARG002
        """Return the local modes of the terminal that a process reads."""
        return None

    def attach(self, label: str) -> None:
        """Watch its terminal, as a client is attached to it."""

    def detach(self, label: str) -> None:
        """Stop watching its terminal."""

    def type(self, label: str, keys: bytes) -> None:
        """Type at a process."""


class Terminals:
    """The ends to type at, and the sinks of output."""

    def __init__(self, loop: Loop, relay: Relay) -> None:
        self._loop = loop
        self._relay = relay
        #: The keyboards of processes that do not run here.
        self.elsewhere = Keyboards()
        self._null = os.open(os.devnull, os.O_RDONLY | os.O_CLOEXEC)
        self._keyboards: dict[str, int] = {}
        self._typed: dict[int, bytes] = {}
        # those that have the modes of the output terminal of their process
        self._followers: set[int] = set()
        #: Is called with each descriptor of a keyboard before it is closed.
        self.closing: Callable[[int], object] = do_nothing

    @contextmanager
    def stdin_of(
        self, process: Process, size: os.terminal_size | None
    ) -> Iterator[int]:
        """
        Provide the standard input of a process that is being started.

        :param size: The size of its terminal, or None if it gets none
        :raises StartError: when there are too many open files, for instance
        """
        if size is None:
            yield self._null
            return
        try:
            channel = open_terminal(size)
        except OSError as error:
            reason = f'there is no terminal for its input: {error.strerror}'
            raise StartError(reason) from error
        os.set_blocking(channel.reader, False)
        try:
            yield channel.writer
        except BaseException:
            os.close(channel.reader)
            raise
        finally:
            os.close(channel.writer)
        self._close(process.label)
        self._keyboards[process.label] = channel.reader
        self._loop.add_reader(channel.reader, self._read_echo, process.label)

    def handle(self, event: Event) -> None:
        """Handle an event."""
        if isinstance(event, Exited):
            self._close(event.process.label)

    def resize(self, size: os.terminal_size) -> None:
        """Set the size of all terminals."""
        for descriptor in self._keyboards.values():
            resize(descriptor, size)

    def keyboard_of(self, label: str) -> int | None:
        """Return the descriptor that keys for a process are written to."""
        return self._keyboards.get(label)

    def input_modes(self, label: str) -> int | None:
        """
        Return the local modes of the terminal that a process reads from.

        That is the third of termios(3), None if there is no such terminal.
        """
        keyboard = self._keyboards.get(label)
        if keyboard is None:
            return self.elsewhere.input_modes(label)
        try:
            modes = termios.tcgetattr(keyboard)
            written = self._relay.written_terminal(label)
            if written is not None:
                modes = self._followed(keyboard, modes, written)
        except termios.error:
            return None
        return int(modes[_LFLAG])

    def _followed(
        self, keyboard: int, modes: list[Any], written: int
    ) -> list[Any]:
        """
        Copy the modes of the output terminal to the input terminal.

        A process has one of each. What draws in its terminal may set the one
        that it writes to (ncurses does, see newterm), and means its keys.
        """
        wanted = termios.tcgetattr(written)
        is_raw = not wanted[_LFLAG] & termios.ICANON
        if is_raw == (keyboard in self._followers):
            return modes
        self._followers ^= {keyboard}
        modes = [wanted[_IFLAG], *modes[1:_LFLAG], *wanted[_LFLAG:]]
        termios.tcsetattr(keyboard, termios.TCSANOW, modes)
        return modes

    def has_keyboard(self, label: str) -> bool:
        """Return whether keys can be typed at a process now."""
        return label in self._keyboards or self.elsewhere.has_keyboard(label)

    def type(self, label: str, keys: bytes) -> None:
        """
        Type at a process.

        Keys that it does not read are kept up to a limit, as by any terminal;
        further ones are dropped.
        """
        keyboard = self._keyboards.get(label)
        modes = self.input_modes(label) or 0
        is_echoed = modes & _ECHOES_LINES == _ECHOES_LINES
        if is_echoed and (b'\n' in keys or b'\r' in keys):
            # the echo ends the line of a prompt, which is over then
            self._relay.end_lines(label)
        if keyboard is not None:
            pending = self._typed.get(keyboard, b'') + keys
            self._typed[keyboard] = pending[: limits.TYPED_BYTES]
            self._write(keyboard)
        else:
            self.elsewhere.type(label, keys)

    def add_sink(self, label: str, sink: Sink) -> None:
        """Send a sink the unfinished line of a process, then its output."""
        prompt = self._relay.unfinished(label)
        if prompt:
            sink('stdout', prompt)
        if label not in self._relay.sinks:
            self.elsewhere.attach(label)
        self._relay.sinks.setdefault(label, []).append(sink)

    def remove_sink(self, label: str, sink: Sink) -> None:
        """Send a sink nothing any more."""
        sinks = self._relay.sinks.get(label, [])
        if sink in sinks:
            sinks.remove(sink)
        if not sinks:
            self._relay.sinks.pop(label, None)
            self.elsewhere.detach(label)

    def close(self) -> None:
        """Close everything."""
        for label in list(self._keyboards):
            self._close(label)
        os.close(self._null)

    def _read_echo(self, label: str) -> None:
        keyboard = self._keyboards[label]
        try:
            echo = os.read(keyboard, limits.READ_BYTES)
        except BlockingIOError:
            return
        except OSError:
            # the other end is closed
            self._close(label)
            return
        self._relay.show(label, 'stdout', echo)

    def _write(self, keyboard: int) -> None:
        pending = self._typed.pop(keyboard, b'')
        try:
            while pending:
                pending = pending[os.write(keyboard, pending) :]
        except BlockingIOError:
            self._typed[keyboard] = pending
            self._loop.add_writer(keyboard, self._write, keyboard)
        else:
            self._loop.remove_writer(keyboard)

    def _close(self, label: str) -> None:
        keyboard = self._keyboards.pop(label, None)
        if keyboard is not None:
            self._typed.pop(keyboard, None)
            self._followers.discard(keyboard)
            self._loop.remove(keyboard)
            self.closing(keyboard)
            os.close(keyboard)
