# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The parameters of a process, those in files included."""

from collections.abc import Iterator
from collections.abc import Mapping as AbstractMapping
import math
import os
import stat
import sys

from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.source_text import read_source
from colcon_yamllaunch.language.syntax.yaml_reader import Mapping
from colcon_yamllaunch.language.syntax.yaml_reader import read_yaml
from colcon_yamllaunch.language.syntax.yaml_reader import Scalar
from colcon_yamllaunch.language.syntax.yaml_reader import Sequence
from colcon_yamllaunch.language.syntax.yaml_reader import Value
from colcon_yamllaunch.plan.plan import ParameterFile
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.plan.plan import SetParameter


def parameters_of(
    process: Process, limit: float = math.inf
) -> Iterator[SetParameter]:
    """
    Iterate over all parameters in the order of the command line.

    :param limit: Bytes of files that are read at most. Larger ones, and what
      is no ordinary file, are passed over
    """
    given = {f'{p.name}:={p.value}': p for p in process.parameters}
    arguments = zip(process.argv, process.argv[1:], strict=False)
    for option, value in arguments:
        if option == '-p' and isinstance(value, str) and value in given:
            yield given[value]
        elif option == '--params-file' and isinstance(value, str):
            size = _size_of(os.path.join(process.cwd, value))
            if size <= limit:
                limit -= size
                yield from _parameters_in_file(value, process.cwd)
        elif isinstance(value, ParameterFile):
            yield from value.parameters


def _size_of(path: str) -> int:
    """Return the bytes of a file, very many for what may have no end."""
    try:
        status = os.stat(path)
    except (OSError, ValueError):
        return 0
    return status.st_size if stat.S_ISREG(status.st_mode) else sys.maxsize


def _parameters_in_file(path: str, cwd: str) -> tuple[SetParameter, ...]:
    """
    Return the parameters in a file for nodes, none when it is no such file.

    :param cwd: The folder that a relative path starts from
    """
    absolute = path if path.startswith('/') else f'{cwd}/{path}'
    try:
        document = read_yaml(read_source(absolute, absolute))
        return tuple(_file_parameters(document))
    except LaunchError:
        return ()


def _file_parameters(document: Value | None) -> Iterator[SetParameter]:
    for _, body in _pairs(document).values():
        for name, (_, values) in _pairs(body).items():
            if name == 'ros__parameters':
                yield from _flattened('', values)


def _pairs(
    value: Value | None,
) -> AbstractMapping[str, tuple[Scalar, Value]]:
    return value.pairs if isinstance(value, Mapping) else {}


def _flattened(prefix: str, value: Value) -> Iterator[SetParameter]:
    for name, (key, inner) in _pairs(value).items():
        if isinstance(inner, Mapping):
            yield from _flattened(f'{prefix}{name}.', inner)
        else:
            shown = _shown(inner)
            yield SetParameter(prefix + name, shown, key.position)


def _shown(value: Value) -> str:
    if isinstance(value, Sequence):
        return f'[{", ".join(_shown(item) for item in value.items)}]'
    return value.text if isinstance(value, Scalar) else '{…}'
