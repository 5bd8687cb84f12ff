# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A network between two ports of this machine that can be made worse."""

import asyncio
from collections.abc import Callable
import contextlib
import socket
import struct
import threading

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
