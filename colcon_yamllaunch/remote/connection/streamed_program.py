# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A program on another machine whose standard streams are here."""

from collections.abc import Callable
from contextlib import suppress
import os
import select
import threading

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.remote.wire import frames
from colcon_yamllaunch.remote.wire.frames import Frame
from colcon_yamllaunch.remote.wire.frames import FrameError
from colcon_yamllaunch.remote.wire.frames import FrameReader

_READ = 256 * 1024
#: Bytes of its standard error that are kept.
_ERRORS = 8192
_LOST = 255


class StreamedProgram:
    """
    The program; two threads pass on its streams.

    :param source: The descriptor that the frames come from
    :param received: Frames that have come already
    :param write: Sends bytes
    :param reading: Is held by who reads from that descriptor
    :param number: That of the request
    :param silence: Seconds without a word after which the connection is lost
    :param lost: Gives the connection up, and returns what is said of that
    """

    def __init__(
        self,
        source: int,
        reader: FrameReader,
        received: list[Frame],
        write: Callable[[bytes], None],
        reading: threading.Lock,
        number: int,
        silence: float,
        lost: Callable[[], UserError],
    ) -> None:
        self._source = source
        self._reader = reader
        self._received = received
        self._write = write
        self._reading = reading
        self._number = number
        self._silence = silence
        self._lost = lost
        self._errors = b''
        self._code: int | None = None
        self._failure: UserError | None = None
        its_input, self._stdin = os.pipe()
        self._stdout, its_output = os.pipe()
        self._up = threading.Thread(
            target=self._send, args=(its_input,), daemon=True
        )
        self._down = threading.Thread(
            target=self._take, args=(its_output,), daemon=True
        )
        self._up.start()
        self._down.start()

    @property
    def stdin(self) -> int:
        """A descriptor here: what is written to it the program reads."""
        return self._stdin

    @property
    def stdout(self) -> int:
        """A descriptor here that gives what the program writes."""
        return self._stdout

    @property
    def errors(self) -> str:
        """What it wrote last to standard error."""
        return self._errors.decode(errors='replace')

    def end_input(self) -> None:
        """Let the program see the end of what it reads."""
        self._close('_stdin')

    def wait(self) -> int:
        """
        Wait for its end, and return its exit code (128 + a signal).

        :raises UserError: when it cannot be started, or the connection is
          lost
        """
        self._down.join()
        if self._failure is not None:
            raise self._failure
        return _LOST if self._code is None else self._code

    def close(self) -> None:
        """Close the descriptors, and end it if it runs."""
        self._close('_stdin')
        self._close('_stdout')
        if self._code is None and self._failure is None:
            self._write(frames.message({'end': self._number}))
        self._up.join()
        self._down.join()

    def _close(self, name: str) -> None:
        descriptor = getattr(self, name)
        setattr(self, name, -1)
        if descriptor != -1:
            with suppress(OSError):
                os.close(descriptor)

    def _send(self, descriptor: int) -> None:
        with os.fdopen(descriptor, 'rb', 0) as file:
            while self._code is None and self._failure is None:
                poll = select.poll()
                poll.register(file, select.POLLIN)
                if not poll.poll(200):
                    continue
                data = file.read(_READ) or b''
                try:
                    self._write(frames.encode(frames.STREAM, data))
                except UserError:
                    # why shows when its output is taken
                    return
                if not data:
                    return

    def _take(self, descriptor: int) -> None:
        with self._reading, os.fdopen(descriptor, 'wb', 0) as file:
            try:
                self._take_all(file.fileno())
            except (OSError, FrameError):
                self._failure = self._lost()

    def _take_all(self, descriptor: int) -> None:
        """
        Pass on what comes, until the program has ended.

        :raises FrameError: when something else comes
        :raises OSError: when nothing can be read
        """
        is_open = True
        poll = select.poll()
        poll.register(self._source, select.POLLIN)
        while True:
            while self._received:
                frame = self._received.pop(0)
                if frame.kind == frames.STREAM and is_open:
                    is_open = _written(descriptor, frame.body)
                elif frame.kind == frames.CONTROL and self._ends(frame):
                    return
            is_ready = poll.poll(self._silence * 1000)
            data = os.read(self._source, _READ) if is_ready else b''
            if not data:
                self._failure = self._lost()
                return
            self._received += self._reader.feed(data)

    def _ends(self, frame: Frame) -> bool:
        content = frame.content()
        if isinstance(content.get('errors'), str):
            text = content['errors'].encode(errors='replace')
            self._errors = (self._errors + text)[-_ERRORS:]
        if content.get('reply') != self._number:
            return False
        if content.get('error') is not None:
            self._failure = UserError(str(content['error']))
        else:
            code = (content.get('result') or {}).get('code')
            self._code = code if isinstance(code, int) else _LOST
        return True


def _written(descriptor: int, data: bytes) -> bool:
    view = memoryview(data)
    try:
        while view:
            view = view[os.write(descriptor, view) :]
    except OSError:
        # nobody reads it any more
        return False
    return True
