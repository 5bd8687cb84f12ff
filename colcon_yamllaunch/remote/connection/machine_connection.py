# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A machine before the launch: connected with, asked, and given its part."""

from collections.abc import Callable
from collections.abc import Mapping
from collections.abc import Sequence
from contextlib import suppress
from functools import partial
import math
import os
import select
import signal
import threading
import time
from typing import Any

from colcon_yamllaunch.common.codec import Codec
from colcon_yamllaunch.common.codec import CodecError
from colcon_yamllaunch.common.codec import read_float
from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.common.printable import printable
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.plan_json import plan_to_json
from colcon_yamllaunch.remote.connection import connection_errors
from colcon_yamllaunch.remote.connection.bootstrap import Bootstrap
from colcon_yamllaunch.remote.connection.connect_command import connect_command
from colcon_yamllaunch.remote.connection.connect_command import (
    connect_variables,
)
from colcon_yamllaunch.remote.connection.connect_process import ConnectProcess
from colcon_yamllaunch.remote.connection.connect_process import foreground
from colcon_yamllaunch.remote.connection.connect_process import has_terminal
from colcon_yamllaunch.remote.connection.connection_errors import ConnectError
from colcon_yamllaunch.remote.connection.program_archive import program_archive
from colcon_yamllaunch.remote.deployment.machine import Machine
from colcon_yamllaunch.remote.part_settings import PartSettings
from colcon_yamllaunch.remote.wire import frames
from colcon_yamllaunch.remote.wire.frames import Frame
from colcon_yamllaunch.remote.wire.frames import FrameError
from colcon_yamllaunch.remote.wire.frames import FrameReader

#: Seconds that a machine may take to answer at first. Who asks the user, or
#: waits for an allocation, takes as long as that takes.
CONNECT_TIMEOUT = 60.0
#: Seconds between two words to a machine that is not asked anything.
BEAT = 1.0
#: Seconds without a word of a machine after which the connection is lost.
SILENCE = 4.5
_READ = 256 * 1024
# seconds that a write may take before a connection that is closed is ended
_PATIENCE = 0.5
#: The exit code of a program that does not report one.
_LOST = 255
#: How often a program is ended whose output nobody reads (seconds).
_READER_INTERVAL = 0.2

#: The answer to `hello` has more than the facts.
_CODEC = Codec(accept_unknown=True)

#: Shows a line to the user.
Say = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Facts:
    """
    What a machine is like.

    :param python: The version of its Python
    :param executable: The path of that
    :param system: Its name and version, as `ubuntu 24.04`
    :param architecture: As `uname -m` has it
    :param host: What it calls itself
    :param home: The home folder of the user there
    :param workspace: The folder of the workspace there, or None if there is
      none here either
    :param has_workspace: Whether that exists
    :param ahead: How many seconds its clock is ahead of ours, about
    :param delay: How many seconds that may be off
    """

    python: str
    executable: str
    system: str
    architecture: str
    host: str
    home: str
    workspace: str | None
    has_workspace: bool
    ahead: float
    delay: float = 0.0


@dataclass(frozen=True, slots=True)
class StartedPart:
    """
    A part that has been started there, and waits for the link.

    :param process: The connection that it was started through
    :param identity: The identity of the launch that it is there
    :param boot: What another start of the machine changes
    :param received: What has come behind the answer
    :param facts: What the machine is like
    :param settings: How it is run
    """

    machine: Machine
    process: ConnectProcess
    identity: str
    boot: str
    received: bytes
    facts: Facts
    settings: PartSettings


