# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a compiled program needs, as the file says for the dynamic linker."""

from collections.abc import Iterator
import os
import stat
import struct

from colcon_yamllaunch.common.frozen import dataclass

# elf(5): kinds of segments and of dynamic entries
_LOADED = 1
_DYNAMIC = 2
_NEEDED = 1
_STRINGS = 5
#: Bytes of the shortest header.
_HEAD = 52
#: Bytes of a file that tell one thing about it; there are far less.
_LARGEST = 1 << 16
#: Bytes of the longest name of a library.
_NAME = 256


@dataclass(frozen=True, slots=True)
class Elf:
    """
    A program or library.

    :param kind: The machine that it is for, as the file has it
    :param needed: The libraries that it names itself, such as `libc.so.6`
    """

    kind: bytes
    needed: tuple[str, ...]


def read_elf(path: str) -> Elf | None:
    """Read what a file says of itself; None if it is nothing of the kind."""
    try:
        # to open a pipe or a device may wait, or do something
        if not stat.S_ISREG(os.stat(path).st_mode):
            return None
        descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    except (OSError, ValueError):
        return None
    try:
        return _read(descriptor)
    except (OSError, OverflowError, struct.error):
        return None
    finally:
        os.close(descriptor)


def _read(descriptor: int) -> Elf | None:
    head = os.pread(descriptor, 64, 0)
    if head[:4] != b'\x7fELF' or len(head) < _HEAD:
        return None
    wide = head[4] == 2
    order = '<' if head[5] == 1 else '>'
    word = 'Q' if wide else 'I'
    (start,) = struct.unpack_from(order + word, head, 32 if wide else 28)
    size, count = struct.unpack_from(f'{order}HH', head, 54 if wide else 42)
    segment = struct.Struct(f'{order}II6{word}')
    table = os.pread(descriptor, min(size * count, _LARGEST), start)
    loaded: list[tuple[int, int, int]] = []
    entries: list[tuple[int, int]] = []
    for at in range(0, len(table) - segment.size + 1, max(size, segment.size)):
        fields = segment.unpack_from(table, at)
        # the flags stand at another place
        offset, address = fields[2:4] if wide else fields[1:3]
        length = fields[5] if wide else fields[4]
        if fields[0] == _LOADED:
            loaded.append((address, offset, length))
        elif fields[0] == _DYNAMIC:
            data = os.pread(descriptor, min(length, _LARGEST), offset)
            entry = struct.Struct(f'{order}2{word}')
            usable = len(data) // entry.size * entry.size
            entries += entry.iter_unpack(data[:usable])
    names = _names(descriptor, loaded, entries)
    return Elf(head[4:6] + head[18:20], tuple(names))


def _names(
    descriptor: int,
    loaded: list[tuple[int, int, int]],
    entries: list[tuple[int, int]],
) -> Iterator[str]:
    for table in (value for tag, value in entries if tag == _STRINGS):
        for address, offset, length in loaded:
            if address <= table < address + length:
                start = table - address + offset
                for tag, value in entries:
                    if tag == _NEEDED:
                        name = os.pread(descriptor, _NAME, start + value)
                        yield os.fsdecode(name.partition(b'\0')[0])
