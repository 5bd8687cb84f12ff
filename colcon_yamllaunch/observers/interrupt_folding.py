# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Tracebacks of Python programs that do not handle their end by Ctrl-C.

Most nodes of a tutorial end with a KeyboardInterrupt when they are stopped.
That is no mistake worth 20 lines; the logs have them all.
"""

from collections.abc import Iterator

from colcon_yamllaunch.engine import events

#: Lines that are held back at most to see how a traceback ends.
LONGEST = 500

#: Bytes of the last line of a traceback that are shown.
_WIDTH = 80
_START = b'Traceback (most recent call last):'
# in front of a traceback that follows from another one (Python, traceback)
_LINKS = (
    b'During handling of the above exception, another exception occurred:',
    b'The above exception was the direct cause of the following exception:',
)
# how a node ends that is asked to; rclpy raises the second
_ENDS = (
    b'KeyboardInterrupt',
    b'rclpy.executors.ExternalShutdownException',
)


class InterruptFolding:
    """Makes one line of a traceback that only says that a process stops."""

    def __init__(self) -> None:
        self._stopping: set[str] = set()
        self._streams: dict[tuple[str, events.Stream], _Stream] = {}

    def note(self, event: events.Event) -> None:
        """Take note of who is asked to stop."""
        if isinstance(event, events.Signalled):
            self._stopping.add(event.process.label)
        elif isinstance(event, events.Started):
            self._stopping.discard(event.process.label)

    def fold(self, label: str, stream: events.Stream, data: bytes) -> bytes:
        """
        Return what is to be shown of some lines, and of lines before.

        :param data: Lines that end with a line feed, maybe but the last
        """
        if label not in self._stopping:
            return data
        key = (label, stream)
        lines = self._streams.setdefault(key, _Stream())
        return b''.join(
            shown
            for line in data.splitlines(keepends=True)
            for shown in lines.take(line)
        )

    def rest(self, label: str) -> Iterator[tuple[events.Stream, bytes]]:
        """Return what was held back of a process that has ended."""
        for key in [key for key in self._streams if key[0] == label]:
            held = self._streams.pop(key).held
            if held:
                yield key[1], b''.join(held)


class _Stream:
    def __init__(self) -> None:
        #: What may become one line.
        self.held: list[bytes] = []
        self._is_folded = False

    def take(self, line: bytes) -> Iterator[bytes]:
        """Return what is to be shown once there is one more line."""
        text = line.rstrip()
        is_start = text == _START
        if not self.held and not is_start and not self._is_folded:
            yield line
            return
        self.held.append(line)
        if is_start:
            self._is_folded = False
        elif self._is_folded:
            # what follows may be a traceback that follows from the first
            if text and text not in _LINKS:
                yield from self._give_back()
            return
        elif text.startswith(_ENDS):
            count = len(self.held) - 1
            self.held = []
            self._is_folded = True
            more = b' (after a traceback of %d lines)\n' % count
            yield text[:_WIDTH] + more
            return
        elif text and not text.startswith((b' ', *_LINKS)):
            yield from self._give_back()
            return
        if len(self.held) > LONGEST:
            yield from self._give_back()

    def _give_back(self) -> list[bytes]:
        held = self.held
        self.held = []
        self._is_folded = False
        return held
