# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Helper processes of a launch, which get requests and send messages."""

from collections.abc import Callable, Mapping
from contextlib import suppress
import json
import os
from pathlib import Path
import signal
import time
from typing import Any

from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.loop import has_ended, Loop, TimerHandle
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.engine.spawn import StartError

#: The longest line of a helper process (bytes).
MAXIMUM_LINE = 64 * 1024 * 1024

#: Starts a process with standard streams; returns its process group.
Spawn = Callable[[tuple[int, int, int]], int]


class JsonPipes:
    """
    The pipes to a child process: JSON objects, one a line, both ways.

    Nothing here blocks. Lines that are no objects are ignored.
    """

    def __init__(self) -> None:
        #: The descriptors of its standard input and output, or -1.
        self.input = self.output = -1
        #: Whether nothing more can be read.
        self.has_ended = False
        self._unsent = b''
        self._unread = bytearray()

    def open(self) -> tuple[int, int]:
        """Open the pipes; return the ends that the child gets."""
        its_input, self.input = os.pipe()
        self.output, its_output = os.pipe()
        os.set_blocking(self.input, False)
        os.set_blocking(self.output, False)
        return its_input, its_output

    @property
    def has_unsent(self) -> bool:
        """Whether :meth:`flush` has more to write."""
        return bool(self._unsent)

    def send(self, message: Mapping[str, Any]) -> None:
        """Add a message to what :meth:`flush` writes, if they are open."""
        if self.input != -1:
            self._unsent += json.dumps(message).encode() + b'\n'

    def flush(self) -> bool:
        """Write what fits; return whether all is written."""
        try:
            while self._unsent:
                count = os.write(self.input, self._unsent)
                self._unsent = self._unsent[count:]
        except BlockingIOError:
            return False
        except OSError:
            # its end is noticed soon
            self._unsent = b''
        return True

    def read(self) -> list[dict[str, Any]]:
        """Return the next messages, or none if none has come."""
        messages: list[dict[str, Any]] = []
        while not messages and self.output != -1 and not self.has_ended:
            try:
                data = os.read(self.output, limits.READ_BYTES)
            except BlockingIOError:
                break
            self._unread += data
            self.has_ended = not data or len(self._unread) > MAXIMUM_LINE
            if b'\n' in data:
                *lines, rest = bytes(self._unread).split(b'\n')
                self._unread = bytearray(rest)
                messages += filter(None, map(_decoded, lines))
        return messages

    def close(self) -> None:
        """Close the pipes, and forget what was not sent or read."""
        for descriptor in (self.input, self.output):
            if descriptor != -1:
                os.close(descriptor)
        self.input = self.output = -1
        self.has_ended = False
        self._unsent = b''
        self._unread.clear()


