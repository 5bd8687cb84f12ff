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
#: EmPy's statements, joined lines and expressions, and CMake's variables.
_TAG = re.compile(
    r'@\[ *(if|for|end)[^]]*\]@\n|@\{[^}]*\}@\n|@\n|@\(([\w.]+)\)|@\w+@'
)
#: Where Debian and others install Python packages in a prefix.
_AMENT = 'lib/python3*/*-packages/ament_package/template/prefix_level'


def colcon_template(name: str) -> Path | None:
    """Return colcon's template of a script of a prefix, if there is one."""
    package = 'colcon_core' if name.endswith('.py') else 'colcon_bash'
    spec = find_spec(package)
    if spec is None or spec.origin is None:
        return None
    stem = {
        'setup.bash': 'prefix_chain.bash',
        'local_setup.bash': 'prefix.bash',
    }
    file = f'{stem.get(name, "prefix_util.py")}.em'
    return Path(spec.origin).parent / 'shell/template' / file


def ament_template(prefix: str, name: str) -> Path | None:
    """Return ament's template of a script of a prefix, as in /opt/ros."""
    return next(Path(prefix).glob(f'{_AMENT}/{name}*'), None)


def is_from_template(text: str, template: Path | None) -> bool:
    """
    Tell whether the text of a script is what a template makes.

    :raises OSError: when the template cannot be read
    """
    if template is None:
        return False
    pattern = ''.join(_patterns(template.read_text(encoding='utf-8')))
    return re.fullmatch(pattern, text) is not None


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
