# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Run a Python program, and tell which files and folders it looked at.

Setup scripts run such a program. This script is run by the same Python, with
the path of the program and its arguments, and prints JSON: the paths, and
what the program printed. It fails when the program fails or does anything but
look at files, compute and print.
"""

# Each Python has loaded these before it looks for a program. All else has to
# be found where the program would find it.
import io
import os
import sys

#: What such a program may import, and use of `os`: the rest may give it
#: another answer each time.
_IMPORTS = frozenset(('argparse', 'collections', 'os', 'pathlib', 'sys'))
_OS_NAMES = frozenset(('environ', 'path', 'pathsep'))
#: What these import later on, and what is needed here.
_MODULES = (
    'argparse ast collections gettext glob json locale pathlib shutil site'
)
#: Functions by which they look at a file without an audit event.
_SILENT = ('access', 'lstat', 'readlink', 'stat')
#: Audit events (Python's table of them) of looks, and of computing.
_LOOKS = ('open', 'os.listdir', 'os.scandir')
_PURE = ('compile', 'exec', 'object.__getattr__', 'sys._getframe')
_CHANGES = os.O_WRONLY | os.O_RDWR | os.O_CREAT
#: Folders with files whose contents change without their times.
_VIRTUAL = ('/dev/', '/proc/', '/sys/')

_paths: dict[str, None] = {}
_unknown: list[str] = []


class _Noting:
    # a function would become a method as an attribute of a class
    def __init__(self, name: str) -> None:
        self._function = getattr(os, name)

    def __call__(self, path: object, *more: object, **named: object) -> object:
        _note(path)
        return self._function(path, *more, **named)


def _note(path: object) -> None:
    is_path = isinstance(path, (str, bytes, os.PathLike))
    name = os.fsdecode(path) if is_path else ''  # type: ignore[arg-type]
    if not os.path.isabs(name) or name.startswith(_VIRTUAL):
        _unknown.append(f'a look at {path!r}')
    _paths[name] = None


def _on_event(event: str, arguments: tuple[object, ...]) -> None:
    flags = arguments[-1] if event == 'open' else 0
    if event in _LOOKS and isinstance(flags, int) and not flags & _CHANGES:
        _note(arguments[0])
    elif event not in _PURE:
        _unknown.append(event)


def _note_start() -> None:
    """Note what Python looks at before it runs a program."""
    import glob
    import site

    _note(sys.executable)
    _note(f'{sys.prefix}/pyvenv.cfg')
    for folder in {
        *map(os.path.abspath, sys.path),
        site.getusersitepackages(),
    }:
        _note(folder)
        for name in ('*.pth', '*customize.py'):
            for path in glob.glob(f'{glob.escape(folder)}/{name}'):
                _note(path)


def _check(text: bytes) -> None:
    """Note what a program uses that it may not."""
    import ast

    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            _unknown.extend({name.name for name in node.names} - _IMPORTS)
        elif isinstance(node, ast.ImportFrom):
            _unknown.extend({str(node.module)} - (_IMPORTS - {'os', 'sys'}))
        elif isinstance(node, ast.Attribute) and (
            isinstance(node.value, ast.Name) and node.value.id == 'os'
        ):
            _unknown.extend({node.attr} - _OS_NAMES)


def main() -> None:
    """Run the program that the command line names."""
    program = sys.argv[1]
    sys.argv = sys.argv[1:]
    if not getattr(sys.flags, 'safe_path', False):
        sys.path[0] = os.path.dirname(program)
    for name in _SILENT:
        setattr(os, name, _Noting(name))
    # some versions of pathlib keep the functions of `os` that they find
    modules = {name: __import__(name) for name in _MODULES.split()}
    _paths.clear()
    _unknown.clear()
    _note_start()
    for module in modules.values():
        _note(module.__file__)
    with open(program, 'rb') as file:
        text = file.read()
    _check(text)
    real, sys.stdout = sys.stdout, io.StringIO()
    sys.addaudithook(_on_event)
    _note(program)
    try:
        code = compile(text, program, 'exec')
        exec(code, {'__name__': '__main__', '__file__': program})
    except SystemExit as e:
        if e.code:
            raise
    printed, sys.stdout = sys.stdout.getvalue(), real
    if _unknown:
        sys.exit(f'{program} does more than to look at files: {_unknown[0]}')
    print(modules['json'].dumps([list(_paths), printed]))


if __name__ == '__main__':
    main()
