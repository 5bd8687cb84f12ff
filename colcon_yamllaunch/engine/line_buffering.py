# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Programs in C and C++ that show a line when it ends, also in a pipe.

The C library collects what goes to a pipe until a buffer is full, so what a
node prints would show late, and be lost in a crash. The `stdbuf` command of
GNU coreutils has a library against that: the dynamic linker loads it where
`LD_PRELOAD` says so, and it calls setvbuf() as `_STDBUF_O` says, before the
program begins. `std::cout` writes through the same buffer.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
import os
import stat
import struct

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.engine import events, limits
from colcon_yamllaunch.engine.loop import Loop, TimerHandle
from colcon_yamllaunch.engine.spawn import find_program, StartError
from colcon_yamllaunch.plan.plan import Process

#: `0` leaves the buffers of programs as they are.
LINE_BUFFERED_VARIABLE = 'COLCON_LAUNCH_LINE_BUFFERED'

_PRELOAD = 'LD_PRELOAD'
_LIBRARY = 'libstdbuf.so'
#: Where it is, seen from the folder of `stdbuf`; see stdbuf.c of coreutils.
_FOLDERS = ('', '../libexec/coreutils', '../lib/coreutils')
#: The C library that it was made for; that of musl has another name.
_GLIBC = 'libc.so.6'
_CPP = 'libstdc++.so'
#: They refuse to be loaded after another library, or do not work then.
_SANITIZERS = tuple(f'lib{kind}san.so' for kind in ('a', 'hwa', 'l', 't', 'm'))

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


class LineBuffering:
    """
    Lets programs show a line when it ends, where that is possible.

    :param path: Where `stdbuf` is looked for: folders, separated by colons
    """

    def __init__(self, path: str) -> None:
        self._path = path
        # those that may hold lines back, and whether they are in C++
        self._holding: dict[str, bool] = {}

    def variables(
        self,
        process: Process,
        argv: Sequence[str],
        environment: Mapping[str, str],
    ) -> Mapping[str, str]:
        """
        Return the variables that a process gets for it.

        :param argv: Its command line
        :param environment: Its environment without them
        """
        self._holding.pop(process.label, None)
        is_off = environment.get(LINE_BUFFERED_VARIABLE) == '0'
        if process.emulate_tty or is_off:
            return {}
        path = _path_of(argv[0], process.cwd, environment)
        program = path and read_elf(path)
        if not program:
            return {}
        # behind a prefix such as nice, it is an argument
        others = [read_elf(a) for a in argv[1:] if a.startswith('/')]
        programs = [program, *filter(None, others)]
        needed = [name for p in programs for name in p.needed]
        library = self._library
        if (
            library is not None
            and library[1].kind == program.kind
            and _GLIBC in program.needed
            and not environment.get(_PRELOAD)
            and not any(name.startswith(_SANITIZERS) for name in needed)
        ):
            return {_PRELOAD: library[0], '_STDBUF_O': 'L'}
        if needed:
            is_cpp = any(name.startswith(_CPP) for name in needed)
            self._holding[process.label] = is_cpp
        return {}

    def holds_back(self, process: Process) -> bool:
        """Return whether a process may hold lines back since its start."""
        return process.label in self._holding

    def is_cpp(self, process: Process) -> bool:
        """Return whether a process is in C++ and may hold lines back."""
        return self._holding.get(process.label, False)

    @cached_property
    def _library(self) -> tuple[str, Elf] | None:
        """The path of the library of `stdbuf`, and what it is made for."""
        try:
            stdbuf = os.path.realpath(find_program('stdbuf', self._path))
        except StartError:
            return None
        for folder in _FOLDERS:
            found = os.path.join(os.path.dirname(stdbuf), folder, _LIBRARY)
            found = os.path.normpath(found)
            library = read_elf(found)
            # these separate libraries
            if library is not None and not set(' :') & set(found):
                return found, library
        return None


class SilenceWatch:
    """
    Warns, once in a launch, of a process that may hold back all its output.

    :param holds_back: Returns whether a process may
    :param emit: Receives the warning
    """

    def __init__(
        self,
        holds_back: Callable[[Process], bool],
        loop: Loop,
        emit: events.Listener,
    ) -> None:
        self._holds_back = holds_back
        self._loop = loop
        self._emit = emit
        self._silent: dict[str, TimerHandle] = {}
        self._is_over = False

    def handle(self, event: events.Event) -> None:
        """Handle an event."""
        if isinstance(event, events.Started):
            if not self._is_over and self._holds_back(event.process):
                self._silent[event.process.label] = self._loop.call_later(
                    limits.SILENCE_WARNING_DELAY, self._warn, event.process
                )
        elif self._silent and isinstance(event, events.Output | events.Exited):
            handle = self._silent.pop(event.process.label, None)
            if handle is not None:
                handle.cancel()

    def _warn(self, process: Process) -> None:
        self._is_over = True
        for handle in self._silent.values():
            handle.cancel()
        self._silent.clear()
        self._emit(events.Silent(process, limits.SILENCE_WARNING_DELAY))


def _path_of(
    name: str, cwd: str, environment: Mapping[str, str]
) -> str | None:
    if '/' not in name:
        try:
            name = find_program(name, environment.get('PATH', os.defpath))
        except StartError:
            # it is reported when it is started
            return None
    return os.path.join(cwd, name)


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
