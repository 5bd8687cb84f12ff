# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What takes part in a launch that systemd runs."""

from collections.abc import Mapping
from contextlib import suppress
import os
from typing import TextIO

from colcon_yamllaunch.engine.participants import Participant
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.service import journald
from colcon_yamllaunch.service.journald import JournalOutput
from colcon_yamllaunch.service.notify import Notifier, VARIABLES


class RunningService:
    """
    A launch whose environment has `NOTIFY_SOCKET`.

    :param plan: The plan of the whole launch
    :param environment: The environment of the launcher (`sd_notify(3)`,
      `sd_watchdog_enabled(3)`, and `JOURNAL_STREAM` of `systemd.exec(5)`)
    """

    def __init__(self, plan: Plan, environment: Mapping[str, str]) -> None:
        #: What takes part in the launch.
        self.participants: list[Participant] = [Notifier(plan, environment)]
        #: Where the screen is; None for standard output.
        self.stream: TextIO | None = None
        if _is_journal(environment.get('JOURNAL_STREAM', '')):
            # without a journal, its lines go where systemd wants them
            with suppress(OSError):
                output = JournalOutput(journald.SOCKET)
                self.participants.append(output)
                # for as long as the launcher runs
                self.stream = open(  # noqa: SIM115
                    os.devnull, 'w', encoding='utf-8'
                )

    @staticmethod
    def environment_of(environment: Mapping[str, str]) -> dict[str, str]:
        """Return the environment of processes, which do not notify systemd."""
        return {k: v for k, v in environment.items() if k not in VARIABLES}


def _is_journal(stream: str) -> bool:
    """Return whether standard output is the stream `DEVICE:INODE`."""
    with suppress(OSError):
        status = os.fstat(1)
        return stream == f'{status.st_dev}:{status.st_ino}'
    return False
