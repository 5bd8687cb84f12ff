# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Whether setup scripts are as colcon and ament write them.

They write them from templates, which are installed with them. A script that
was edited or cut off, or that another version wrote, is not from the template.
"""

from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
import re

#: What a shell leaves as it is within double quotes.
LITERAL = r'[^"$`\\\n]*'
_COLCON = {
    'setup.bash': ('colcon_bash', 'prefix_chain.bash.em'),
    'local_setup.bash': ('colcon_bash', 'prefix.bash.em'),
    '_local_setup_util_sh.py': ('colcon_core', 'prefix_util.py.em'),
}
#: Where Debian and others install Python packages in a prefix.
_AMENT = 'lib/python3*/*-packages/ament_package/template/prefix_level'
#: EmPy's statements, joined lines and expressions, and CMake's variables.
_TAG = re.compile(
    r'@\[ *(if|for|end)[^]]*\]@\n|@\{[^}]*\}@\n|@\n|@\(([\w.]+)\)|@\w+@'
)


def colcon(name: str) -> Path | None:
    """Return colcon's template of a script, None where there is none."""
    package, template = _COLCON[name]
    spec = find_spec(package)
    if spec is None or spec.origin is None:
        return None
    return Path(spec.origin).parent / 'shell/template' / template


def ament(prefix: Path, name: str) -> Path | None:
    """Return ament's template of a script of a prefix, as in /opt/ros."""
    return next(prefix.glob(f'{_AMENT}/{name}*'), None)


def is_from(template: Path | None, script: str) -> bool:
    """
    Tell whether a script is what a template makes.

    :raises OSError: when the template cannot be read
    """
    if template is None:
        return False
    pattern = ''.join(_patterns(template.read_text('utf-8')))
    return re.fullmatch(pattern, script) is not None


def _patterns(template: str) -> Iterator[str]:
    position = 0
    opened: list[str] = []
    for tag in _TAG.finditer(template):
        yield re.escape(template[position : tag.start()])
        position = tag.end()
        statement, expression = tag.groups()
        if statement == 'end':
            yield ')?' if opened.pop() == 'if' else ')*'
        elif statement:
            opened.append(statement)
            yield '(?:'
        elif expression and '.' in expression:
            yield '.*'
        elif not tag[0].endswith('\n'):
            yield LITERAL
    yield re.escape(template[position:])