class MachineConnection:
    """
    A connection with a machine, until its part is started.

    One thread may use it, and another one may close it meanwhile.

    :param places: Where the workspace may be there, the last one if there is
      none yet; paths, or such that begin with `~/`
    :param environment: The variables of the launcher
    :param may_ask: Whether the user may be asked on the terminal
    :param say: Is told lines for the user, such as what `srun` waits for
    """

    def __init__(
        self,
        machine: Machine,
        places: Sequence[str] = (),
        environment: Mapping[str, str] | None = None,
        *,
        may_ask: bool = False,
        say: Say | None = None,
    ) -> None:
        self.machine = machine
        self._places = places
        self._environment = os.environ if environment is None else environment
        self._may_ask = may_ask
        self._say = say
        #: Whether it failed as somebody has to type or confirm something, and
        #: there is a terminal for that.
        self.must_ask = False
        # held by who reads from it, and by who writes to it
        self._reading = threading.Lock()
        self._process: ConnectProcess | None = None
        self._is_closed = False
        self._reader = FrameReader()
        self._frames: list[Frame] = []
        self._lock = threading.Lock()
        self._beats: threading.Thread | None = None
        self._quiet = threading.Event()
        self._number = 0
        self._heard = 0.0
        self._facts: Facts | None = None
        self._command: list[str] = []
        # what the user was told last
        self._told = ''

    @property
    def facts(self) -> Facts:
        """What the machine is like; once it is connected."""
        assert self._facts is not None
        return self._facts

    def connect(self) -> Facts:
        """
        Connect, and return what the machine is like.

        :raises ConnectError: when it cannot be; the text says what to do
        """
        machine, environment = self.machine, self._environment
        may_ask = self._may_ask
        self._command = connect_command(machine, environment, may_ask=may_ask)
        variables = connect_variables(environment, may_ask=may_ask)
        try:
            process = ConnectProcess(
                self._command, variables, asks=may_ask, kept=True
            )
        except OSError as error:
            raise connection_errors.no_command(
                machine, self._command[0], error
            ) from error
        self._process = process
        try:
            if self._is_closed:
                # it was before there was a process to end
                raise self._lost(process)
            if may_ask:
                with foreground(process.pid):
                    self._begin(process, patience=None)
            else:
                waits = machine.kind == 'slurm'
                self._begin(process, None if waits else CONNECT_TIMEOUT)
            self._facts = self._hello()
        except BaseException as error:
            self.close()
            if isinstance(error, ConnectError) and error.may_be_asked:
                self.must_ask = not may_ask and has_terminal()
            raise
        self._beats = threading.Thread(target=self._beat, daemon=True)
        self._beats.start()
        return self._facts

    def ask(
        self,
        request: str,
        arguments: Mapping[str, Any],
        on_line: Say | None = None,
    ) -> dict[str, Any]:
        """
        Have a function called there, and return what it returns.

        :param request: Its module and name, as `manifest.compare`
        :param on_line: Is called with each line that it says meanwhile
        :raises UserError: what it raises there, or as the connection is lost
        """
        return self._ask(request, {'arguments': arguments}, on_line)

    def run_program(
        self, argv: Sequence[str], stdin: int, stdout: int
    ) -> tuple[int, list[str]]:
        """
        Run a program there; return its exit code (128 + a signal) and errors.

        It is ended when nobody writes `stdin` and reads `stdout` any more.

        :param stdin: A descriptor that its input is read from, to the end;
          closed then
        :param stdout: A descriptor that its output is written to; closed
        :raises UserError: when it cannot be started, or the connection is
          lost
        """
        errors: list[str] = []
        number = self._request('stream', {'argv': list(argv)})
        has_ended = threading.Event()
        threading.Thread(
            target=self._send_input,
            args=(stdin, stdout, has_ended),
            daemon=True,
        ).start()
        try:
            result = self._result(
                'stream',
                number,
                errors.append,
                on_stream=partial(_write_all, stdout),
            )
        finally:
            has_ended.set()
            os.close(stdout)
        code = result.get('code')
        return code if isinstance(code, int) else _LOST, errors

    def start_part(self, plan: Plan, settings: PartSettings) -> StartedPart:
        """
        Have a part of the plan made ready there; this connection goes on.

        It runs once its link begins, see `MachineLink`.

        :raises UserError: when it cannot be
        """
        process = self._connected()
        content = {'plan': plan_to_json(plan), 'settings': settings.as_json()}
        result = self._ask('start', content, self._say, CONNECT_TIMEOUT)
        identity, boot = result.get('identity'), result.get('boot')
        if not isinstance(identity, str) or not isinstance(boot, str):
            raise connection_errors.no_protocol(
                self.machine, 'it does not tell what it has started'
            )
        self._stop_beats()
        whole = (frames.encode(f.kind, f.body) for f in self._frames)
        received = b''.join((*whole, self._reader.rest))
        self._process = None
        return StartedPart(
            self.machine,
            process,
            identity,
            boot,
            received,
            self.facts,
            settings,
        )

    def close(self) -> None:
        """End the connection, and what it does there."""
        self._is_closed = True
        process = self._process
        if process is None:
            return
        if self._facts is None or not self._lock.acquire(timeout=_PATIENCE):
            # one that is still on its way there does not notice that its
            # input is closed, and who cannot write to it holds the lock
            process.end(0.0)
            self._lock.acquire()
        # what is done there ends with that
        process.close_input()
        self._lock.release()
        self._stop_beats()
        process.end()
        # who reads has noticed that it has ended
        with self._reading:
            self._process = None
            process.close_pipes()

    # within

    def _begin(self, process: ConnectProcess, patience: float | None) -> None:
        """Start our program there."""
        bootstrap = Bootstrap(program_archive(), self.machine.python)
        self._write(bootstrap.script())
        begin = time.monotonic()
        while bootstrap.state not in ('answered', 'failed'):
            left = None
            if patience is not None:
                left = begin + patience - time.monotonic()
                if left <= 0:
                    raise connection_errors.silent(
                        self.machine,
                        patience,
                        process.messages,
                        bootstrap.noise,
                    )
            data = self._receive(left)
            answer, rest = bootstrap.feed(data)
            self._write(answer)
            if bootstrap.state == 'sending' and (data or patience is None):
                # from now on it says something now and then
                begin, patience = time.monotonic(), SILENCE
        if bootstrap.state == 'failed':
            raise connection_errors.not_started(self.machine, bootstrap)
        self._feed(rest)

    def _hello(self) -> Facts:
        sent = time.time()
        result = self._ask(
            'hello',
            {
                'workspaces': list(self._places),
                'setup': self.machine.setup,
            },
            None,
            CONNECT_TIMEOUT,
        )
        now = time.time()
        try:
            # as in RFC 5905, 8
            took = read_float(result.get('took'))
            ahead = read_float(result.get('clock')) - (took + sent + now) / 2
            delay = max(0.0, now - sent - took) / 2
            facts = _CODEC.from_json(
                Facts, {**result, 'ahead': ahead, 'delay': delay}
            )
            if self._places and facts.workspace is None:
                raise CodecError('is missing', '.workspace')
        except CodecError as error:
            raise connection_errors.no_protocol(
                self.machine, 'it does not tell what it is like'
            ) from error
        return facts

    def _ask(
        self,
        request: str,
        content: Mapping[str, Any],
        on_line: Say | None,
        patience: float = math.inf,
    ) -> dict[str, Any]:
        number = self._request(request, content)
        return self._result(request, number, on_line, patience)

    def _result(
        self,
        request: str,
        number: int,
        on_line: Say | None,
        patience: float = math.inf,
        on_stream: Callable[[bytes], None] | None = None,
    ) -> dict[str, Any]:
        begin = self._heard = time.monotonic()
        while True:
            for answer in self._answers(on_stream):
                line = answer.get('line')
                if line is not None and on_line is not None:
                    on_line(str(line))
                if answer.get('reply') != number:
                    continue
                error, result = answer.get('error'), answer.get('result')
                if error is not None:
                    text = printable(str(error))
                    raise UserError(f'{self.machine.name}: {text}')
                return result if isinstance(result, dict) else {}
            data = self._receive(BEAT)
            now = time.monotonic()
            if data:
                self._heard = now
            elif now - self._heard > SILENCE:
                raise self._lost(self._connected())
            if now - begin > patience:
                raise connection_errors.no_protocol(
                    self.machine,
                    f"it does not answer '{request}' within {patience:g} s",
                )
            self._feed(data)

    def _send_input(
        self, source: int, target: int, has_ended: threading.Event
    ) -> None:
        """
        Send the input of a program; end it when nobody reads its output.

        What is read after its end is dropped: who still writes reads the
        output first, which says why.

        :param source: What the input is read from; closed
        :param target: What the output is written to
        """
        with suppress(ConnectError), open(source, 'rb', 0) as file:
            while data := file.read(_READ):
                if not has_ended.is_set():
                    self._write(frames.encode(frames.STREAM, data))
            if not has_ended.is_set():
                self._write(frames.encode(frames.STREAM, b''))
            poll = select.poll()
            poll.register(target, 0)
            while not has_ended.wait(_READER_INTERVAL):
                if poll.poll(0):
                    self._write(frames.message({'end': 0}))
                    break

    def _lost(self, process: ConnectProcess) -> ConnectError:
        """Give up a connection, also to those who write to it."""
        messages = process.messages
        process.end(0.0)
        return connection_errors.lost(self.machine, messages)

    def _request(self, request: str, content: Mapping[str, Any]) -> int:
        self._number += 1
        message = {**content, 'request': request, 'id': self._number}
        self._write(frames.message(message))
        return self._number

    def _answers(
        self, on_stream: Callable[[bytes], None] | None
    ) -> list[dict[str, Any]]:
        taken = []
        while self._frames:
            frame = self._frames.pop(0)
            if frame.kind == frames.STREAM and on_stream is not None:
                on_stream(frame.body)
            elif frame.kind == frames.CONTROL:
                try:
                    taken.append(frame.content())
                except FrameError as error:
                    raise self._damaged(error) from error
                if 'reply' in taken[-1]:
                    break
        return taken

    def _feed(self, data: bytes) -> None:
        try:
            self._frames += self._reader.feed(data)
        except FrameError as error:
            raise self._damaged(error) from error

    def _damaged(self, error: FrameError) -> ConnectError:
        return connection_errors.no_protocol(self.machine, str(error))

    def _receive(self, seconds: float | None) -> bytes:
        """
        Return what comes next, or nothing after some time.

        :raises ConnectError: when the connection has ended
        """
        with self._reading:
            return self._received(self._connected(), seconds)

    def _received(
        self, process: ConnectProcess, seconds: float | None
    ) -> bytes:
        poll = select.poll()
        poll.register(process.stdout, select.POLLIN)
        if process.read_messages():
            poll.register(process.stderr, select.POLLIN)
        self._tell_waiting(process)
        ready = poll.poll(None if seconds is None else seconds * 1000)
        if not any(d == process.stdout for d, _ in ready):
            process.read_messages()
            self._tell_waiting(process)
            return b''
        data = os.read(process.stdout, _READ)
        if data:
            return data
        if self._facts is not None:
            process.wait(0.5)
            raise connection_errors.lost(self.machine, process.messages)
        code = process.wait(5.0)
        if self._may_ask and code in (-signal.SIGINT, 128 + signal.SIGINT):
            raise KeyboardInterrupt
        raise connection_errors.ended(
            self.machine,
            self._command,
            0 if code is None else code,
            process.messages,
        )

    def _tell_waiting(self, process: ConnectProcess) -> None:
        """Tell what `srun` waits for, whenever that is something else."""
        lines = process.messages.strip().splitlines()
        if (
            self._say is not None
            and self._facts is None
            and self.machine.kind == 'slurm'
            and lines
            and lines[-1] != self._told
        ):
            self._told = lines[-1]
            self._say(one_line(self._told))

    def _write(self, data: bytes) -> None:
        process = self._connected()
        with self._lock:
            view = memoryview(data)
            try:
                while view and process.stdin != -1:
                    view = view[os.write(process.stdin, view) :]
            except OSError:
                # why shows when we read
                return

    def _connected(self) -> ConnectProcess:
        if self._process is None:
            raise connection_errors.lost(self.machine, '')
        return self._process

    def _beat(self) -> None:
        beat = frames.message({'beat': 0})
        while not self._quiet.wait(BEAT):
            with suppress(ConnectError):
                self._write(beat)

    def _stop_beats(self) -> None:
        self._quiet.set()
        if self._beats is not None and self._beats.is_alive():
            self._beats.join()
        self._beats = None


def _write_all(descriptor: int, data: bytes) -> None:
    """Write to who may have stopped reading."""
    view = memoryview(data)
    with suppress(OSError):
        while view:
            view = view[os.write(descriptor, view) :]
