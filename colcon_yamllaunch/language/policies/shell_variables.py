# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launch arguments that are written as a shell writes its variables."""

from collections.abc import Iterable
from collections.abc import Iterator
import re

from colcon_yamllaunch.language.policies.launch_arguments import (
    declared_arguments,
)
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.tree.launch_tree import LaunchFile

_VARIABLE = re.compile(r'\$\{(\w+)\}')


def shell_variables(
    files: Iterable[LaunchFile | None],
) -> Iterator[LaunchError]:
    """
    Report where `${name}` is written for a launch argument.

    What a shell is to run may have variables of its own.
    """
    read = [file for file in files if file is not None]
    suspects = [file for file in read if '${' in file.source.text]
    if not suspects:
        return
    declared = declared_arguments(read)
    for file in suspects:
        for entity in file.walk():
            if 'shell' in entity.item.texts:
                continue
            for text in entity.item.every_text():
                for written in _VARIABLE.finditer(text.plain):
                    if written[1] in declared:
                        yield error(
                            f"'{written[0]}' is no substitution and stays as "
                            'it is',
                            text,
                            hint=f'write $(var {written[1]})',
                        ).as_warning()
