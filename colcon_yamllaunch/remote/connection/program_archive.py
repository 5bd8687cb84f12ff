# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The modules that machines are sent, as nothing is installed there.

They are those that the program there imports, found in the sources; it needs
only the standard library besides (a test checks that). The same sources have
the same hash, under which a machine stores them.
"""

from collections.abc import Iterator
from functools import cache
from functools import cached_property
import hashlib
import json
from pathlib import Path
import re
import threading
import zlib

import colcon_yamllaunch
from colcon_yamllaunch.remote.agent.requests import MODULES

_PACKAGE = colcon_yamllaunch.__name__
_ROOT = Path(colcon_yamllaunch.__file__).parent
#: The modules that are run, or requested by name: patterns of files below the
#: package.
_ROOTS = (
    'remote/agent/*.py',
    'remote/sync/colcon_build.py',
    *(f'remote/sync/{name}.py' for name in MODULES),
    # started as programs
    'engine/guard.py',
    'engine/spawn.py',
    'engine/ros_client.py',
)
# an import takes one line, or has its names in parentheses; to parse a hundred
# modules takes half a second
_IMPORT = re.compile(
    rf'^ *(?:from ({_PACKAGE}[\w.]*) import (?:\(\s*)?(\w+)'
    rf'|import ({_PACKAGE}[\w.]*))',
    re.MULTILINE,
)
_LOCK = threading.Lock()
# imported for annotations only
_FOR_TYPES = re.compile(
    r'^( *)if TYPE_CHECKING:\n(?:\1 +.*\n|\n)+', re.MULTILINE
)


class ProgramArchive:
    """
    The modules that a machine is sent.

    :param files: The modules by their paths
    """

    def __init__(self, files: dict[str, str]) -> None:
        self._text = json.dumps(
            files, sort_keys=True, separators=(',', ':')
        ).encode()
        #: Their SHA-256, in hexadecimal digits.
        self.digest = hashlib.sha256(self._text).hexdigest()

    @cached_property
    def data(self) -> bytes:
        """The packed files."""
        return zlib.compress(self._text, 6)


def program_archive() -> ProgramArchive:
    """Return the modules that machines are sent; thread-safe."""
    with _LOCK:
        return _program_archive()


@cache
def _program_archive() -> ProgramArchive:
    return ProgramArchive(
        {f'{_PACKAGE}/{name}': text for name, text in program_files().items()}
    )


def program_files() -> dict[str, str]:
    """Return the modules that run there, by their paths below the package."""
    waiting = [
        path.relative_to(_ROOT).as_posix()
        for pattern in _ROOTS
        for path in _ROOT.glob(pattern)
    ]
    found: dict[str, str] = {}
    while waiting:
        name = waiting.pop()
        if name not in found:
            found[name] = (_ROOT / name).read_text(encoding='utf-8')
            waiting += imported_files(found[name])
            folders = Path(name).parents
            waiting += [(f / '__init__.py').as_posix() for f in folders]
    return found


def imported_files(source: str) -> Iterator[str]:
    """Iterate over the modules of the package that one imports."""
    for match in _IMPORT.finditer(_FOR_TYPES.sub('', source)):
        module, name, whole = match.groups()
        for words in (f'{module}.{name}', module, whole):
            inner = _files().get(words or '')
            if inner is not None:
                yield inner
                break


@cache
def _files() -> dict[str, str]:
    """Return the files of all modules by their names."""
    found = {}
    for path in _ROOT.rglob('*.py'):
        inner = path.relative_to(_ROOT)
        name = '.'.join((_PACKAGE, *inner.with_suffix('').parts))
        found[name.removesuffix('.__init__')] = inner.as_posix()
    return found
