# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The guard: a small process that stops a launch whose launcher is gone.

Its standard input is a socket whose other end only the launcher has, so the
end of the input means that the launcher ended without dismissing the guard:
by SIGKILL, or by a crash. Then it takes the launcher's place: the control
socket goes, then SIGINT, SIGTERM and SIGKILL with each process's time-outs,
also for processes that left their group, and the control group and the folder
with the parameter files go. What the processes write meanwhile gets to their
logs, so that they can stop in their own way. The guard has its own session,
takes no signal but SIGKILL, and never outlives its work.

The launcher sends messages, each an array of frames in JSON:

- `["dismissed"]`: the launch has ended; the identity of another may follow;
- `["start", NUMBER, GROUP, SIGTERM_TIMEOUT, SIGKILL_TIMEOUT]`;
- `["end", GROUP]`: nothing is in the group any more;
- `["output", KEY, NUMBER, LABEL, FILES, COMMON_FILE]`, with a descriptor to
  read from: what is read is appended to the files, and to the last one, which
  may be null, as lines with time and label. It is read when the launcher is
  gone, and not before;
- `["closed", KEY]`: the launcher reads from that one no more;
- `["terminal", BEFORE, NOW]` with a descriptor, `["no terminal"]` and
  `["typing", BOOLEAN]`: the terminal whose modes are to be restored;
- `["adopted", PID, BIRTH, NUMBER]`: a process that lost its parent;
- `["lease", SECONDS]`, or null for none: unless it is renewed by then, the
  launcher gets SIGTERM, and SIGKILL if it does not end;
- `["socket", PATH, DEVICE, INODE]`, removed first, `["folder", …]`, the one
  with the parameter files, and `["record", …]`, removed last.

