# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What a build reads, as CMake's generators wrote it down.

Documents in a package's source that no CMake file reads do not matter: only
what people read where it lies counts as a document, and only where no word in
the CMake files may mean it: its name, a pattern that fits, a folder that it is
in. In doubt it is a file like any other.
"""

from collections.abc import Callable
from collections.abc import Collection
from collections.abc import Iterable
from collections.abc import Iterator
from fnmatch import fnmatchcase
import os
from pathlib import Path
import re
import struct
import sys

from colcon_yamllaunch.common.text_files import content_of

#: Where documents are, relative to the package.
_FOLDERS = ('', 'doc', 'docs')
_NAMES = re.compile(
    r'(readme|license|licence|copying|notice|authors|contributors|changelog'
    r'|changes|history|contributing|code_of_conduct|security'
    r'|quality_declaration)(\.\w+)?|[^.].*\.(md|rst)',
    re.IGNORECASE,
)
#: What runs programs, which may read whatever they like.
_PROGRAMS = re.compile(
    r'\b(execute_process|exec_program|add_custom_\w+|externalproject_\w+'
    r'|fetchcontent_\w+|try_run)\s*\(',
    re.IGNORECASE,
)
_COMMENT = re.compile(r'^\s*#.*$', re.MULTILINE)
#: Where something is installed to.
_DESTINATION = re.compile(r'\bDESTINATION\s+\S+')
_SEPARATORS = re.compile(r'[\s"\'();<>:=]+')
_VARIABLE = re.compile(r'\$\w*\{[^{}]*\}')
#: The folder of the source itself, or the one around it.
_WHOLE = re.compile(
    r'(\.{1,2}|\$\{\w*(SOURCE_DIR|LIST_DIR|HOME_DIRECTORY)\})[./]*'
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
#: Commands of CMake that read files without writing it down (`file`), or run
#: programs that may.
_READING = re.compile(
    r'(?i)\b((?:file|execute_process|configure_file|add_custom_\w+)\s*\([^)]*)'
)
#: Packages that CMake looks for, and variables of the environment that it
#: reads.
_FINDING = re.compile(r'(?i)\bfind_(?:package|dependency)\s*\(\s*"?([\w.+-]+)')
_FOUND = re.compile(r'(?m)^([\w.+-]+)_DIR:PATH=')
_ENVIRONMENT = re.compile(r'\bENV(?:\{|\s+"?)(\w+)')
#: Commands of CMake and ament_cmake that look for nothing but what they name,
#: and what is meant by these names.
_INSTALLING = frozenset(
    (
        *('add_subdirectory', 'add_test', 'ament_export_dependencies'),
        *('ament_package', 'ament_python_install_package'),
        *('cmake_minimum_required', 'else', 'elseif', 'enable_testing'),
        *('endforeach', 'endif', 'find_package', 'foreach', 'if', 'install'),
        *('message', 'option', 'project', 'set'),
    )
)
_TOOLS = 'ament_cmake'
_COMMAND = re.compile(r'(?m)^\s*(\w+)\s*\(')
_SET = re.compile(r'(?mi)^\s*(?:set|foreach|option)\s*\(\s*(\w+)')
_USED = re.compile(r'\$\{([^}]*)\}')
_OWN_VARIABLES = frozenset(
    (
        *('CMAKE_CURRENT_LIST_DIR', 'CMAKE_CURRENT_SOURCE_DIR'),
        *('CMAKE_PROJECT_NAME', 'CMAKE_SOURCE_DIR', 'PROJECT_NAME'),
        'PROJECT_SOURCE_DIR',
    )
)
#: A path that leads elsewhere, a variable of the environment, one that says
#: where CMake looks, an expression, and what `install` runs.
_ELSEWHERE = re.compile(
    r'\.\.|[\s"(;]/|ENV\{|CMAKE_\w*(?:PATH|ROOT)|\$<|\bCODE\b|\bSCRIPT\b'
)
#: What a shell keeps for itself.
_OF_SHELLS = frozenset(('PWD', 'OLDPWD', 'SHLVL', '_'))
#: Tools and libraries of the machine: what is below comes from installers.
_SYSTEM = ('/usr', '/lib', '/bin', '/opt', '/etc', '/nix', '/snap')


def is_document(relative: str) -> bool:
    """
    Tell whether a file is one that people read and tools do not.

    :param relative: Its path in the package
    """
    folder, _, name = relative.rpartition('/')
    return folder in _FOLDERS and _NAMES.fullmatch(name) is not None


def may_be_meant(relative: str, texts: Iterable[str]) -> bool:
    """
    Tell whether CMake files may read or install a file of the source.

    :param texts: Their texts
    """
    parts = [part.lower() for part in relative.split('/')]
    # a name may be put together from its parts
    parts += [part.partition('.')[0] for part in parts]
    for text in texts:
        if _PROGRAMS.search(text):
            return True
        text = _DESTINATION.sub('', _COMMENT.sub('', text))
        if any(_means(word, parts) for word in _SEPARATORS.split(text)):
            return True
    return False


def _means(word: str, parts: list[str]) -> bool:
    if _WHOLE.fullmatch(word):
        return True
    name = word.rstrip('/').rpartition('/')[2].lower()
    if not _VARIABLE.sub('', name):
        # what the variables are made of stands elsewhere
        return False
    pattern = _VARIABLE.sub('*', name)
    return any(fnmatchcase(part, pattern) for part in parts)


class BuildInputs:
    """
    The files that a package's build reads.

    :param build: The package's folder in the build space
    """

    def __init__(self, source: Path, build: Path) -> None:
        self._source, self._build = source, build
        self._commands = '\n'.join(
            command
            for path in _own_cmake_files(source)
            for command in _READING.findall(_text(path))
        )
        compiled: list[str] = []
        configured: list[str] = []
        self._paths: set[str] = set()
        for path in _written_down(build):
            text, paths = _read(path)
            self._paths.update(paths)
            (configured if path.name in _CONFIGURED else compiled).append(text)
        self._compiled = '\n'.join(compiled)
        self._all = '\n'.join([self._compiled, *configured])

    def reads(self, relative: str) -> bool:
        """Tell whether a source file is read by the build itself."""
        name = os.path.basename(relative)
        return f'/{relative}' in self._all or name in self._commands

    def may_take_in(self, relative: str) -> bool:
        """Tell whether a CMake file may read or install a document."""
        return self.reads(relative) or may_be_meant(
            relative, self._cmake_texts()
        )

    @property
    def has_commands(self) -> bool:
        """Whether the build runs programs beside compilers."""
        return 'add_custom_' in self._commands.lower()

    def compiles(self, relative: str) -> bool:
        """Tell whether the build tool looks after a file by itself."""
        return relative in self._compiled

    def has_header(self, name: str) -> bool:
        """Tell whether a file of this name is read from whatever folder."""
        return f'/{name}\n' in self._compiled

    def outside(self, own: Iterable[Path]) -> list[Path]:
        """
        Return the files that are read from elsewhere.

        :param own: Folders whose files are looked after in another way
        """
        is_own = _below((*_system(), *map(str, own)))
        found = {*_PATH.findall(self._all), *self._paths}
        return [
            Path(path)
            for path in sorted(set(map(os.path.normpath, found)))
            if not is_own(path) and os.path.isfile(path)
        ]

    def variables(self) -> set[str]:
        """
        Return the variables of the environment that CMake looks for.

        They are those that CMake files name, but for those of the machine, and
        those that say where a package is.
        """
        texts = self._cmake_texts()
        found = set(_FOUND.findall(_text(self._build / 'CMakeCache.txt')))
        variables = set()
        for text in texts:
            found.update(_FINDING.findall(text))
            variables.update(_ENVIRONMENT.findall(text))
        for name in found:
            # see find_package() of CMake, and its policies 74 and 144
            variables |= {f'{name}_DIR', f'{name}_ROOT'}
            variables.add(f'{name.upper()}_ROOT')
        return variables - _OF_SHELLS

    def _cmake_texts(self) -> list[str]:
        """Return the CMake files of the workspace that the build reads."""
        is_foreign = _below((*_system(), str(self._build)))
        files = {
            path
            for path in self._paths
            if path.endswith('.cmake') and not is_foreign(path)
        }
        texts = [_text(Path(path)) for path in sorted(files)]
        return [*texts, *map(_text, _own_cmake_files(self._source))]


def only_installs(source: Path, packages: Collection[str]) -> bool:
    """
    Return whether a build certainly takes nothing from other packages.

    That is so if its CMake files do no more than install files of the package,
    with ament_cmake at most, which is not in the workspace.

    :param packages: Packages of the workspace that it needs
    """
    texts = [
        re.sub(r'(?m)#.*', '', _text(path))
        for path in _own_cmake_files(source)
    ]
    text = '\n'.join(texts)
    commands = [name.lower() for name in _COMMAND.findall(text)]
    found = [n for n in _FINDING.findall(text) if n.startswith(_TOOLS)]
    made = _SET.findall(text)
    return (
        bool(commands)
        and _INSTALLING.issuperset(commands)
        # not one whose name is in a variable
        and commands.count('find_package') == len(found)
        and not any(name.startswith(_TOOLS) for name in packages)
        and not any(name.startswith('CMAKE_') for name in made)
        and {*_OWN_VARIABLES, *made}.issuperset(_USED.findall(text))
        and not _ELSEWHERE.search(text)
    )


def _system() -> tuple[str, ...]:
    return (*_SYSTEM, sys.prefix, sys.base_prefix)


def _below(folders: Iterable[str]) -> Callable[[str], bool]:
    known = set(folders)
    known |= {os.path.realpath(path) for path in known}
    prefixes = tuple(f'{path}{os.sep}' for path in known)
    return lambda path: path.startswith(prefixes)


def _own_cmake_files(source: Path) -> Iterator[Path]:
    for folder, _, files in os.walk(source):
        for name in files:
            if name == 'CMakeLists.txt' or name.endswith('.cmake'):
                yield Path(folder, name)


def _written_down(build: Path) -> Iterator[Path]:
    for folder, _, files in os.walk(build):
        for name in files:
            # make collects what compilers write only when it runs again
            if name in _WRITTEN or name.endswith(_RULES_SUFFIX):
                yield Path(folder, name)


def _read(path: Path) -> tuple[str, list[str]]:
    """Return the text of a file, and the absolute paths that stand out."""
    if path.name == _NINJA_DEPENDENCIES:
        words = [
            word.decode('utf-8', errors='replace')
            for word in _ninja_paths(_data(path))
        ]
        text = '\n'.join([*words, ''])
    elif path.name in _RULES or path.name.endswith(_RULES_SUFFIX):
        words = _make_words(_text(path))
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
