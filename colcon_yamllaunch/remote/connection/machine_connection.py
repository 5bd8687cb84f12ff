# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
A connection with a machine before the launch.

Both ends send messages as those of the control protocol, see
`agent/machine_agent`.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
import json
import math
import os
import select
import signal
import threading
import time
from typing import Any

from colcon_yamllaunch.common.codec import (
    Codec,
    CodecError,
    read_float,
    to_json,
)
from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.printable import one_line, printable
from colcon_yamllaunch.control import protocol
from colcon_yamllaunch.control.protocol import MessageReader, ProtocolError
from colcon_yamllaunch.deployment.deployment import Machine
from colcon_yamllaunch.engine.loop import do_nothing
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.plan_json import plan_to_json
from colcon_yamllaunch.remote.agent.launcher_channel import stream_message
from colcon_yamllaunch.remote.connection import connection_errors
from colcon_yamllaunch.remote.connection.bootstrap import (
    Bootstrap,
    program_archive,
)
from colcon_yamllaunch.remote.connection.connect_process import (
    connect,
    ConnectProcess,
    foreground,
    has_terminal,
)
from colcon_yamllaunch.remote.connection.connection_errors import ConnectError
from colcon_yamllaunch.remote.part_protocol import PartSettings

#: How long a machine may take to answer at first (seconds). There is no limit
#: while the user is asked, or an allocation is waited for.
CONNECT_TIMEOUT = 60.0
#: The interval of heartbeats (seconds).
CONNECTION_BEAT = 1.0
#: The connection is lost after this silence of the machine (seconds).
CONNECTION_SILENCE = 4.5
_READ = 256 * 1024
#: How long closing a connection waits for a write (seconds).
_WRITE_TIMEOUT = 0.5
#: The exit code of a program that does not report one.
_LOST = 255

#: The digits of the longest whole number; each of so many can be a float.
_DIGITS = 19
#: The answer to `hello` has more than the facts.
_CODEC = Codec(accept_unknown=True)

