# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What the environment hooks of an installed package do.

They are described in dsv files, one `operation;argument;…` a line. The rules
are those of colcon's and ament's prefix scripts (colcon-core,
shell/template/prefix_util.py.em; ament_package, _local_setup_util.py).
"""

from dataclasses import field
import os
import re

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.text_files import content_of

_SET = ('set', 'set-if-unset')
_IF_EXISTS = 'prepend-non-duplicate-if-exists'
_APPEND = 'append-non-duplicate'
_EXTEND = (_APPEND, 'prepend-non-duplicate', _IF_EXISTS)
#: The extensions that count when bash sources, in ascending priority.
_SHELLS = ('.sh', '.bash')
#: How package.sh names its hooks (colcon-core, shell/template/package.sh.em).
_SH_HOOK = re.compile(
    r'^_colcon_package_sh_source_script "\$COLCON_CURRENT_PREFIX/([^"\n]+)"',
    re.M,
)


#: What is done to a variable: `set`, `set-if-unset`, `append` or `prepend`
#: (where it is not in there yet); its name; and the value.
Change = tuple[str, str, str]


class DamagedHooksError(Exception):
    """A description of hooks that sourcing trips over or falls short with."""

    def __init__(self, path: str, reason: str) -> None:
        super().__init__(f'{path} is damaged: {reason}')


@dataclass(frozen=True, slots=True)
class Hooks:
    """
    The hooks of a package.

    :param paths: What is read or looked for, the description of all first
    :param extended: Variables with the path that is put into each
    :param changes: All that is done to variables, in order
    :param texts: All names and values, as they are put into shell commands
    :param scripts: The scripts that are sourced
    """

    paths: list[str] = field(default_factory=list)
    extended: list[tuple[str, str]] = field(default_factory=list)
    changes: list[Change] = field(default_factory=list)
    texts: list[tuple[str, str]] = field(default_factory=list)
    scripts: list[str] = field(default_factory=list)


def read_hooks(prefix: str, name: str) -> Hooks:
    """
    Read what sourcing does for a package.

    :param prefix: The prefix that it is installed in
    :raises DamagedHooksError: when a description of its hooks is damaged
    """
    hooks = Hooks()
    path = os.path.join(prefix, 'share', name, 'package.dsv')
    hooks.paths.append(path)
    if os.path.exists(path):
        _read((path,), prefix, hooks)
        _check_complete(path)
    return hooks


def _read(chain: tuple[str, ...], prefix: str, hooks: Hooks) -> None:
    path = chain[-1]
    if path in chain[:-1]:
        raise DamagedHooksError(path, 'it names itself')
    sources: dict[str, set[str]] = {}
    for number, line in enumerate(_text(path).splitlines(), 1):
        if not line.strip() or line.startswith('#'):
            continue
        operation, separator, remainder = line.partition(';')
        try:
            if not separator:
                raise ValueError('there is no semicolon')
            if operation == 'source':
                _add_source(remainder, sources)
            else:
                _change(operation, remainder, prefix, hooks)
        except ValueError as e:
            raise DamagedHooksError(path, f'line {number}: {e}') from e
    for base, extensions in sources.items():
        base = os.path.join(prefix, base)
        description = f'{base}.dsv'
        hooks.paths.append(description)
        if os.path.exists(description):
            _check_not_empty(description, base)
            _read((*chain, description), prefix, hooks)
        else:
            scripts = [base + e for e in _SHELLS if e in extensions]
            hooks.scripts.extend(scripts[-1:])


def _add_source(remainder: str, sources: dict[str, set[str]]) -> None:
    base, extension = os.path.splitext(remainder)
    if not extension:
        raise ValueError(f"'{remainder}' has no extension")
    sources.setdefault(base, set()).add(extension)


def _change(operation: str, remainder: str, prefix: str, hooks: Hooks) -> None:
    name, *values = remainder.split(';')
    if operation in _SET:
        if not values:
            raise ValueError(f'{name} is given no value')
        values = [remainder.partition(';')[2]]
        path = os.path.join(prefix, values[0])
        hooks.paths.append(path)
        value = path if os.path.exists(path) else values[0]
        hooks.changes.append((operation, name, value))
    elif operation in _EXTEND:
        if not values:
            raise ValueError(f'{name} is given no path')
        for value in values:
            path = os.path.join(prefix, value) if value else prefix
            if operation == _IF_EXISTS:
                hooks.paths.append(path)
                if not os.path.exists(path):
                    continue
            hooks.extended.append((name, path))
            end = 'append' if operation == _APPEND else 'prepend'
            hooks.changes.append((end, name, path))
    else:
        raise ValueError(f"there is no operation '{operation}'")
    hooks.texts.extend((name, value) for value in values)


def _check_not_empty(description: str, base: str) -> None:
    # both are written together, so a write was cut off
    if os.path.getsize(description) == 0 and os.path.exists(f'{base}.sh'):
        raise DamagedHooksError(description, 'it is empty')


def _check_complete(path: str) -> None:
    script = f'{path.removesuffix(".dsv")}.sh'
    if not os.path.exists(script):
        return
    described = set(_text(path).splitlines())
    for hook in _SH_HOOK.findall(_text(script)):
        if f'source;{hook}' not in described:
            raise DamagedHooksError(path, f'it lacks {hook}')


def _text(path: str) -> str:
    try:
        return content_of(path).decode('utf-8', 'surrogateescape')
    except OSError as e:
        raise DamagedHooksError(path, e.strerror or str(e)) from e
