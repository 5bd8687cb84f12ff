# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
A real `sshd` on 127.0.0.1 that stands for several machines.

It runs as whoever runs the tests, with keys and files of its own. Each
machine is a port of it, with a home of its own, reached through a link that
can be made worse. `ssh` finds its configuration by a program of that name in
a folder for `PATH`, as it takes the home from the passwd database.
"""

import asyncio
from collections.abc import Callable, Iterator, Sequence
import contextlib
import fcntl
import os
from pathlib import Path
import pwd
import shlex
import socket
import struct
import subprocess
import sys
import threading
import time
import uuid

import pytest
from support.marked_processes import (
    command_of,
    DEADLINE,
    descendants,
    kill,
    marked,
    wait_until_none,
)
from support.system_servers import (
    program,
    reserved_port,
    run_quietly,
    start_server,
)

#: Bytes read at once.
CHUNK = 65536
#: How many such pieces one direction keeps before it reads no more.
PIECES = 16
#: Bytes that a socket keeps; by itself the kernel keeps megabytes, so that
#: nobody would notice a slow link for long.
BUFFER = 128 * 1024
#: What makes a socket's end a reset (SO_LINGER: on, zero seconds).
RESET = struct.pack('ii', 1, 0)
LOOPBACK = '127.0.0.1'
#: The variable by which what runs on the machines is found.
MARK = 'COLCON_LAUNCH_TEST_SSHD'
#: Names that lead to a machine like any other …
MACHINES = ('arm', 'gpu', 'edge')
#: … with a host key that nobody has accepted, with another one than was
#: accepted, by a key that asks for PASSPHRASE, and by a password that nobody
#: has.
STRANGER, IMPOSTOR, LOCKED, ASKING = 'stranger', 'impostor', 'locked', 'asking'
#: The name of a machine that is switched off.
OFF = 'off'
PASSPHRASE = 'open sesame'
#: How many ports one process of sshd serves (its MAX_LISTEN_SOCKS is 16).
PORTS = 16

#: Where sshd wants to be shut in, if root starts it.
_PRISON = Path('/run/sshd')
#: The mode of that folder if it was made here, so is removed here.
_OUR_MODE = 0o711

_SERVER = """\
AuthorizedKeysFile {folder}/authorized_keys
HostKey {folder}/host_key
KbdInteractiveAuthentication no
ListenAddress 127.0.0.1
LoginGraceTime 60
MaxStartups 200
PasswordAuthentication yes
PermitRootLogin yes
PidFile none
PrintMotd no
StrictModes no
Subsystem sftp internal-sftp
UsePAM no
"""
_CLIENT = """\
Host {names}
  HostName 127.0.0.1
  IdentitiesOnly yes
  User {user}
  UserKnownHostsFile {folder}/known_hosts
  GlobalKnownHostsFile none
Host {locked}
  IdentityFile {folder}/locked_key
Host * !{locked}
  IdentityFile {folder}/key