This module imports little: the guard has to be small, and up at once. It
imports nothing later, as the package may have been replaced by then.
"""

from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import suppress
import json
import math
import os
import resource
import select
import signal
import socket
import struct
import sys
import time
from typing import Any

from colcon_yamllaunch.common.escalation import (
    Escalation,
    Orphan,
    Targets,
    Timeouts,
)
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.process_scan import (
    foreground_group,
    read_process,
)
from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.cgroup import LaunchCgroup
from colcon_yamllaunch.engine.channels import HeldTerminal, writer_link
from colcon_yamllaunch.engine.launch_scan import Adopter, find_orphans, Known
from colcon_yamllaunch.engine.lines import LineBuffer, normalised, prefixed
from colcon_yamllaunch.engine.own_files import (
    OwnFile,
    remove_file,
    remove_parameter_files,
)

_FLAGS = os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW
# as the launcher's own lines have it
_TAG = 'launch'


@dataclass(frozen=True, slots=True)
class HeldOutput:
    """
    What a process writes, not to be read as long as the launcher does.

    :param descriptor: The end to read from
    :param number: The number of the process
    :param files: The logs that have each byte
    :param common: The log that has the lines, with time and label
    """

    descriptor: int
    number: int
    label: str
    files: tuple[str, ...]
    common: str | None


class OrphanedOutput:
    """
    The outputs of a launch.

    Logs that cannot be written are done without. They do not rotate, and get
    a fixed number of bytes at most, as the end of a launch is short.
    """

    def __init__(self, outputs: Iterable[HeldOutput]) -> None:
        self._outputs = {o.descriptor: o for o in outputs}
        self._lines = {d: LineBuffer() for d in self._outputs}
        self._commons = {o.common for o in self._outputs.values()} - {None}
        self._files: dict[str, int | None] = {}
        self._left = limits.GUARD_LOG_BYTES
        self._poll = select.poll()
        for descriptor in self._outputs:
            os.set_blocking(descriptor, False)
            self._poll.register(descriptor, select.POLLIN)

    def pass_on(self, seconds: float) -> None:
        """Pass on what is written for some time."""
        deadline = time.monotonic() + seconds
        left = seconds
        while left > 0:
            # what no process writes to any more is not polled
            for descriptor, _ in self._poll.poll(math.ceil(left * 1000)):
                self._read(descriptor)
            left = deadline - time.monotonic()

    def finish(self) -> None:
        """Pass on what is left."""
        for descriptor in tuple(self._outputs):
            # no more than what was written before, as a process may go on
            rounds = limits.LARGE_PIPE_BYTES // limits.READ_BYTES + 1
            while rounds and self._read(descriptor):
                rounds -= 1
            if descriptor in self._outputs:
                self._close(descriptor)

    def log(self, text: str) -> None:
        """Write a line of our own to the log of all processes."""
        for common in self._commons:
            self._append(str(common), _stamped(_TAG, f'{text}\n'.encode()))

    def _read(self, descriptor: int) -> bool:
        """Read once, and return whether there may be more."""
        try:
            data = os.read(descriptor, limits.READ_BYTES)
        except BlockingIOError:
            return False
        except OSError:
            # a terminal without an open other end
            data = b''
        if not data:
            self._close(descriptor)
            return False
        output = self._outputs[descriptor]
        for file in output.files:
            self._append(file, data)
        self._append_lines(output, self._lines[descriptor].feed(data))
        return True

    def _close(self, descriptor: int) -> None:
        self._poll.unregister(descriptor)
        lines = self._lines.pop(descriptor)
        self._append_lines(self._outputs.pop(descriptor), lines.flush())
        os.close(descriptor)

    def _append_lines(self, output: HeldOutput, lines: bytes) -> None:
        if lines and output.common is not None:
            self._append(output.common, _stamped(output.label, lines))

    def _append(self, path: str, data: bytes) -> None:
        if path not in self._files:
            self._files[path] = _open(path)
        descriptor = self._files[path]
        if descriptor is not None and len(data) <= self._left:
            self._left -= len(data)
            # whatever does not fit on the disk is lost
            with suppress(OSError):
                os.write(descriptor, data)


class GuardedLaunch(Targets):
    """
    What the guard has received of a launch, and what is left of it.

    :param session: The session of the launcher
    """

    def __init__(self, identity: str, session: int) -> None:
        self.identity = identity
        self.session = session
        self.cgroup = LaunchCgroup(identity)
        #: The process groups that the launcher started, with their numbers.
        self.started_groups: dict[int, int] = {}
        #: The time-outs of every process that was ever started.
        self.timeouts: dict[int, Timeouts] = {}
        self.outputs: dict[int, HeldOutput] = {}
        self.known: Known = {}
        self.own_files: dict[str, list[OwnFile]] = {}
        # when the lease expires, or the launcher should have ended after that
        self._due: float | None = None
        self._is_expired = False
        #: The terminal that the launcher has drawn something in, if any.
        self.terminal: HeldTerminal | None = None
        # whether a user types into it
        self._is_typing = False
        # the foreground group of the terminal before the launcher took it
        self._foreground = -1

    def note(self, frame: list[Any], descriptors: list[int]) -> None:
        """
        Process one frame of the launcher.

        :param descriptors: Those of the message that no frame has taken yet
        """
        match frame:
            case ['start', number, group, sigterm, sigkill]:
                self.started_groups[group] = number
                self.timeouts[number] = Timeouts(sigterm, sigkill)
            case ['end', group]:
                self.started_groups.pop(group, None)
            case ['output', key, number, label, files, common]:
                # without one there were too many; they are closed already
                if descriptors:
                    self.outputs[key] = HeldOutput(
                        descriptors.pop(0), number, label, tuple(files), common
                    )
            case ['closed', key]:
                output = self.outputs.pop(key, None)
                if output is not None:
                    os.close(output.descriptor)
            case ['terminal', before, now]:
                self._drop_terminal()
                self._foreground = foreground_group(self.session)
                if descriptors:
                    self.terminal = HeldTerminal(
                        descriptors.pop(0), before, now
                    )
            case ['no terminal']:
                self._drop_terminal()
            case ['typing', is_typing]:
                self._is_typing = is_typing
            case ['adopted', pid, birth, number]:
                self.known[pid, birth] = number
            case ['lease', seconds] if not self._is_expired:
                now = time.monotonic()
                self._due = None if seconds is None else now + seconds
            case ['socket' | 'folder' | 'record' as kind, *file]:
                self.own_files.setdefault(kind, []).append(OwnFile(*file))

    def seconds_to_wait(self) -> float | None:
        """Return the seconds until :meth:`end_launcher`, None for never."""
        if self._due is None:
            return None
        return max(0.001, self._due - time.monotonic())

    def end_launcher(self, pid: int) -> None:
        """Ask a launcher whose lease has expired to stop, or kill it."""
        if self._is_expired:
            self._due = None
            os.kill(pid, signal.SIGKILL)
            return
        longest = max(
            (each.sigterm + each.sigkill for each in self.timeouts.values()),
            default=0.0,
        )
        self._is_expired = True
        self._due = time.monotonic() + longest + limits.LEASE_STOP_TIMEOUT
        os.kill(pid, signal.SIGTERM)

    def forget(self) -> None:
        """Close what the launcher has not taken back."""
        self._drop_terminal()
        for output in self.outputs.values():
            os.close(output.descriptor)

    def groups(self) -> dict[int, int]:
        """Return the groups whose leader runs, and whose id was not reused."""
        return {
            group: number
            for group, number in self.started_groups.items()
            if (leader := read_process(group)) is not None
            and leader.session == self.session
        }

    def search(self, groups: Collection[int]) -> list[Orphan]:
        """Find the other processes of the launch."""
        links = {
            writer_link(output.descriptor) or '': output.number
            for output in self.outputs.values()
        }
        return find_orphans(
            self.identity,
            self.session,
            self.started_groups,
            groups,
            known=self.known,
            # the process that adopted the guard adopts those of the launcher
            adopter=Adopter(os.getppid(), links, None),
        )

    def remove(self, kind: str, how: Callable[[OwnFile], None]) -> None:
        """Remove all files of a kind."""
        for file in self.own_files.get(kind, ()):
            how(file)

    def restore_terminal(self) -> None:
        """Leave the terminal sane, before the shell uses it if that can be."""
        if self.terminal is not None:
            # no shell has it yet, or there is none
            is_free = foreground_group(self.session) in (-1, self._foreground)
            self.terminal.restore(goes_back=self._is_typing and is_free)

    def _drop_terminal(self) -> None:
        if self.terminal is not None:
            os.close(self.terminal.descriptor)
            self.terminal = None

    def kill(self, number: int) -> None:
        """Kill all of a process of the plan; see `Targets`."""
        self.cgroup.kill(number)


def main() -> None:
    """
    Guard one launch after the other.

    The arguments are the identity of the first launch and the session of the
    launcher.
    """
    identity, session = sys.argv[1:]
    connection = socket.socket(fileno=0)
    with suppress(ConnectionError):
        while identity:
            guard(identity, int(session), connection)
            connection.settimeout(None)
            identity = connection.recv(limits.GUARD_MESSAGE_BYTES).decode()


def guard(identity: str, session: int, connection: socket.socket) -> None:
    """
    Guard a launch, until it is dismissed or its launcher is gone.

    :param session: The session of the launcher
    :param connection: The socket to its launcher
    """
    launch = GuardedLaunch(identity, session)
    # each process has up to three descriptors
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
    for frames, descriptors in _messages(connection, launch):
        for frame in frames:
            launch.note(frame, descriptors)
        if ['dismissed'] in frames:
            launch.forget()
            return
    _take_over(launch)


def _take_over(launch: GuardedLaunch) -> None:
    launch.restore_terminal()
    launch.remove('socket', remove_file)
    output = OrphanedOutput(launch.outputs.values())
    output.log('the launcher was killed; the guard stops its processes')
    escalation = Escalation(launch, launch.timeouts, time.monotonic())
    escalation.run(sleep=output.pass_on)
    launch.cgroup.remove()
    output.finish()
    output.log('the guard has stopped what it could')
    launch.remove('folder', remove_parameter_files)
    launch.remove('record', remove_file)


def _messages(
    connection: socket.socket, launch: GuardedLaunch
) -> Iterator[tuple[list[Any], list[int]]]:
    """Iterate over what the launcher sends, with descriptors."""
    while True:
        connection.settimeout(launch.seconds_to_wait())
        try:
            data, descriptors, _, _ = socket.recv_fds(
                connection,
                limits.GUARD_MESSAGE_BYTES,
                limits.GUARD_MESSAGE_FRAMES,
            )
        except TimeoutError:
            # the process that made the connection, see unix(7)
            credentials = connection.getsockopt(
                socket.SOL_SOCKET, socket.SO_PEERCRED, struct.calcsize('3i')
            )
            launch.end_launcher(struct.unpack('3i', credentials)[0])
            continue
        except ConnectionError:
            # it was gone before it had read all that we never send
            return
        if not data:
            return
        yield json.loads(data), descriptors


def _stamped(label: str, lines: bytes) -> bytes:
    prefix = f'{time.time():.6f} [{label}] '.encode(errors='replace')
    return prefixed(normalised(lines), prefix)


def _open(path: str) -> int | None:
    with suppress(OSError):
        os.mkdir(os.path.dirname(path))
    try:
        return os.open(path, _FLAGS, 0o644)
    except OSError:
        return None