class HelperProcess:
    """
    A process that serves the launch.

    Requests and messages go through :class:`JsonPipes`. It ends with its
    input, so it does not outlive the launcher. Its owner restarts it after
    pauses, each twice as long as the one before, a few times in a row.
    Nothing here blocks, except :meth:`close`.

    :param spawn: Starts it
    :param handle: Is called with each message
    :param lost: Is called when it could not be started or has ended, with the
      predicate of a sentence, and whether a signal ended it
    :param log: The file for its standard error, or None
    """

    def __init__(
        self,
        loop: Loop,
        spawn: Spawn,
        handle: Callable[[dict[str, Any]], object],
        lost: Callable[[str, bool], object],
        log: Path | None,
    ) -> None:
        self._loop = loop
        self._spawn = spawn
        self._handle = handle
        self._lost = lost
        self._log = log
        #: Its process ID and process group, or 0 while it does not run.
        self.pid = 0
        #: How often it has ended in a row.
        self.ends = 0
        self._is_wanted = True
        self._started_at = 0.0
        self._restart: TimerHandle | None = None
        self._pipes = JsonPipes()

    def start(self) -> None:
        """Start the process, without waiting until it is ready."""
        self._cancel_restart()
        self._started_at = self._loop.time()
        streams = *self._pipes.open(), open_log(self._log)
        self._loop.add_reader(self._pipes.output, self._read)
        try:
            self.pid = self._spawn(streams)
            self._loop.add_child(self.pid, self._ended)
        except StartError as e:
            self._close_pipes()
            self._lost(f'could not be started: {e}', False)
        finally:
            for descriptor in streams:
                os.close(descriptor)

    def send(self, request: Mapping[str, Any]) -> None:
        """Send a request, if the process runs."""
        if self._pipes.input != -1:
            self._pipes.send(request)
            self._write()

    def restart_later(self) -> bool:
        """Start the process after a pause; False if it ended too often."""
        if self._loop.time() - self._started_at > limits.HELPER_STEADY_TIME:
            self.ends = 0
        self.ends += 1
        if self.ends > limits.HELPER_RESTARTS:
            return False
        pause = limits.SHORTEST_RESTART_PAUSE * 2.0 ** (self.ends - 1)
        self._cancel_restart()
        self._restart = self._loop.call_later(pause, self.start)
        return True

    def restart_now(self) -> None:
        """Start the process again without a pause, as another program."""
        self._restart = self._loop.call_soon(self.start)

    def stop(self) -> None:
        """Close the input of the process, which ends it for good."""
        self._cancel_restart()
        self._is_wanted = False
        self._close_pipes()

    def close(self, timeout: float = 0.0) -> None:
        """
        End it, and wait for that.

        :param timeout: Seconds until it is killed with all that it started
        """
        self.stop()
        if not self.pid:
            return
        deadline = time.monotonic() + timeout
        while not has_ended(self.pid) and time.monotonic() < deadline:
            time.sleep(0.002)
        self._kill()
        with suppress(ChildProcessError):
            os.waitpid(self.pid, 0)
        self._loop.remove_child(self.pid)
        self.pid = 0

    def last_line(self) -> str:
        """Return the last line of its log, and where that is."""
        if self._log is None:
            return ''
        with suppress(OSError):
            text = self._log.read_bytes()[-limits.TAIL_BYTES :]
            lines = text.decode(errors='replace').split('\n')
            last = next((s for s in reversed(lines) if s.strip()), '')
            return f'{last.strip()}; see {self._log}' if last else ''
        return ''

    def _ended(self, status: int) -> None:
        # its last messages count
        self._read()
        self._close_pipes()
        self.pid = 0
        if self._is_wanted:
            outcome = Outcome.from_status(status)
            self._lost(str(outcome), outcome.signal is not None)

    def _cancel_restart(self) -> None:
        if self._restart is not None:
            self._restart.cancel()
            self._restart = None

    def _read(self) -> None:
        while messages := self._pipes.read():
            for message in messages:
                self._handle(message)
        if self._pipes.has_ended:
            # it has ended, or closed its output for good
            self._loop.remove_reader(self._pipes.output)
            self._kill()

    def _write(self) -> None:
        if self._pipes.flush():
            self._loop.remove_writer(self._pipes.input)
        else:
            self._loop.add_writer(self._pipes.input, self._write)

    def _kill(self) -> None:
        if self.pid:
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(self.pid, signal.SIGKILL)

    def _close_pipes(self) -> None:
        for descriptor in (self._pipes.input, self._pipes.output):
            self._loop.remove(descriptor)
        self._pipes.close()


def _decoded(line: bytes) -> dict[str, Any] | None:
    try:
        message = json.loads(line)
    except (ValueError, RecursionError):
        # another program, such as a library, has written it
        return None
    return message if isinstance(message, dict) else None


def open_log(path: Path | None) -> int:
    """
    Return a descriptor for what a helper of the launch writes.

    :param path: The file; where there is none, or it cannot be written, that
      goes nowhere
    """
    if path is not None:
        with suppress(OSError):
            # it may be the first file in the folder
            path.parent.mkdir(parents=True, exist_ok=True)
            flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC
            return os.open(path, flags, 0o666)
    return os.open(os.devnull, os.O_WRONLY | os.O_CLOEXEC)


def pythons(path: str) -> list[str]:
    """
    Return the Pythons of an environment; the first one counts most.

    They may have other packages than ours.

    :param path: The folders to search, separated by colons
    """
    found: dict[str, str] = {}
    for folder in path.split(':'):
        candidate = os.path.join(folder, 'python3')
        if os.path.isfile(candidate) and os.access(candidate, os.X_OK):
            # not that of the program: each virtual environment is one
            found.setdefault(os.path.realpath(folder), candidate)
    # if that is missing, the error is reported when it is started
    return list(found.values())[: limits.TRIED_INTERPRETERS] or ['python3']