"""


class TcpLink:
    """
    Forwards connections to a port, as the link's properties allow.

    All may be changed from any thread, at any time.

    :param target: The port that the connections lead to
    :ivar port: Where the link begins
    :ivar delay: Seconds that each byte is under way, in each direction
    :ivar bytes_per_second: How much each direction carries; 0 for no limit
    :ivar there: How many bytes went to the target
    :ivar back: How many came from it
    :ivar accepted: How many connections were made
    """

    def __init__(self, target: int) -> None:
        self.delay = 0.0
        self.bytes_per_second = 0
        self.there = 0
        self.back = 0
        self.accepted = 0
        self._target = target
        self._ends: set[asyncio.StreamWriter] = set()
        self._server = socket.create_server((LOOPBACK, 0), backlog=128)
        # those that are accepted have it, too
        _limit(self._server)
        self.port: int = self._server.getsockname()[1]
        self._loop = asyncio.new_event_loop()
        self._passable = asyncio.Event()
        self._passable.set()
        self._over = asyncio.Event()
        self._thread = threading.Thread(
            target=self._loop.run_until_complete, args=(self._run(),)
        )
        self._thread.start()

    def hold(self) -> None:
        """
        Pull the cable: nothing is forwarded, and nobody is told.

        What is under way is kept until `release()`.
        """
        self._do(self._passable.clear)

    def release(self) -> None:
        """Plug the cable in again."""
        self._do(self._passable.set)

    def break_off(self) -> None:
        """End all connections at once, with a reset for both sides."""
        self._do(self._reset)

    def close(self) -> None:
        """End all of it."""
        self._do(self._over.set)
        self._thread.join()
        self._loop.close()

    def _do(self, what: Callable[[], None]) -> None:
        """Have something done in the thread, and wait for that."""
        done = threading.Event()

        def do() -> None:
            what()
            done.set()

        self._loop.call_soon_threadsafe(do)
        done.wait()

    async def _run(self) -> None:
        server = await asyncio.start_server(self._accept, sock=self._server)
        await self._over.wait()
        server.close()
        self._reset()
        # one that is accepted just now has a task later
        while tasks := asyncio.all_tasks() - {asyncio.current_task()}:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    def _reset(self) -> None:
        for end in self._ends:
            own: socket.socket = end.get_extra_info('socket')
            # its end may have been taken into account already
            with contextlib.suppress(OSError):
                own.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, RESET)
            end.transport.abort()

    async def _accept(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> None:
        self.accepted += 1
        own = socket.socket()
        _limit(own)
        own.setblocking(False)
        try:
            await self._loop.sock_connect(own, (LOOPBACK, self._target))
            there, back = await asyncio.open_connection(sock=own)
        except OSError:
            own.close()
            writer.transport.abort()
            return
        self._ends |= {writer, back}
        # at the end of it all it is cancelled, which nobody has to be told
        with contextlib.suppress(asyncio.CancelledError):
            await asyncio.gather(
                self._forward(reader, back, 'there'),
                self._forward(there, writer, 'back'),
                return_exceptions=True,
            )
        self._ends -= {writer, back}
        for end in (writer, back):
            end.transport.abort()

    async def _forward(
        self,
        reader: asyncio.StreamReader,
        writer: asyncio.StreamWriter,
        counter: str,
    ) -> None:
        """Forward one direction of a connection until its end."""
        pieces: asyncio.Queue[tuple[float, bytes]] = asyncio.Queue(PIECES)
        carrier = asyncio.ensure_future(self._carry(pieces, writer, counter))
        try:
            while data := await reader.read(CHUNK):
                await pieces.put((self._loop.time() + self.delay, data))
            await pieces.put((self._loop.time() + self.delay, b''))
            await carrier
        except OSError:
            # a peer's reset is the other's too
            self._reset_of(writer)
        finally:
            carrier.cancel()

    def _reset_of(self, writer: asyncio.StreamWriter) -> None:
        with contextlib.suppress(OSError):
            writer.transport.abort()

    async def _carry(
        self,
        pieces: 'asyncio.Queue[tuple[float, bytes]]',
        writer: asyncio.StreamWriter,
        counter: str,
    ) -> None:
        """Write the pieces of one direction when each of them is due."""
        while True:
            due, data = await pieces.get()
            await asyncio.sleep(max(0.0, due - self._loop.time()))
            if self.bytes_per_second:
                await asyncio.sleep(len(data) / self.bytes_per_second)
            await self._passable.wait()
            if not data:
                writer.write_eof()
                return
            setattr(self, counter, getattr(self, counter) + len(data))
            writer.write(data)
            await writer.drain()


def _limit(end: socket.socket) -> None:
    for option in (socket.SO_RCVBUF, socket.SO_SNDBUF):
        end.setsockopt(socket.SOL_SOCKET, option, BUFFER)


def why_not() -> str:
    """Return why there can be no `sshd` here, or nothing."""
    for name in ('sshd', 'ssh', 'ssh-keygen'):
        if program(name) is None:
            return f'{name} is not installed (Debian: openssh-server)'
    if os.getuid() == 0 and not os.access('/run', os.W_OK):
        return 'sshd wants a folder in /run, which is read-only'
    return ''


def skip_without_sshd() -> None:
    """Skip the test where there can be no `sshd`."""
    reason = why_not()
    if reason:
        pytest.skip(reason)


@contextlib.contextmanager
def _prison() -> Iterator[None]:
    """Have the folder that sshd wants if root starts it, and no longer."""
    if os.getuid() != 0:
        yield
        return
    parent = os.open(_PRISON.parent, os.O_RDONLY)
    try:
        # several tests may have one each
        fcntl.flock(parent, fcntl.LOCK_SH)
        with contextlib.suppress(FileExistsError):
            _PRISON.mkdir()
            _PRISON.chmod(_OUR_MODE)
        yield
        with contextlib.suppress(OSError):
            fcntl.flock(parent, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if _PRISON.stat().st_mode & 0o777 == _OUR_MODE:
                _PRISON.rmdir()
    finally:
        os.close(parent)


class SshMachine:
    """
    One machine of an `sshd`.

    :ivar name: What `ssh` calls it
    :ivar mark: The value of MARK of all that runs there
    :ivar home: Its home folder, with a folder `bin` that is first on PATH
    :ivar link: The network between
    """

    def __init__(self, name: str, home: Path, port: int) -> None:
        self.name = name
        self.home = home
        self.port = port
        self.mark = f'{name}-{uuid.uuid4().hex}'
        self.link = TcpLink(port)
        (home / 'bin').mkdir(parents=True)

    def lacks_all_but(self, *programs: str) -> None:
        """Have no programs but some, from the next connection on."""
        for name in programs:
            found = program(name)
            assert found is not None, name
            (self.home / 'bin' / name).symlink_to(found)
        self.shell_reads('PATH=$HOME/bin')

    def shell_reads(self, text: str) -> None:
        """Have the user's shell there read something whenever it starts."""
        # what bash reads if sshd starts it: see "Invoking bash" in its manual
        (self.home / '.bashrc').write_text(f'{text}\n', encoding='utf-8')


