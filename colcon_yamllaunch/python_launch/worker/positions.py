# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Where launch files say what they say."""

from __future__ import annotations

import ast
from collections.abc import Iterable
import contextlib
import importlib
import linecache
import os
import re
import sys
import sysconfig
from types import CodeType, FrameType
from typing import Any, NamedTuple

#: The attribute that keeps the place where an object was made.
_PLACE = '_launch_worker_place'
#: The attribute that keeps a place that was told.
_POSITION = '_launch_worker_position'
#: Folders of packages that are installed; what is in them is not the user's,
#: unless it is below the prefix of a package of the workspace.
_INSTALLED = (
    f'{os.sep}site-packages{os.sep}',
    f'{os.sep}dist-packages{os.sep}',
)
_ROS_PACKAGES = (
    'launch',
    'launch_ros',
    'launch_xml',
    'launch_yaml',
    'osrf_pycommon',
    'ament_index_python',
)


class CodePlace(NamedTuple):
    """A piece of a file; lines and columns from 1, its end behind it."""

    line: int
    column: int
    end_line: int
    end_column: int


class Positions:
    """Knows where in the user's files things were made."""

    def __init__(self) -> None:
        #: The launch files in Python.
        self.files: set[str] = set()
        #: What stands for all that has no place, such as what YAML says.
        self.otherwise: list[object] | None = None
        self._prefixes: tuple[str, ...] = ()
        self._users: dict[str, bool] = {}
        self._foreign = (
            os.path.dirname(os.path.abspath(__file__)) + os.sep,
            sysconfig.get_path('stdlib') + os.sep,
            os.path.dirname(os.__file__) + os.sep,
        )
        self._places: dict[
            tuple[int, int], tuple[CodeType, CodePlace | None]
        ] = {}
        #: The positions of all instructions, by the identity of their code.
        self._instructions: dict[int, tuple[CodeType, list[Any]]] = {}
        self._mapping_keys: dict[str, list[ast.Constant]] = {}

    def set_prefixes(self, prefixes: Iterable[str]) -> None:
        """Record the prefixes of the packages of the workspace."""
        self._prefixes = tuple(f'{prefix}{os.sep}' for prefix in prefixes)
        self._users.clear()

    def forget(self) -> None:
        """Begin anew: modules of the user may have changed, or have state."""
        folders = {os.path.dirname(file) + os.sep for file in self.files}
        for name, module in list(sys.modules.items()):
            path = getattr(module, '__file__', None)
            if isinstance(path, str) and path.startswith(
                (*self._prefixes, *folders)
            ):
                del sys.modules[name]
        importlib.invalidate_caches()
        linecache.clearcache()
        self._mapping_keys.clear()
        self._places.clear()
        self._instructions.clear()

    def add_file(self, path: str) -> None:
        """Record a launch file in Python."""
        self.files.add(path)
        self._users[path] = True

    def is_users(self, path: str) -> bool:
        """Return whether a file belongs to the user, not to ROS or Python."""
        known = self._users.get(path)
        if known is None:
            known = self._users[path] = self._is_users(path)
        return known

    def _is_users(self, path: str) -> bool:
        if path in self.files or path.startswith(self._prefixes):
            return True
        if not path.endswith('.py') or path.startswith(self._foreign):
            return False
        if any(folder in path for folder in _INSTALLED):
            return False
        return not any(
            path.startswith(os.path.dirname(file) + os.sep)
            for file in (
                getattr(sys.modules.get(name), '__file__', None)
                for name in _ROS_PACKAGES
            )
            if file is not None
        )

    def note(self, made: object) -> None:
        """Note where in the user's files an object is being made."""
        frame = self._users_frame()
        if frame is not None:
            place = (frame.f_code, frame.f_lasti, frame.f_lineno)
            with contextlib.suppress(AttributeError):
                setattr(made, _PLACE, place)

    def put(self, made: object, position: list[object]) -> None:
        """Set the position of an object, wherever it was created."""
        with contextlib.suppress(AttributeError):
            setattr(made, _POSITION, position)

    def here(self) -> list[object] | None:
        """Return the position of the user's code that runs, if any does."""
        frame = self._users_frame()
        if frame is None:
            return None
        return self._position(frame.f_code, frame.f_lasti, frame.f_lineno)

    def _users_frame(self) -> FrameType | None:
        """Return the innermost frame of a launch file, or of the user's."""
        users: FrameType | None = None
        frame: FrameType | None = sys._getframe(2)
        while frame is not None:
            path = frame.f_code.co_filename
            if path in self.files:
                return frame
            if users is None and self.is_users(path):
                users = frame
            frame = frame.f_back
        return users

    def pass_on(self, other: object, made: object) -> None:
        """Copy the position of an object to one without."""
        place = getattr(other, _PLACE, None)
        if place is not None and not hasattr(made, _PLACE):
            with contextlib.suppress(AttributeError):
                setattr(made, _PLACE, place)

    def of(self, *made: object) -> list[object] | None:
        """Return the position of the first object that has one, or None."""
        return self.place(*made) or self.otherwise

    def place(self, *made: object) -> list[object] | None:
        """Return the position of the first object with one of its own."""
        for one in made:
            told: list[object] | None = getattr(one, _POSITION, None)
            if told is not None:
                return told
            place = getattr(one, _PLACE, None)
            if place is not None:
                return self._position(*place)
        return None

    def of_function(self, path: str, name: str) -> list[object]:
        """Return the position of a function's name, or the file's start."""
        pattern = re.compile(rf'(?:async +)?def +(?={re.escape(name)}\b)')
        for number, line in enumerate(linecache.getlines(path), 1):
            match = pattern.match(line)
            if match is not None:
                return [path, number, match.end() + 1]
        return [path, 1, 1]

    def _position(
        self, code: CodeType, lasti: int, line: int
    ) -> list[object] | None:
        path = code.co_filename
        found = self.in_code(code, lasti)
        if found is not None:
            return [self.shown(path), found.line, found.column]
        source = linecache.getline(path, line)
        return [self.shown(path), line, len(source) - len(source.lstrip()) + 1]

    def shown(self, path: str) -> str:
        """Return the path of a file that the user knows it by."""
        # `colcon build --symlink-install` links modules from elsewhere
        return path if path in self.files else os.path.realpath(path)

    def end_column(self, made: object) -> int | None:
        """Return where the call ends that made an object, on its line."""
        place = getattr(made, _PLACE, None)
        if hasattr(made, _POSITION):
            return None
        found = None if place is None else self.in_code(*place[:2])
        if found is None or found.line != found.end_line:
            return None
        return found.end_column

    def of_parameter(self, made: object, name: str) -> list[object] | None:
        """Return the position of a parameter that an object is made with."""
        place = getattr(made, _PLACE, None)
        if place is None or hasattr(made, _POSITION):
            return self.of(made)
        code, lasti, _ = place
        call = self.in_code(code, lasti)
        if call is not None:
            last = name.rpartition('.')[2]
            for key in self._keys(code.co_filename):
                if call.line <= key.lineno <= call.end_line and (
                    key.value in (name, last)
                ):
                    path, line = code.co_filename, key.lineno
                    column = _column(path, line, key.col_offset)
                    return [self.shown(path), line, column]
        return self.of(made)

    def in_code(self, code: CodeType, lasti: int) -> CodePlace | None:
        """Return the place of an instruction, where Python knows it."""
        # code is compared by what it says, which takes long
        key = (id(code), lasti)
        if key not in self._places:
            self._places[key] = (code, self._in_code(code, lasti))
        return self._places[key][1]

    def _in_code(self, code: CodeType, lasti: int) -> CodePlace | None:
        known = self._instructions.get(id(code))
        if known is None:
            # from 3.11 on
            all_positions: Any = getattr(code, 'co_positions', tuple)
            known = self._instructions[id(code)] = code, list(all_positions())
        found = known[1][lasti // 2 : lasti // 2 + 1]
        if not found or None in found[0]:
            return None
        line, end_line, column, end_column = found[0]
        path = code.co_filename
        return CodePlace(
            line,
            _column(path, line, column),
            end_line,
            _column(path, end_line, end_column),
        )

    def _keys(self, path: str) -> list[ast.Constant]:
        """Return the texts that are keys of mappings in a file."""
        if path not in self._mapping_keys:
            try:
                tree = ast.parse(''.join(linecache.getlines(path)))
            except (SyntaxError, ValueError):
                tree = ast.Module([], [])
            self._mapping_keys[path] = [
                key
                for node in ast.walk(tree)
                if isinstance(node, ast.Dict)
                for key in node.keys
                if isinstance(key, ast.Constant) and isinstance(key.value, str)
            ]
        return self._mapping_keys[path]


def _column(path: str, line: int, offset: int) -> int:
    """Return a column in characters from 1, for an offset in bytes."""
    source = linecache.getline(path, line)
    if source.isascii():
        return offset + 1
    return len(source.encode()[:offset].decode(errors='replace')) + 1
