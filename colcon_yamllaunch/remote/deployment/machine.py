# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A machine that parts of a launch run on."""

from typing import Literal

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.plan.position import Position

#: How a machine is reached.
Kind = Literal['ssh', 'slurm', 'connect']
#: How the code gets to a machine.
Sync = Literal['build', 'install', 'none']
#: What happens to a machine's part when the link to it is lost.
OnLost = Literal['stop', 'restart', 'keep']


@dataclass(frozen=True, slots=True)
class Machine:
    """
    A machine that parts of a launch run on, as the user describes it.

    :param name: Its name in labels and messages; unique
    :param kind: How it is reached: through `ssh`, through Slurm, or through
      any other command that runs one with its stdin and stdout
    :param words: Of `ssh` the destination, one word; of `slurm` the options
      of an allocation; of `connect` the command, split into words
    :param workspace: The folder of the workspace there, absolute or
      beginning with `~/`; None for the same path as here if that exists
      there, or else the folder of that name in the home folder there
    :param sync: How the code gets there: its sources, which are built there;
      the installed files; or not at all
    :param on_lost: What happens to its part when the link is lost: it is
      stopped; it is stopped, and started again once the machine is back; or
      it runs on until the link is back
    :param lost_after: After how many seconds of silence the link is lost;
      None for the default
    :param env: Names of variables to send, besides those that always are
    :param values: Variables that are set there
    :param setup: A file there that is sourced first, or None
    :param python: The Python there, None to search for one
    :param position: Where the deployment file describes it, None for the
      command line
    """

    name: str
    kind: Kind
    words: tuple[str, ...]
    workspace: str | None = None
    sync: Sync = 'build'
    on_lost: OnLost = 'stop'
    lost_after: float | None = None
    env: tuple[str, ...] = ()
    values: tuple[tuple[str, str], ...] = ()
    setup: str | None = None
    python: str | None = None
    position: Position | None = None
