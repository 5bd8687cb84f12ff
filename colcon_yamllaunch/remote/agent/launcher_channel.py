# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The connection to the launcher, for code that runs on the machine."""

from collections.abc import Callable
from collections.abc import Mapping
import os
import select
import shutil
import time
from typing import Any

from colcon_yamllaunch.remote.connection import frames
from colcon_yamllaunch.remote.connection.frames import Frame
from colcon_yamllaunch.remote.connection.frames import FrameReader

#: Seconds without a word after which the launcher is gone; it says one each
#: second.
SILENCE = 30.0
#: Seconds between two words to the launcher.
BEAT = 1.0

_READ = 256 * 1024

#: Sends the launcher a line of progress.
Say = Callable[[str], None]


class Program:
    """Our own modules here, which may have to be removed."""

    def __init__(self) -> None:
        #: Their folder if it is to be removed, or an empty text.
        self.folder = ''

    def remove(self) -> None:
        """Remove them, at the end of whoever uses them last."""
        if self.folder:
            shutil.rmtree(self.folder, ignore_errors=True)


#: Those that this process uses.
PROGRAM = Program()


class LauncherGoneError(Exception):
    """Nobody is at the other end any more."""


class LauncherChannel:
    """What comes from the launcher, by our standard input."""

    def __init__(self) -> None:
        self._reader = FrameReader()
        self._frames: list[Frame] = []
        self._heard = self._beaten = time.monotonic()
        self._was_asked = False
        #: Seconds without a word after which the launcher is gone.
        self.silence = SILENCE

    def poll(
        self,
        others: Mapping[int, int],
        seconds: float = BEAT,
        *,
        listens: bool = True,
    ) -> set[int]:
        """
        Wait for the launcher, and for others; return who is ready of these.

        The launcher gets a heartbeat each second, so this is to be called
        between two frames.

        :param others: Descriptors with what they are waited for
        :param seconds: How long to wait at most
        :param listens: Whether something is taken of the launcher
        :raises LauncherGoneError: when the launcher is gone
        """
        poll = select.poll()
        if listens:
            poll.register(0, select.POLLIN)
        for descriptor, mask in others.items():
            poll.register(descriptor, mask)
        due = self._beaten + BEAT - time.monotonic()
        ready = {d for d, _ in poll.poll(max(0, min(due, seconds)) * 1000)}
        now = time.monotonic()
        if 0 in ready:
            self._read()
        elif listens and now - self._heard > self.silence:
            raise LauncherGoneError
        if now >= self._beaten + BEAT:
            self._beaten = now
            send({'beat': 0})
        return ready - {0}

    def taken_frames(self) -> list[Frame]:
        """Return the frames that have come and nobody has taken."""
        taken, self._frames = self._frames, []
        return taken

    def next_frame(self, idle: Callable[[], None]) -> Frame:
        """
        Return what comes next.

        :param idle: Is called if nothing has come yet, but something before
        :raises FrameError: when something else comes
        :raises LauncherGoneError: when the launcher is gone
        """
        if not self._frames:
            self.poll({}, 0.0)
        if not self._frames and self._was_asked:
            idle()
        while not self._frames:
            self.poll({})
        self._was_asked = True
        return self._frames.pop(0)

    def _read(self) -> None:
        data = os.read(0, _READ)
        if not data:
            raise LauncherGoneError
        self._heard = time.monotonic()
        self._frames += self._reader.feed(data)


def send(content: Mapping[str, Any], descriptor: int = 1) -> None:
    """
    Tell the launcher something.

    :raises LauncherGoneError: when it is gone
    """
    write(frames.message(content), descriptor)


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
            if not poll.poll(SILENCE * 1000):
                raise LauncherGoneError from None
        except OSError as error:
            raise LauncherGoneError from error


def say_through(descriptor: int) -> Say:
    """Return what tells the launcher lines that go with a request."""

    def say(text: str) -> None:
        send({'line': text}, descriptor)

    return say
