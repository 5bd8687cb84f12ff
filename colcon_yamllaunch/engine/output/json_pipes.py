# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The pipes to a process of ours that is asked and answers in JSON."""

from collections.abc import Callable
from collections.abc import Iterator
from collections.abc import Mapping
from contextlib import suppress
import json
import os
from pathlib import Path
from typing import Any

from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.loop import Loop
from colcon_yamllaunch.engine.process.descriptors import open_log


class JsonPipes:
    """
    What a process is asked goes to its input, and what it says comes back.

    Both are JSON objects, one a line. Nothing here waits.

    :param loop: Waits for them
    :param readable: Is called when :meth:`read` has something
    :param log: The file for its standard error, or None
    """

    def __init__(
        self,
        loop: Loop,
        readable: Callable[[], None],
        log: Path | None,
    ) -> None:
        self._loop = loop
        self._readable = readable
        self._log = log
        self._input = self._output = -1
        self._unsent = self._unread = b''
        #: Whether it will not say anything any more.
        self.is_at_end = False

    def open(self) -> tuple[int, int, int]:
        """Return its standard streams; to be closed here once it has them."""
        its_input, self._input = os.pipe()
        self._output, its_output = os.pipe()
        self.is_at_end = False
        os.set_blocking(self._input, False)
        os.set_blocking(self._output, False)
        self._loop.add_reader(self._output, self._readable)
        return its_input, its_output, open_log(self._log)

    def send(self, request: Mapping[str, Any]) -> None:
        """Ask it, if it is there."""
        if self._input != -1:
            # the engine's loop writes before it waits
            self._unsent += json.dumps(request).encode() + b'\n'
            self._write()

    def read(self) -> Iterator[bytes]:
        """Iterate over the lines that have come; see :attr:`is_at_end`."""
        while self._output != -1:
            try:
                data = os.read(self._output, limits.READ_SIZE)
            except BlockingIOError:
                return
            if not data:
                # it is reported as a child, or closed its output for good
                self._loop.remove_reader(self._output)
                self.is_at_end = True
                return
            *lines, self._unread = (self._unread + data).split(b'\n')
            yield from lines

    def close(self) -> None:
        """Have it end, as its input does."""
        for descriptor in (self._input, self._output):
            if descriptor != -1:
                self._loop.remove(descriptor)
                os.close(descriptor)
        self._input = self._output = -1
        self._unsent = self._unread = b''
        self.is_at_end = False

    def last_line(self) -> str:
        """Return what it wrote to its log at last, and where that is."""
        if self._log is None:
            return ''
        with suppress(OSError):
            text = self._log.read_bytes()[-limits.TAIL_BYTES :]
            lines = text.decode(errors='replace').split('\n')
            last = next((s for s in reversed(lines) if s.strip()), '')
            return f'{last.strip()}; see {self._log}' if last else ''
        return ''

    def _write(self) -> None:
        try:
            while self._unsent:
                count = os.write(self._input, self._unsent)
                self._unsent = self._unsent[count:]
        except BlockingIOError:
            self._loop.add_writer(self._input, self._write)
            return
        except OSError:
            # its end is noticed soon
            self._unsent = b''
        self._loop.remove_writer(self._input)
