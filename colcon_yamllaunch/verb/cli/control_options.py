# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the command line of `colcon launch` asks of running launches."""

from collections.abc import Iterable
from collections.abc import Sequence
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.verb.cli.option_scanner import Item
from colcon_yamllaunch.verb.cli.option_table import REQUESTS
from colcon_yamllaunch.verb.cli.option_table import TEXT


@dataclass(frozen=True, slots=True)
class ControlOptions:
    """
    What the user asks of running launches.

    :param action: `status`, `stop`, `restart`, `logs` or `attach`
    :param names: The processes, by name or glob
    :param launch: Which launch is meant: its package, launch file, title or
      process id; None when that is clear
    :param follow: Whether `logs` waits for more
    :param status_format: How `status` is shown
    """

    action: str
    names: tuple[str, ...] = ()
    launch: str | None = None
    follow: bool = False
    status_format: str = TEXT


def is_control(items: Iterable[Item]) -> bool:
    """
    Tell whether a command line launches nothing, but is about what runs.

    This is known before the command line is parsed, since then colcon has
    made a folder for logs already.

    :param items: What stands behind `launch`
    """
    # without an option: something to launch
    given = {
        None if item.option is None else item.option.name
        for item in items
        if item.option is not None or item.is_positional
    }
    if given.intersection(REQUESTS):
        return True
    return '--attach' in given and given.isdisjoint(('--from-plan', None))


def control_options(
    values: Any, positionals: Sequence[str]
) -> ControlOptions | None:
    """
    Return what is asked of running launches; None for a new launch.

    :param positionals: The words that belong to no option
    :raises UserError: when it makes no sense
    """
    actions = [name.removeprefix('--') for name in REQUESTS]
    given = [name for name in actions if getattr(values, name) is not None]
    launches = positionals or values.from_plan is not None
    if values.attach is not None and not launches:
        given.append('attach')
    if not given:
        return None
    action = given[0]
    if action == 'status' and positionals:
        raise UserError(
            f"--status takes no '{positionals[0]}': it shows all running "
            'launches; one of them with --of LAUNCH'
        )
    if action == 'restart' and not (values.restart or positionals):
        raise UserError(
            "--restart needs the NAME of a process; '*' means all of them"
        )
    names: Sequence[str] = ()
    if action == 'attach':
        names = (values.attach,)
    elif action != 'status':
        names = (*getattr(values, action), *positionals)
    return ControlOptions(
        action, tuple(names), values.of, values.follow, values.status or TEXT
    )
