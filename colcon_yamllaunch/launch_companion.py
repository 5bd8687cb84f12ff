# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What `run_plan` has beside a part that runs for another machine."""

from collections.abc import Callable
from typing import Protocol

from colcon_yamllaunch.control.service import Service
from colcon_yamllaunch.engine.elsewhere import Companion
from colcon_yamllaunch.engine.engine import Engine


class LaunchCompanion(Companion, Protocol):
    """What is beside a part of a launch that runs for another machine."""

    def begin(
        self,
        engine: Engine,
        service: Service,
        show: Callable[[], None],
    ) -> None:
        """
        Be beside an engine from now on, which runs next.

        :param service: Tells the states of processes and components
        :param show: Lets other terminals of this machine see the part
        """
