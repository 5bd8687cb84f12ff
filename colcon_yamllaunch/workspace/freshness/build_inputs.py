# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a build reads, as CMake's generators wrote it down."""

from collections.abc import Iterable
from collections.abc import Iterator
import os
from pathlib import Path
import re
import struct
import sys

from colcon_yamllaunch.common.text_files import content_of

#: What the compilers read; CMake's own inputs are in the other ones.
_COMPILED = frozenset(
    ('build.make', 'depend.make', 'compiler_depend.make', 'build.ninja')
)
_CONFIGURED = frozenset(('Makefile', 'Makefile.cmake'))
_NINJA_DEPENDENCIES = '.ninja_deps'
#: Bytes; what a build of many thousand files writes down is far below.
_LARGEST = 1 << 30
_WRITTEN = {*_COMPILED, *_CONFIGURED, _NINJA_DEPENDENCIES}
#: Ninja's file begins with a line and a version, then has records with their
#: sizes; the highest bit tells those that are no paths (ninja, deps_log.h).
_NINJA_HEADER = 16
_NINJA_NO_PATH = 0x80000000
_PATH = re.compile(r'(?<![\w./$}-])/(?:[^\s:"\'\\;$()]|\\ )+')
#: Commands of CMake that read files without writing it down (`file`), or run
#: programs that may.
_READING = re.compile(
    r'\b((?:file|execute_process|configure_file|add_custom_\w+)\s*\([^)]*)',
    re.IGNORECASE,
)
#: Tools and libraries of the machine: what is below comes from installers.
_SYSTEM = ('/usr', '/lib', '/bin', '/opt', '/etc', '/nix', '/snap')


class BuildInputs:
    """
    The files that a package's build reads.

    :param build: The package's folder in the build space
    """

    def __init__(self, source: Path, build: Path) -> None:
        self._commands = _reading_commands(source)
        compiled, configured = [], []
        for path in _written_down(build):
            if path.name in _CONFIGURED:
                configured.append(_text(path))
            else:
                compiled.append(_text(path))
        self._compiled = '\n'.join(compiled)
        self._all = '\n'.join([self._compiled, *configured])

    def reads(self, relative: str) -> bool:
        """Tell whether a source file is read by the build itself."""
        name = os.path.basename(relative)
        return f'/{relative}' in self._all or name in self._commands

    @property
    def has_commands(self) -> bool:
        """Whether the build runs programs beside compilers."""
        return 'add_custom_' in self._commands.lower()

    def compiles(self, relative: str) -> bool:
        """Tell whether the build tool looks after a file by itself."""
        return relative in self._compiled

    def outside(self, own: Iterable[Path]) -> list[Path]:
        """
        Return the files that are read from elsewhere.

        :param own: Folders whose files are looked after in another way
        """
        known = {*_SYSTEM, sys.prefix, sys.base_prefix, *map(str, own)}
        known |= {os.path.realpath(path) for path in known}
        prefixes = tuple(f'{path}{os.sep}' for path in known)
        found = {os.path.normpath(p) for p in _PATH.findall(self._all)}
        return [
            Path(path)
            for path in sorted(found)
            if not path.startswith(prefixes) and os.path.isfile(path)
        ]


def _reading_commands(source: Path) -> str:
    commands = []
    for folder, _, files in os.walk(source):
        for name in files:
            if name == 'CMakeLists.txt' or name.endswith('.cmake'):
                commands += _READING.findall(_text(Path(folder, name)))
    return '\n'.join(commands)


def _written_down(build: Path) -> Iterator[Path]:
    for folder, _, files in os.walk(build):
        for name in files:
            # make collects what compilers write only when it runs again
            if name in _WRITTEN or name.endswith('.d'):
                yield Path(folder, name)


def _text(path: Path) -> str:
    try:
        data = content_of(path, _LARGEST)
    except OSError:
        return ''
    if path.name == _NINJA_DEPENDENCIES:
        data = b'\n'.join(_ninja_paths(data))
    text = data.decode('utf-8', errors='replace')
    # make and Ninja escape blanks in paths
    return text.replace('\\ ', ' ').replace('$ ', ' ')


def _ninja_paths(data: bytes) -> Iterator[bytes]:
    position = _NINJA_HEADER
    while position + 4 <= len(data):
        (size,) = struct.unpack_from('<I', data, position)
        position += 4
        if size & _NINJA_NO_PATH:
            size &= ~_NINJA_NO_PATH
        else:
            # up to three zeros, and a checksum
            yield data[position : position + size - 4].rstrip(b'\0')
        position += size
