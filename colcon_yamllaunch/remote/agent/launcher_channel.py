# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The connection to the launcher, for code that runs on the machine."""

from collections.abc import Callable, Mapping
import os
import select
import shutil
import time
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.control import protocol
from colcon_yamllaunch.control.protocol import MessageReader
from colcon_yamllaunch.engine.loop import do_nothing

#: Seconds without a word after which the launcher is gone; it says one each
#: second.
LAUNCHER_SILENCE = 30.0
#: Seconds between two words to the launcher.
LAUNCHER_BEAT = 1.0

_READ = 256 * 1024


class LauncherGoneError(Exception):
    """Nobody is at the other end any more."""


class LauncherChannel:
    """
    What comes from the launcher, by our standard input.

    :param program: The folder of our modules if it is to be removed by
      whoever uses them last, or an empty text
    """

    def __init__(self, program: str = '') -> None:
        self.program = program
        self._reader = MessageReader()
        self._messages: list[dict[str, Any]] = []
        self._heard_at = self._last_beat = time.monotonic()
        self._was_asked = False
        #: Seconds without a word after which the launcher is gone.
        self.silence = LAUNCHER_SILENCE

    def remove_program(self) -> None:
        """Remove our modules if they are not to stay."""
        if self.program:
            shutil.rmtree(self.program, ignore_errors=True)

    def poll(
        self,
        others: Mapping[int, int],
        seconds: float = LAUNCHER_BEAT,
        *,
        listens: bool = True,
    ) -> set[int]:
        """
        Wait for the launcher, and for others; return who is ready of these.

        The launcher gets a heartbeat each second, so this is to be called
        between two messages.

        :param others: Descriptors with what they are waited for
        :param seconds: How long to wait at most
        :param listens: Whether to read from the launcher
        :raises LauncherGoneError: when the launcher is gone
        """
        poll = select.poll()
        if listens:
            poll.register(0, select.POLLIN)
        for descriptor, mask in others.items():
            poll.register(descriptor, mask)
        due = self._last_beat + LAUNCHER_BEAT - time.monotonic()
        ready = {d for d, _ in poll.poll(max(0, min(due, seconds)) * 1000)}
        now = time.monotonic()
        if 0 in ready:
            self._read()
        elif listens and now - self._heard_at > self.silence:
            raise LauncherGoneError
        if now >= self._last_beat + LAUNCHER_BEAT:
            self._last_beat = now
            send({'beat': 0})
        return ready - {0}

    def read(self, descriptor: int) -> bytes:
        """
        Return what comes from another descriptor next; empty at its end.

        :raises LauncherGoneError: when the launcher is gone meanwhile
        """
        while not self.poll({descriptor: select.POLLIN}):
            continue
        return os.read(descriptor, _READ)

    def new_messages(self) -> list[dict[str, Any]]:
        """Return the messages that have come since the last one."""
        new, self._messages = self._messages, []
        return new

    def next_message(
        self, idle: Callable[[], object] = do_nothing
    ) -> dict[str, Any]:
        """
        Return what comes next.

        :param idle: Is called if nothing has come yet, but something before
        :raises ProtocolError: when something else comes
        :raises LauncherGoneError: when the launcher is gone
        """
        if not self._messages:
            self.poll({}, 0.0)
        if not self._messages and self._was_asked:
            idle()
        while not self._messages:
            self.poll({})
        self._was_asked = True
        return self._messages.pop(0)

    def _read(self) -> None:
        data = os.read(0, _READ)
        if not data:
            raise LauncherGoneError
        self._heard_at = time.monotonic()
        self._messages += self._reader.feed(data)


def stream_message(data: bytes) -> bytes:
    """Return a message with the input or output of a program."""
    # as `srun` passes on lines only
    return protocol.encode_raw('stream', {}, data) + b'\n'


def send(content: Mapping[str, Any], descriptor: int = 1) -> None:
    """
    Send the launcher a message.

    :raises LauncherGoneError: when it is gone
    """
    write(protocol.encode(content), descriptor)


def write(data: bytes, descriptor: int = 1) -> None:
    """
    Write to the launcher.

    :raises LauncherGoneError: when it is gone
    """
    view = memoryview(data)
    while view:
        try:
            view = view[os.write(descriptor, view) :]
        except BlockingIOError:
            poll = select.poll()
            poll.register(descriptor, select.POLLOUT)
            if not poll.poll(LAUNCHER_SILENCE * 1000):
                raise LauncherGoneError from None
        except OSError as error:
            raise LauncherGoneError from error


def reply_of(
    content: Mapping[str, Any], function: Callable[[], Any]
) -> dict[str, Any]:
    """
    Return the reply to a request: the result of a function, or its error.

    :raises LauncherGoneError: when the launcher is gone
    """
    number = content.get('id')
    try:
        return {'reply': number, 'result': function()}
    except LauncherGoneError:
        raise
    except (UserError, OSError) as error:
        text = str(error)
    except Exception as error:  # noqa: BLE001
        # a fault of ours, which takes one line all the same
        name = content.get('request')
        text = f'{name} failed: {type(error).__name__}: {error}'
    return {'reply': number, 'error': text}


def redirect_to_null(*descriptors: int) -> None:
    """Redirect descriptors to the null device."""
    null = os.open(os.devnull, os.O_RDWR)
    for descriptor in descriptors:
        os.dup2(null, descriptor)
    os.close(null)
