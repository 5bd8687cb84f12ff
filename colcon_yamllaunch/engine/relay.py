# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Reading what the processes write, fairly and without any waiting."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import field
import fcntl
import os

from colcon_yamllaunch.common.frozen import mutable
from colcon_yamllaunch.engine import events, limits
from colcon_yamllaunch.engine.channels import resize
from colcon_yamllaunch.engine.lines import LineBuffer
from colcon_yamllaunch.engine.loop import do_nothing, Loop
from colcon_yamllaunch.plan.plan import Process

#: Takes what a process writes as soon as it does, and what is echoed.
Sink = Callable[[events.Stream, bytes], None]
#: Takes what a process writes as soon as it is read.
Recorder = Callable[[Process, events.Stream, bytes], None]


@mutable
class _Source:
    descriptor: int
    process: Process
    stream: events.Stream
    buffer: LineBuffer = field(default_factory=LineBuffer)
    is_terminal: bool = False
    is_large: bool = False


class Relay:
    """
    Reads the output of all processes.

    While output of a process waits for the screen, no more is read from that
    process, so that it waits when its pipe is full. Others go on.

    :param accepts: Whether the screen takes more of a process's stream
    :param recorders: Receive each piece of output first, so that it is not
      lost with the launcher
    :param emit: Receives whole lines
    """

    def __init__(
        self,
        loop: Loop,
        accepts: Callable[[tuple[str, events.Stream]], bool],
        recorders: Sequence[Recorder],
        emit: events.Listener,
    ) -> None:
        self._loop = loop
        self._accepts = accepts
        self._recorders = recorders
        self._emit = emit
        self._sources: dict[int, _Source] = {}
        self._groups: dict[int, list[_Source]] = {}
        # what processes on other machines write
        self._fed: dict[tuple[str, events.Stream], _Source] = {}
        self._paused: list[_Source] = []
        # bytes of all lines that have not ended
        self._unfinished = 0
        self._large_pipes = 0
        # glibc gives the top of the heap back to the system with each chunk of
        # output, unless a larger block was freed before (see mallopt(3))
        bytearray(limits.LARGE_PIPE_BYTES)
        #: Receive the output of a process at once, by its label.
        self.sinks: dict[str, list[Sink]] = {}
        #: Is called with each descriptor before it is closed.
        self.closing: Callable[[int], object] = do_nothing

    def add(
        self, group: int, process: Process, stdout: int, stderr: int
    ) -> None:
        """Read from a new process; the descriptors are closed here later."""
        sources = [
            _Source(stdout, process, 'stdout'),
            _Source(stderr, process, 'stderr'),
        ]
        self._groups[group] = sources
        for source in sources:
            source.is_terminal = os.isatty(source.descriptor)
            os.set_blocking(source.descriptor, False)
            self._sources[source.descriptor] = source
            self._watch(source)

    def resize(self, size: os.terminal_size) -> list[int]:
        """Set the size of all terminals; return the groups that have one."""
        resized = []
        for group, sources in self._groups.items():
            for source in sources:
                if source.is_terminal and self._is_open(source):
                    resize(source.descriptor, size)
                    resized.append(group)
        return sorted(set(resized))

    def unfinished(self, label: str) -> bytes:
        """Return the last line of a process, as far as it is written."""
        return b''.join(
            s.buffer.unfinished
            for s in self._all()
            if s.process.label == label
        )

    def written_terminal(self, label: str) -> int | None:
        """Return the terminal that a process writes its output to."""
        for source in self._sources.values():
            if source.process.label == label and source.is_terminal:
                return source.descriptor
        return None

    def end_lines(self, label: str) -> None:
        """Emit the unfinished line of a process as a whole line."""
        for source in self._all():
            if source.process.label == label:
                self._pass_on(source, self._flushed(source))

    def show(self, label: str, stream: events.Stream, data: bytes) -> None:
        """Send sinks what a process writes, or what is echoed."""
        for sink in tuple(self.sinks.get(label, ())):
            sink(stream, data)

    def feed(
        self, process: Process, stream: events.Stream, data: bytes
    ) -> None:
        """Add output of a process on another machine."""
        key = process.label, stream
        source = self._fed.get(key)
        if source is None:
            source = self._fed[key] = _Source(-1, process, stream)
        source.process = process
        # attached clients have received it before, see `show`
        self._handle_chunk(source, data, is_shown=True)

    def resume(self) -> None:
        """Read again what had to wait for the screen."""
        paused = self._paused
        self._paused = []
        for source in paused:
            if not self._is_open(source):
                continue
            if self._may_read(source):
                self._watch(source)
            else:
                self._paused.append(source)

    def drain(self, group: int) -> None:
        """
        Read all that a process wrote before it ended.

        A child of it may hold the other end and write on for ever; what the
        process itself wrote is not more than its pipe holds.
        """
        for source in self._groups.pop(group, ()):
            self._drain(source)

    def close(self) -> None:
        """Read what is there, and close everything."""
        for source in list(self._sources.values()):
            self._drain(source)
            if self._is_open(source):
                self._close(source)
        for source in self._fed.values():
            self._pass_on(source, self._flushed(source))
        self._groups.clear()

    def _watch(self, source: _Source) -> None:
        self._loop.add_reader(
            source.descriptor, self._read_if_accepted, source
        )

    def _read_if_accepted(self, source: _Source) -> None:
        if self._may_read(source):
            self._read(source)
        elif self._is_open(source):
            self._loop.remove_reader(source.descriptor)
            self._paused.append(source)

    def _drain(self, source: _Source) -> None:
        left = limits.LARGE_PIPE_BYTES + limits.READ_BYTES
        while left > 0 and (size := self._read(source)):
            left -= size
        self._pass_on(source, self._flushed(source))

    def _is_open(self, source: _Source) -> bool:
        return self._sources.get(source.descriptor) is source

    def _may_read(self, source: _Source) -> bool:
        return self._accepts((source.process.label, source.stream))

    def _read(self, source: _Source) -> int:
        if not self._is_open(source):
            return 0
        try:
            chunk = os.read(source.descriptor, limits.READ_BYTES)
        except BlockingIOError:
            return 0
        except OSError:
            # a terminal whose other end is closed reports EIO
            chunk = b''
        if not chunk:
            self._pass_on(source, self._flushed(source))
            self._close(source)
            return 0
        if len(chunk) == limits.READ_BYTES and not source.is_large:
            self._enlarge(source)
        self._handle_chunk(source, chunk)
        return len(chunk)

    def _handle_chunk(
        self, source: _Source, chunk: bytes, *, is_shown: bool = False
    ) -> None:
        for record in self._recorders:
            record(source.process, source.stream, chunk)
        if self.sinks and not is_shown:
            self.show(source.process.label, source.stream, chunk)
        before = source.buffer.size
        self._pass_on(source, source.buffer.feed(chunk))
        self._unfinished += source.buffer.size - before
        if self._unfinished > limits.UNFINISHED_LINES_BYTES:
            longest = max(self._all(), key=lambda s: s.buffer.size)
            self._pass_on(longest, self._flushed(longest))

    def _all(self) -> Iterator[_Source]:
        yield from self._sources.values()
        yield from self._fed.values()

    def _flushed(self, source: _Source) -> bytes:
        self._unfinished -= source.buffer.size
        return source.buffer.flush()

    def _pass_on(self, source: _Source, data: bytes) -> None:
        if data:
            self._emit(events.Output(source.process, source.stream, data))

    def _close(self, source: _Source) -> None:
        self._large_pipes -= source.is_large
        self._loop.remove_reader(source.descriptor)
        self.closing(source.descriptor)
        del self._sources[source.descriptor]
        os.close(source.descriptor)

    def _enlarge(self, source: _Source) -> None:
        if self._large_pipes == limits.LARGE_PIPE_COUNT:
            return
        self._large_pipes += 1
        source.is_large = True
        # the user's share of pipe memory may be used up, or it is a terminal
        with suppress(OSError):
            fcntl.fcntl(
                source.descriptor, fcntl.F_SETPIPE_SZ, limits.LARGE_PIPE_BYTES
            )
