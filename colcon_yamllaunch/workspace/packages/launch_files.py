# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Choosing a launch file of a package."""

from collections.abc import Sequence
from operator import eq
from pathlib import Path, PurePosixPath
import re

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.files import text_of
from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.common.suggestions import nearest_first
from colcon_yamllaunch.workspace.packages.package import source_files

#: The names of launch files end in these, longer ones first.
LAUNCH_SUFFIXES = (
    '.launch.yaml',
    '.launch.yml',
    '.launch.xml',
    '.launch.py',
    '.yaml',
    '.yml',
    '.xml',
    '.py',
    # XML, mostly
    '.launch',
)
_YAML_SUFFIXES = ('.yaml', '.yml')
# compiled on use, as few launches look for launch files
_LAUNCH = r'(?m)^\s*[\'"]?launch[\'"]?\s*:|<launch\b'
_PYTHON_LAUNCH = r'(?m)^def generate_launch_description\b'
_MANIFEST = 'package.xml'
# how many names a message lists at most
_LISTED = 10
_PARAMETER_FOLDERS = frozenset(('config', 'cfg', 'param', 'params'))


def find_launch_files(folder: Path) -> tuple[str, ...]:
    """
    Find what may be a launch file of a package, likely ones first.

    Outside of folders named `launch` a file that ends in `.py` must end in
    `.launch.py` to count. The paths are relative to the folder.

    :param folder: The package's source or its share folder
    """
    files = [
        path.as_posix()
        for path in (Path(name) for name, _ in source_files(folder))
        if _may_be_launch_file(path)
    ]
    return tuple(sorted(files, key=lambda f: (not _is_likely(f), f)))


def checkable_launch_files(folder: Path) -> tuple[str, ...]:
    """
    Find what is certainly a launch file.

    A file in a folder `launch` has to look like one, as parameters and modules
    of Python may lie there, too.

    :param folder: As for :func:`find_launch_files`
    """
    found = []
    for file in find_launch_files(folder):
        pattern = _PYTHON_LAUNCH if file.endswith('.py') else _LAUNCH
        if _is_likely(file) and (
            '.launch.' in file or re.search(pattern, text_of(folder / file))
        ):
            found.append(file)
    return tuple(found)


def launch_file_names(package: str, files: Sequence[str]) -> list[str]:
    """
    Return the shortest names that mean the likely launch files of a package.

    Each is the name with extension if that is clear, else the path; without
    likely ones they are those of all files.

    :param files: As :func:`find_launch_files` returns them
    """
    names = []
    for file in likely_ones(files):
        name = PurePosixPath(file).name
        try:
            is_clear = choose_launch_file(package, files, name) == file
        except UserError:
            is_clear = False
        names.append(name if is_clear else file)
    return names


def likely_ones(files: Sequence[str]) -> list[str]:
    """
    Return what to offer of what may be launch files.

    Those in folders where parameters are kept by custom are none.
    """
    return [f for f in files if _is_likely(f)] or [
        f
        for f in files
        if _PARAMETER_FOLDERS.isdisjoint(PurePosixPath(f).parent.parts)
    ]


def choose_launch_file(package: str, files: Sequence[str], wanted: str) -> str:
    """
    Choose the launch file that the user means.

    It may be named by its path in the package, by the end of this path, and
    without extension. A likely launch file goes before another YAML file.

    :param files: As :func:`find_launch_files` returns them
    :param wanted: What the user gave
    :raises UserError: when none or more than one fits
    """
    name = PurePosixPath(wanted).as_posix()
    for matches in (eq, _is_end, _is_end_without_suffix):
        fitting = [f for f in files if matches(f, name)]
        fitting = [f for f in fitting if _is_likely(f)] or fitting
        fitting = [f for f in fitting if f.endswith(_YAML_SUFFIXES)] or fitting
        if len(fitting) == 1:
            return fitting[0]
        if fitting:
            raise UserError(
                f"'{wanted}' may be one of several launch files of {package}",
                f'name one by its path:{_lines(fitting)}',
            )
    likely = likely_ones(files)
    if not likely:
        raise UserError(
            f'{package} has no launch files',
            f'put {wanted} into the folder launch of the package',
        )
    by_name = {PurePosixPath(f).name: f for f in reversed(likely)}
    order = nearest_first(PurePosixPath(wanted).name, by_name)
    listed = list(dict.fromkeys([*(by_name[n] for n in order), *likely]))
    more = '\n  …' if len(listed) > _LISTED else ''
    raise UserError(
        f"{package} has no launch file '{wanted}'",
        f'it has:{_lines(listed[:_LISTED])}{more}',
    )


def _lines(files: Sequence[str]) -> str:
    return ''.join(f'\n  {one_line(file)}' for file in files)


def _may_be_launch_file(path: Path) -> bool:
    if path.name == _MANIFEST or not path.name.endswith(LAUNCH_SUFFIXES):
        return False
    return path.suffix != '.py' or _is_likely(path.as_posix())


def _is_likely(file: str) -> bool:
    path = PurePosixPath(file)
    return 'launch' in path.parent.parts or '.launch' in path.suffixes


def _is_end(file: str, wanted: str) -> bool:
    return f'/{file}'.endswith(f'/{wanted}')


def _is_end_without_suffix(file: str, wanted: str) -> bool:
    return any(
        _is_end(file, f'{wanted}{suffix}')
        for suffix in LAUNCH_SUFFIXES
        if file.endswith(suffix)
    )
