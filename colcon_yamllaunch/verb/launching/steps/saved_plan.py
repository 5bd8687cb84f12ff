# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A plan that was saved, read to be run."""

from pathlib import Path

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.text_files import content_of
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.plan_json import plan_from_json
from colcon_yamllaunch.plan.plan_json import PlanFormatError
from colcon_yamllaunch.plan.position import shown_position


def read_saved_plan(path: Path, cwd: Path) -> Plan:
    """
    Return the plan that a file has.

    :param path: The file as the user names it, in `cwd`
    :raises UserError: when it has none, or one that cannot be run
    """
    try:
        text = content_of(cwd / path).decode('utf-8')
        plan = plan_from_json(text)
    except (OSError, UnicodeDecodeError, PlanFormatError) as e:
        reason = e.strerror if isinstance(e, OSError) else e
        raise UserError(f"'{path}' has no plan: {reason}") from e
    if plan.left_open:
        raise UserError(
            f"'{path}' cannot be run, as {plan.left_open[0]} was left "
            'open in it: save it with --run-commands'
        )
    position = plan.host_position
    if position is not None:
        place = shown_position(position, str(cwd))
        raise UserError(
            f"'{path}' cannot be run, as what happens while it runs is up "
            f'to Python ({place}): launch that file'
        )
    return plan
