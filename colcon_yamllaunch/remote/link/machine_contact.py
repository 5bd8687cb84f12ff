# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A machine from the first connection to the link of its part."""

from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.remote.connection.machine_connection import (
    MachineConnection,
)
from colcon_yamllaunch.remote.link.machine_link import MachineLink
from colcon_yamllaunch.remote.part_settings import PartSettings


class MachineContact(MachineConnection):
    """A connection whose part, once it is started, has a link."""

    def start(self, plan: Plan, settings: PartSettings) -> MachineLink:
        """
        Have a part of the plan made ready there; it runs once the link begins.

        :raises UserError: when it cannot be
        """
        part = self.start_part(plan, settings)
        return MachineLink(part, self._environment)
