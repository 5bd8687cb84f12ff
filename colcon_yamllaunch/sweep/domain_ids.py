# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The ROS_DOMAIN_ID of each run that goes on.

Nodes of one domain find one another. Which domains there are comes from the
ports that DDS computes of them: those from 102 to 214 are what Linux gives to
any program by chance, and 232 is the last (ROS 2, "The ROS_DOMAIN_ID").
"""

from collections.abc import Mapping
import fcntl
import os
from pathlib import Path

from colcon_yamllaunch.common.temporary_folders import temporary_folders

VARIABLE = 'ROS_DOMAIN_ID'
#: 0 is what everybody has who does not choose.
DOMAIN_IDS = (*range(1, 102), *range(215, 233))


class DomainIds:
    """
    Gives each run one that no other run has at that time.

    :param environment: The user's environment; its own domain is left to it
    :param shared: Whether the runs share a network with others, also those of
      other sweeps of the user
    """

    def __init__(
        self, environment: Mapping[str, str], *, shared: bool
    ) -> None:
        own = environment.get(VARIABLE, '')
        self._ids: list[int] = [n for n in DOMAIN_IDS if str(n) != own.strip()]
        self._shared = shared
        self._taken: dict[int, int] = {}
        self._next = 0
        self._folder = (
            temporary_folders(environment)[0]
            / f'colcon_sweep_domains_{os.getuid()}'
        )

    @property
    def count(self) -> int:
        """How many runs can have one of their own at a time."""
        return len(self._ids)

    def take(self) -> int | None:
        """
        Return one that nobody has, None if there is none left.

        In networks of their own, runs may have the same.
        """
        for _ in self._ids:
            number = self._ids[self._next]
            self._next = (self._next + 1) % len(self._ids)
            if number in self._taken:
                continue
            claim = self._claim(number) if self._shared else -1
            if claim is not None:
                self._taken[number] = claim
                return number
        if self._shared:
            return None
        number = self._ids[self._next]
        self._next = (self._next + 1) % len(self._ids)
        return number

    def give_back(self, number: int) -> None:
        """Let others have it."""
        claim = self._taken.pop(number, -1)
        if claim != -1:
            os.close(claim)

    def close(self) -> None:
        """Give all of them back."""
        for number in tuple(self._taken):
            self.give_back(number)

    def _claim(self, number: int) -> int | None:
        """Lock the file of one; -1 if there can be no such file."""
        try:
            self._folder.mkdir(mode=0o700, exist_ok=True)
            if not _is_ours(self._folder):
                return -1
            flags = os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW
            claim = os.open(self._folder / str(number), flags, 0o600)
        except OSError:
            return -1
        try:
            fcntl.flock(claim, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            os.close(claim)
            return None
        return claim


def _is_ours(folder: Path) -> bool:
    """Tell whether nobody else can put links there."""
    status = folder.lstat()
    return folder.is_dir() and status.st_uid == os.getuid()