class Sshd:
    """
    The server, and what its users need.

    :ivar folder: All its files
    :ivar config: The user's configuration of `ssh`
    :ivar programs: A folder for PATH with an `ssh` that uses it
    :ivar machines: By their names
    :param names: Those of the machines that are like any other
    """

    def __init__(self, folder: Path, names: Sequence[str] = MACHINES) -> None:
        self.folder = folder
        self._names = names
        self.config = folder / 'config'
        self.programs = folder / 'programs'
        self.machines: dict[str, SshMachine] = {}
        self._log = folder / 'log'
        self._processes: list[subprocess.Popen[bytes]] = []
        self._open = contextlib.ExitStack()

    def __getitem__(self, name: str) -> SshMachine:
        return self.machines[name]

    def __enter__(self) -> 'Sshd':
        with contextlib.ExitStack() as stack:
            stack.callback(self._close)
            self._open.enter_context(_prison())
            self._make_keys()
            names = [*self._names, STRANGER, IMPOSTOR, LOCKED, ASKING]
            ports = []
            for name in names:
                port = self._open.enter_context(reserved_port())
                ports.append(port.getsockname()[1])
                home = self.folder / 'homes' / name
                machine = SshMachine(name, home, ports[-1])
                self._open.callback(machine.link.close)
                self.machines[name] = machine
            off = self._open.enter_context(reserved_port())
            self._write_server()
            self._write_client(off.getsockname()[1])
            self.start()
            stack.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self._close()

    def environment(self, environment: dict[str, str]) -> dict[str, str]:
        """Return an environment in which `ssh` finds the machines."""
        path = os.pathsep.join([str(self.programs), environment['PATH']])
        # an agent's keys would be tried first
        kept = {
            name: value
            for name, value in environment.items()
            if not name.startswith(('SSH_', MARK))
        }
        return kept | {'PATH': path}

    def configure(self, name: str, *lines: str) -> None:
        """Add lines to the user's configuration of `ssh` for a machine."""
        text = ''.join([f'Host {name}\n', *(f'  {line}\n' for line in lines)])
        old = self.config.read_text(encoding='utf-8')
        # the first value that is found is taken
        self.config.write_text(text + old, encoding='utf-8')

    def ssh(self, *words: str) -> 'subprocess.CompletedProcess[str]':
        """Run `ssh`, which asks nothing."""
        ssh = (self.programs / 'ssh', '-o', 'BatchMode=yes', *words)
        return run_quietly(ssh, self.environment(dict(os.environ)))

    def processes(self, *names: str) -> dict[int, str]:
        """Return what runs on machines, by the process ids, with commands."""
        return {pid: command_of(pid) for pid in self._inhabitants(*names)}

    def left(self, *names: str) -> list[str]:
        """Return the command lines of all that runs on machines."""
        return [command_of(pid) for pid in self._inhabitants(*names)]

    def wait_until_empty(
        self, *names: str, seconds: float = DEADLINE
    ) -> float:
        """
        Wait until nothing runs on machines, and return how long it took.

        :param names: Those of the machines, none for all of them
        """
        return wait_until_none(lambda: self.left(*names), seconds)

    def start(self) -> None:
        """Start the server, after `switch_off()`."""
        server = program('sshd')
        assert server is not None
        for config in sorted(self.folder.glob('server_config*')):
            argv = [server, '-D', '-f', config, '-E', self._log]
            self._processes.append(start_server(argv))
        deadline = time.monotonic() + DEADLINE
        for machine in self.machines.values():
            while not _listens(machine.port):
                log = self.log
                assert all(p.poll() is None for p in self._processes), log
                assert time.monotonic() < deadline, log
                time.sleep(0.005)

    @property
    def log(self) -> str:
        """What the server wrote."""
        try:
            return self._log.read_text(encoding='utf-8', errors='replace')
        except FileNotFoundError:
            return ''

    def switch_off(self) -> None:
        """
        End the server and all that runs on the machines, with SIGKILL.

        The other side is told, unlike by a machine without power: hold the
        links before to have that.
        """
        servers, self._processes = self._processes, []
        # a session of sshd has no mark before its shell is run
        doomed = [server.pid for server in servers]
        for server in servers:
            doomed += descendants(server.pid)
        while doomed:
            kill(doomed)
            doomed = self._inhabitants()
        for server in servers:
            server.wait()

    def _close(self) -> None:
        self.switch_off()
        self._open.close()

    def _inhabitants(self, *names: str) -> list[int]:
        """Return what runs there, but the server's own sessions."""
        values = [self.machines[n].mark for n in names or self.machines]
        return marked(MARK, *values)

    def _make_keys(self) -> None:
        for name, phrase in (
            ('host_key', ''),
            ('other_host_key', ''),
            ('key', ''),
            ('locked_key', PASSPHRASE),
        ):
            argv = ['ssh-keygen', '-q', '-t', 'ed25519', '-N', phrase]
            file = str(self.folder / name)
            # the weakest derivation, as each test would have to wait for it
            subprocess.run([*argv, '-a', '1', '-f', file], check=True)
        keys = [self._public(name) for name in ('key', 'locked_key')]
        self._write('authorized_keys', ''.join(keys))

    def _public(self, name: str) -> str:
        return (self.folder / f'{name}.pub').read_text(encoding='utf-8')

    def _write_server(self) -> None:
        machines = list(self.machines.values())
        for begin in range(0, len(machines), PORTS):
            some = machines[begin : begin + PORTS]
            self._write(f'server_config{begin:04}', self._configuration(some))

    def _configuration(self, machines: Sequence[SshMachine]) -> str:
        """Return what a process of the server reads."""
        lines = [_SERVER.format(folder=self.folder)]
        lines += [f'Port {one.port}\n' for one in machines]
        python = Path(sys.executable).parent
        for one in machines:
            path = f'{one.home}/bin:{python}:{os.environ["PATH"]}'
            lines += [
                f'Match LocalPort {one.port}\n',
                f'  SetEnv HOME={one.home} XDG_RUNTIME_DIR={one.home} '
                f'PATH={path} {MARK}={one.mark}\n',
            ]
            if one.name == ASKING:
                lines.append('  PubkeyAuthentication no\n')
        return ''.join(lines)

    def _write_client(self, off: int) -> None:
        ports = {name: one.link.port for name, one in self.machines.items()}
        lines = [
            f'Host {name}\n  HostKeyAlias {name}\n  Port {port}\n'
            for name, port in {**ports, OFF: off}.items()
        ]
        names = ' '.join([*self.machines, OFF])
        lines.append(
            _CLIENT.format(
                names=names,
                user=pwd.getpwuid(os.getuid()).pw_name,
                folder=self.folder,
                locked=LOCKED,
            )
        )
        self._write('config', ''.join(lines))
        right, wrong = self._public('host_key'), self._public('other_host_key')
        known = [f'{n} {right}' for n in (*self._names, LOCKED, ASKING, OFF)]
        self._write('known_hosts', ''.join([*known, f'{IMPOSTOR} {wrong}']))
        ssh = program('ssh')
        assert ssh is not None
        words = shlex.join([ssh, '-F', str(self.config)])
        self.programs.mkdir()
        script = self.programs / 'ssh'
        script.write_text(f'#!/bin/sh\nexec {words} "$@"\n', encoding='utf-8')
        script.chmod(0o755)

    def _write(self, name: str, text: str) -> None:
        (self.folder / name).write_text(text, encoding='utf-8')


def _listens(port: int) -> bool:
    with contextlib.suppress(ConnectionRefusedError):
        socket.create_connection((LOOPBACK, port)).close()
        return True
    return False
