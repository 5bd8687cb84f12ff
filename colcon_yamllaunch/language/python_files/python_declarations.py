# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The launch arguments that launch files in Python declare."""

from collections.abc import Iterable

from colcon_yamllaunch.language.evaluation.declared_argument import (
    DeclaredArgument,
)
from colcon_yamllaunch.language.evaluation.walk import Walk
from colcon_yamllaunch.language.python_files.python_source import (
    written_arguments,
)
from colcon_yamllaunch.language.python_files.python_visit import (
    NotTakenOverError,
)
from colcon_yamllaunch.language.python_files.python_visit import (
    visit_in_python,
)
from colcon_yamllaunch.language.python_files.worker_dialogue import position_of
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.plan.position import Span


def declared_arguments(
    walk: Walk, path: str, origin: Span
) -> Iterable[DeclaredArgument] | None:
    """
    Return what a launch file in Python and all that it includes declares.

    Where nothing may be run, it is what stands in the file. None when that is
    nothing, or the host cannot tell.

    :param origin: Where it is included, else its start
    :raises LaunchError: when the host says that the file has mistakes
    """
    start = Position(walk.source_path(path), 1, 1)
    if walk.open_worker is None:
        return list(written_arguments(start.path)) or None
    if walk.dialogue is not None:
        walk.dialogue.declared.clear()
    try:
        visit_in_python(walk, 'arguments', path, origin)
    except NotTakenOverError:
        return None
    assert walk.dialogue is not None
    return [
        DeclaredArgument(
            name,
            position_of(said, start, walk),
            said.get('description') or None,
            said.get('default'),
            tuple(map(str, said.get('choices') or ())),
            said.get('conditional') is True,
        )
        for name, said in walk.dialogue.declared.items()
    ]
