# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The files that a build reads, from the files that CMake generated.

make and Ninja list all files that they compare; CMake lists the files that it
read itself in `Makefile.cmake` or `build.ninja`.
"""

from collections.abc import Callable, Iterable
import os
from pathlib import Path
import re
import struct
import sys

from colcon_yamllaunch.common.files import content_of
from colcon_yamllaunch.workspace.packages.build_files import (
    cmake_texts,
    may_be_named,
    reading_commands,
    searched_names,
)

#: What the compilers read; CMake's own inputs are in the other ones.
_COMPILED = frozenset(('build.make', 'build.ninja'))
_CONFIGURED = frozenset(('Makefile', 'Makefile.cmake'))
#: Rules for make and nothing else; so are the files that compilers write.
_RULES = frozenset(('depend.make', 'compiler_depend.make'))
_RULES_SUFFIX = '.d'
_NINJA_DEPENDENCIES = '.ninja_deps'
#: Bytes; what a build of many thousand files writes down is far below.
_LARGEST = 1 << 30
_WRITTEN = {*_COMPILED, *_CONFIGURED, *_RULES, _NINJA_DEPENDENCIES}
#: Ninja's file begins with a line and a version, then has records with their
#: sizes; the highest bit tells those that are no paths (ninja, deps_log.h).
_NINJA_HEADER = 16
_NINJA_NO_PATH = 0x80000000
#: A path in a command, as far as it has nothing unusual in it.
_PATH = re.compile(r'(?<![\w./$}-])/[^\s:"\'\\;$()]+')
#: The same in a list of CMake.
_QUOTED = re.compile(r'"(/[^"\n]+)"')
#: A word of a rule, for make and for Ninja; they escape what separates words.
_MAKE_WORD = re.compile(r'(?:[^\s\\]|\\.)+')
_NINJA_WORD = re.compile(r'(?:[^\s$|:]|\$.)+')
#: What make takes for itself in a word, and the commands of a rule.
_MAKE_ESCAPE = re.compile(r'\\([\s#:\\])')
_MAKE_COMMAND = re.compile(r'(?m)^\t.*$')
_FOUND = re.compile(r'(?m)^([\w.+-]+)_DIR:PATH=')
#: What a shell keeps for itself.
_OF_SHELLS = frozenset(('PWD', 'OLDPWD', 'SHLVL', '_'))
#: Tools and libraries of the machine: what is below comes from installers.
_SYSTEM = ('/usr', '/lib', '/bin', '/opt', '/etc', '/nix', '/snap')


class BuildInputs:
    """
    The files that a package's build reads.

    :param build: The package's folder in the build space
    """

    def __init__(self, source: Path, build: Path) -> None:
        self._source, self._build = source, build
        self._commands = reading_commands(source)
        compiled: list[str] = []
        configured: list[str] = []
        self._paths: set[str] = set()
        for folder, _, files in os.walk(build):
            for name in files:
                # make collects what compilers write only when it runs again
                if name in _WRITTEN or name.endswith(_RULES_SUFFIX):
                    text, paths = _read(Path(folder, name))
                    self._paths.update(paths)
                    is_configured = name in _CONFIGURED
                    (configured if is_configured else compiled).append(text)
        self._compiled = '\n'.join(compiled)
        self._all = '\n'.join([self._compiled, *configured])

    def reads(self, relative: str) -> bool:
        """Return whether a source file is read by the build itself."""
        name = os.path.basename(relative)
        return f'/{relative}' in self._all or any(
            name in argument
            for command in self._commands
            for argument in command.arguments
        )

    def may_use(self, relative: str) -> bool:
        """Return whether a CMake file may read or install a document."""
        return self.reads(relative) or may_be_named(
            relative, self._cmake_texts()
        )

    @property
    def has_commands(self) -> bool:
        """Whether the build runs programs beside compilers."""
        return any(c.name.startswith('add_custom_') for c in self._commands)

    def compiles(self, relative: str) -> bool:
        """Return whether the build tool itself checks a file for changes."""
        return relative in self._compiled

    def has_header(self, name: str) -> bool:
        """Return whether the build reads a file of this name anywhere."""
        return f'/{name}\n' in self._compiled

    def external_files(self, own: Iterable[Path]) -> list[Path]:
        """
        Return the files outside the package that the build reads.

        :param own: Folders whose files are checked in another way
        """
        is_own = _below_system_or(own)
        found = {*_PATH.findall(self._all), *self._paths}
        return [
            Path(path)
            for path in sorted(set(map(os.path.normpath, found)))
            if not is_own(path) and os.path.isfile(path)
        ]

    def variables(self) -> set[str]:
        """
        Return the variables of the environment that CMake looks for.

        They are the variables that CMake files outside the system name, and
        those that tell where a package is.
        """
        found = set(_FOUND.findall(_text(self._build / 'CMakeCache.txt')))
        variables = set()
        for text in self._cmake_texts():
            packages, names = searched_names(text)
            found |= packages
            variables |= names
        for name in found:
            # see find_package() of CMake, and its policies 74 and 144
            variables |= {f'{name}_DIR', f'{name}_ROOT'}
            variables.add(f'{name.upper()}_ROOT')
        return variables - _OF_SHELLS

    def _cmake_texts(self) -> list[str]:
        """Return the CMake files of the workspace that the build reads."""
        is_foreign = _below_system_or([self._build])
        files = {
            path
            for path in self._paths
            if path.endswith('.cmake') and not is_foreign(path)
        }
        texts = [_text(Path(path)) for path in sorted(files)]
        return [*texts, *cmake_texts(self._source)]


def _below_system_or(folders: Iterable[Path]) -> Callable[[str], bool]:
    """Return whether a path is below a folder of the system, or another."""
    known = {*_SYSTEM, sys.prefix, sys.base_prefix, *map(str, folders)}
    known |= {os.path.realpath(path) for path in known}
    prefixes = tuple(f'{path}{os.sep}' for path in known)
    return lambda path: path.startswith(prefixes)


def _read(path: Path) -> tuple[str, list[str]]:
    """Return the text of a file, and the absolute paths in its rules."""
    is_rules = path.name in _RULES or path.name.endswith(_RULES_SUFFIX)
    if is_rules or path.name == _NINJA_DEPENDENCIES:
        words = _make_words(_text(path)) if is_rules else _ninja_paths(path)
        text = '\n'.join([*words, ''])
    else:
        raw = _text(path)
        if path.name == 'build.ninja':
            lines = [w for w in raw.splitlines() if w.startswith('build ')]
            found = _NINJA_WORD.findall('\n'.join(lines))
            words = [re.sub(r'\$(.)', r'\1', word) for word in found]
        else:
            rules = _MAKE_COMMAND.sub('', raw)
            words = [*_make_words(rules), *_QUOTED.findall(raw)]
        text = raw.replace('\\ ', ' ').replace('\\#', '#')
        text = text.replace('$ ', ' ').replace('$$', '$')
    return text, [word for word in words if word.startswith('/')]


def _make_words(text: str) -> list[str]:
    words: list[str] = []
    for line in text.replace('\\\n', ' ').split('\n'):
        if '\\' not in line and '$' not in line:
            # most lines, and by far the fastest way
            words += line.split()
        else:
            words += (
                _MAKE_ESCAPE.sub(r'\1', word).replace('$$', '$')
                for word in _MAKE_WORD.findall(line)
            )
    return [word.removesuffix(':') for word in words]


def _data(path: Path) -> bytes:
    try:
        return content_of(path, _LARGEST)
    except OSError:
        return b''


def _text(path: Path) -> str:
    return _data(path).decode('utf-8', errors='replace')


def _ninja_paths(path: Path) -> list[str]:
    data, position = _data(path), _NINJA_HEADER
    paths = []
    while position + 4 <= len(data):
        (size,) = struct.unpack_from('<I', data, position)
        position += 4
        if size & _NINJA_NO_PATH:
            size &= ~_NINJA_NO_PATH
        else:
            # up to three zeros, and a checksum
            word = data[position : position + size - 4].rstrip(b'\0')
            paths.append(word.decode('utf-8', errors='replace'))
        position += size
    return paths
