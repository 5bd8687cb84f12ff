# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The pipes and terminals that processes write to."""

from dataclasses import dataclass
import fcntl
import os
import struct
import termios

#: Columns and lines of a terminal when we have none ourselves.
DEFAULT_SIZE = os.terminal_size((80, 24))


@dataclass(frozen=True, slots=True)
class Channel:
    """
    A way for output.

    :param reader: The end that the launcher reads from
    :param writer: The end that becomes a stream of the process
    """

    reader: int
    writer: int


def open_channels(
    terminals: bool, size: os.terminal_size
) -> tuple[Channel, Channel]:
    """
    Make the ways for standard output and standard error.

    :param terminals: Whether they are two terminals instead of two pipes
    :param size: The size of the terminals
    :raises OSError: There are too many open files, for instance
    """
    first = _open_terminal(size) if terminals else Channel(*os.pipe())
    try:
        second = _open_terminal(size) if terminals else Channel(*os.pipe())
    except OSError:
        close(first)
        raise
    return first, second


def close(channel: Channel) -> None:
    """Close both ends."""
    os.close(channel.reader)
    os.close(channel.writer)


def size_of(descriptor: int) -> os.terminal_size:
    """Return the size of a terminal, or :data:`DEFAULT_SIZE`."""
    try:
        size = os.get_terminal_size(descriptor)
    except OSError:
        return DEFAULT_SIZE
    return size if size.columns and size.lines else DEFAULT_SIZE


def _open_terminal(size: os.terminal_size) -> Channel:
    reader, writer = os.openpty()
    fcntl.ioctl(
        writer,
        termios.TIOCSWINSZ,
        struct.pack('HHHH', size.lines, size.columns, 0, 0),
    )
    attributes = termios.tcgetattr(writer)
    # line ends stay as they are written, so that logs are exact
    attributes[1] &= ~termios.ONLCR
    termios.tcsetattr(writer, termios.TCSANOW, attributes)
    return Channel(reader, writer)