#: Shows a line to the user.
Say = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class MachineFacts:
    """
    The properties of a machine.

    :param host: The name that it has for itself
    :param home: The home folder of the user there
    :param workspace: The folder of the workspace there, or None if there is
      none here either
    :param has_workspace: Whether that exists
    :param ahead: How far its clock is ahead of ours (seconds)
    :param delay: How far `ahead` may be wrong (seconds)
    """

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
    :param reader: Reads what comes behind the answer
    :param facts: What the machine is like
    :param settings: How it is run
    :param environment: The variables of the launcher
    """

    machine: Machine
    process: ConnectProcess
    identity: str
    boot: str
    reader: MessageReader
    facts: MachineFacts
    settings: PartSettings
    environment: Mapping[str, str]


class MachineConnection:
    """
    A connection with a machine, until its part is started.

    One thread may use it, and another one may close it meanwhile.

    :param places: The folders that may be the workspace there, absolute or
      with a leading `~/`; the last one if none of them exists
    :param environment: The variables of the launcher
    :param may_ask: Whether the user may be asked on the terminal
    :param say: Called with lines for the user, such as those of `srun`
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
        #: Whether connecting failed only because the user has to answer
        #: something, and there is a terminal.
        self.must_ask = False
        # held while reading, and `_lock` while writing
        self._reading = threading.Lock()
        self._process: ConnectProcess | None = None
        self._is_closed = False
        self._reader = MessageReader(read_message)
        self._messages: list[dict[str, Any]] = []
        self._lock = threading.Lock()
        self._beats: threading.Thread | None = None
        self._quiet = threading.Event()
        self._number = 0
        self._facts: MachineFacts | None = None
        # the last line for the user
        self._shown = ''

    @property
    def facts(self) -> MachineFacts:
        """The properties of the machine, once it is connected."""
        assert self._facts is not None
        return self._facts

    def connect(self) -> MachineFacts:
        """
        Connect, and return the properties of the machine.

        :raises ConnectError: when that fails; the text says what to do
        """
        machine, environment = self.machine, self._environment
        may_ask = self._may_ask
        try:
            process = connect(machine, environment, may_ask=may_ask, kept=True)
        except OSError as error:
            raise connection_errors.no_command(machine, error) from error
        self._process = process
        try:
            if self._is_closed:
                # it was before there was a process to end
                raise self._lost(process)
            if may_ask:
                with foreground(process.pid):
                    self._begin(process, timeout=None)
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
        Call a function there, and return its result.

        :param request: Its module and name, such as `manifest.prepare`
        :param on_line: Called with each line that it says meanwhile
        :raises UserError: when it raises one there, or the connection is lost
        """
        return self._ask(request, {'arguments': arguments}, on_line)

    def run_program(
        self, argv: Sequence[str], stdin: int, stdout: int
    ) -> tuple[int, list[str]]:
        """
        Run a program there; return its exit code (128 + a signal) and errors.

        :param stdin: A descriptor that its input is read from, to the end;
          closed then
        :param stdout: A descriptor that its output is written to; closed
        :raises UserError: when it cannot be started, or the connection is
          lost
        """
        errors: list[str] = []
        has_ended = threading.Event()
        sender = threading.Thread(
            target=self._send_input, args=(stdin, has_ended), daemon=True
        )
        try:
            result = self._ask(
                'stream',
                {'argv': list(argv)},
                errors.append,
                on_stream=partial(_write_all, stdout),
                when_sent=sender.start,
            )
        finally:
            has_ended.set()
            os.close(stdout)
        code = result.get('code')
        return code if isinstance(code, int) else _LOST, errors

    def start_part(self, plan: Plan, settings: PartSettings) -> StartedPart:
        """
        Prepare a part of the plan there, on this connection.

        It runs once its link begins, see `MachineLink`.

        :raises UserError: when it cannot be
        """
        process = self._connected()
        content = {'plan': plan_to_json(plan), 'settings': to_json(settings)}
        result = self._ask('start', content, self._say, CONNECT_TIMEOUT)
        match result:
            case {'identity': str(identity), 'boot': str(boot)}:
                pass
            case _:
                raise self._damaged('it does not tell what it has started')
        self._stop_beats()
        self._process = None
        return StartedPart(
            self.machine,
            process,
            identity,
            boot,
            self._reader,
            self.facts,
            settings,
            self._environment,
        )

    def close(self) -> None:
        """Close the connection, and stop its requests there."""
        self._is_closed = True
        process = self._process
        if process is None:
            return
        if self._facts is None or not self._lock.acquire(
            timeout=_WRITE_TIMEOUT
        ):
            # while it connects, it does not notice that its input is closed;
            # and a blocked writer holds the lock
            process.end(0.0)
            self._lock.acquire()
        # requests there end with that
        process.close_input()
        self._lock.release()
        self._stop_beats()
        process.end()
        # a reader has noticed that it has ended
        with self._reading:
            self._process = None
            process.close_pipes()

    # within

    def _begin(self, process: ConnectProcess, timeout: float | None) -> None:
        """Start our program there."""
        machine = self.machine
        bootstrap = Bootstrap(program_archive(), machine.python)
        self._write(bootstrap.script())
        begin = time.monotonic()
        while bootstrap.state not in ('answered', 'failed'):
            left = None
            if timeout is not None:
                left = begin + timeout - time.monotonic()
                if left <= 0:
                    said = f'{bootstrap.noise}\n{process.messages}'
                    raise connection_errors.silent(machine, timeout, said)
            data = self._receive(left)
            answer, rest = bootstrap.feed(data)
            self._write(answer)
            if bootstrap.state == 'sending' and (data or timeout is None):
                # from now on it is never silent for long
                begin, timeout = time.monotonic(), CONNECTION_SILENCE
        if bootstrap.state == 'failed':
            raise connection_errors.not_started(machine, bootstrap)
        self._feed(rest)

    def _hello(self) -> MachineFacts:
        sent = time.time()
        content = {
            'workspaces': list(self._places),
            'setup': self.machine.setup,
        }
        result = self._ask('hello', content, timeout=CONNECT_TIMEOUT)
        now = time.time()
        try:
            # as in RFC 5905, 8
            took = read_float(result.get('took'))
            ahead = read_float(result.get('clock')) - (took + sent + now) / 2
            delay = max(0.0, now - sent - took) / 2
            facts = _CODEC.from_json(
                MachineFacts, {**result, 'ahead': ahead, 'delay': delay}
            )
            if self._places and facts.workspace is None:
                raise CodecError('is missing', '.workspace')
        except CodecError as error:
            raise self._damaged('it does not tell what it is like') from error
        return facts

    def _ask(
        self,
        request: str,
        content: Mapping[str, Any],
        on_line: Say | None = None,
        timeout: float = math.inf,
        *,
        on_stream: Callable[[bytes], object] = do_nothing,
        when_sent: Callable[[], object] = do_nothing,
    ) -> dict[str, Any]:
        """
        Send a request, and return its result.

        :param on_line: Called with each line that comes meanwhile
        :param on_stream: Called with the output of a program
        :param when_sent: Called when the request was sent
        """
        self._number += 1
        message = {**content, 'request': request, 'id': self._number}
        self._write(protocol.encode(message))
        when_sent()
        begin = heard = time.monotonic()
        while True:
            while self._messages:
                match self._messages.pop(0):
                    case {'stream': {'data': bytes(data)}}:
                        on_stream(data)
                    case {'line': line} if on_line is not None:
                        on_line(str(line))
                    case {'reply': self._number, 'error': error}:
                        text = printable(str(error))
                        raise UserError(f'{self.machine.name}: {text}')
                    case {'reply': self._number, 'result': dict(result)}:
                        return result
                    case {'reply': self._number}:
                        return {}
                    case {'request': _}:
                        raise self._damaged('it repeats what it is sent')
                    case _:
                        pass
            data = self._receive(CONNECTION_BEAT)
            now = time.monotonic()
            if data:
                heard = now
            elif now - heard > CONNECTION_SILENCE:
                raise self._lost(self._connected())
            if now - begin > timeout:
                raise self._damaged(
                    f"it does not answer '{request}' within {timeout:g} s"
                )
            self._feed(data)

    def _send_input(self, source: int, has_ended: threading.Event) -> None:
        """
        Send the input of a program, until its end.

        Input after the end of the program is dropped: the writer reads the
        output first, which has the reason.

        :param source: The descriptor of the input; closed
        """
        with suppress(ConnectError), open(source, 'rb', 0) as file:
            data = b'?'
            while data:
                data = file.read(_READ)
                if not has_ended.is_set():
                    self._write(stream_message(data))

    def _lost(self, process: ConnectProcess) -> ConnectError:
        """End a connection, also for those that write to it."""
        messages = process.messages
        process.end(0.0)
        return connection_errors.lost(self.machine, messages)

    def _damaged(self, reason: str) -> ConnectError:
        return ConnectError(
            self.machine,
            f'the connection is damaged: {reason}; the command that connects '
            'must pass on all bytes as they are, without a terminal in '
            'between',
        )

    def _feed(self, data: bytes) -> None:
        try:
            self._messages += self._reader.feed(data)
        except ProtocolError as error:
            raise self._damaged(str(error)) from error

    def _receive(self, seconds: float | None) -> bytes:
        """
        Return the next data, or nothing after `seconds`.

        :raises ConnectError: when the connection has ended
        """
        with self._reading:
            process = self._connected()
            poll = select.poll()
            poll.register(process.stdout, select.POLLIN)
            if process.read_messages():
                poll.register(process.stderr, select.POLLIN)
            self._show_waiting(process)
            ready = poll.poll(None if seconds is None else seconds * 1000)
            if not any(d == process.stdout for d, _ in ready):
                return b''
            data = os.read(process.stdout, _READ)
            if not data:
                raise self._ended(process)
            return data

    def _ended(self, process: ConnectProcess) -> ConnectError:
        """
        Return why the connection has ended.

        :raises KeyboardInterrupt: when the user has interrupted `ssh`
        """
        if self._facts is not None:
            process.wait(0.5)
            return connection_errors.lost(self.machine, process.messages)
        code = process.wait(5.0)
        if self._may_ask and code in (-signal.SIGINT, 128 + signal.SIGINT):
            raise KeyboardInterrupt
        return connection_errors.ended(
            self.machine,
            process.command,
            0 if code is None else code,
            process.messages,
        )

    def _show_waiting(self, process: ConnectProcess) -> None:
        """Show the last message of `srun` if it is a new one."""
        lines = process.messages.strip().splitlines()
        if (
            self._say is not None
            and self._facts is None
            and self.machine.kind == 'slurm'
            and lines
            and lines[-1] != self._shown
        ):
            self._shown = lines[-1]
            self._say(one_line(self._shown))

    def _write(self, data: bytes) -> None:
        process = self._connected()
        with self._lock:
            view = memoryview(data)
            try:
                while view and process.stdin != -1:
                    view = view[os.write(process.stdin, view) :]
            except OSError:
                # reading reports the reason
                return

    def _connected(self) -> ConnectProcess:
        if self._process is None:
            raise connection_errors.lost(self.machine, '')
        return self._process

    def _beat(self) -> None:
        beat = protocol.encode({'beat': 0})
        while not self._quiet.wait(CONNECTION_BEAT):
            with suppress(ConnectError):
                self._write(beat)

    def _stop_beats(self) -> None:
        self._quiet.set()
        if self._beats is not None and self._beats.is_alive():
            self._beats.join()
        self._beats = None


def _write_all(descriptor: int, data: bytes) -> None:
    """Write data, as far as somebody reads it."""
    view = memoryview(data)
    with suppress(OSError):
        while view:
            view = view[os.write(descriptor, view) :]


def read_message(line: bytes) -> dict[str, Any]:
    """
    Return the message of a machine on a line; its numbers are finite.

    :raises ProtocolError: when it is none
    """
    try:
        content = _READER.decode(line.decode())
    except (ValueError, RecursionError):
        content = None
    if not isinstance(content, dict):
        raise ProtocolError(
            'a message is no object in JSON, or a number in it too large'
        )
    return content


def _number(text: str) -> float:
    is_whole = text.lstrip('-').isdigit()
    if len(text) > _DIGITS if is_whole else not math.isfinite(float(text)):
        raise ValueError
    return int(text) if is_whole else float(text)


_READER = json.JSONDecoder(
    parse_int=_number, parse_float=_number, parse_constant=_number
)
