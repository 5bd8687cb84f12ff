# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What hostile tests need of the system: another user, disks of their own."""

from collections.abc import Sequence
import functools
import os
import shlex
import subprocess

from colcon_yamllaunch.common.process_scan import cgroup_of
from colcon_yamllaunch.engine.cgroup import LaunchCgroup
import pytest

#: Another user, who owns nothing: `nobody` of Linux.
OTHER_USER = 65534
#: Changes the options that it names, of a mount. In a user namespace, mount(8)
#: would repeat the others with user ids that are not valid there.
REMOUNT = ('mount', '--options-source=disable', '-o')

needs_other_user = pytest.mark.skipif(
    os.getuid() != 0, reason='only root can give files to another user'
)


def _has_cgroups() -> bool:
    """Tell whether a launch gets a control group here."""
    cgroup = LaunchCgroup('0' * 16)
    with cgroup.entered(0):
        inside = cgroup_of('self') or ''
    cgroup.remove()
    return inside.endswith(f'{"0" * 16}/0')


needs_control_group = pytest.mark.skipif(
    not _has_cgroups(), reason='no control group can be made here'
)


@functools.cache
def _private() -> tuple[str, ...] | None:
    """Return what runs a command with mounts of its own, if anything."""
    for command in (('unshare', '-m'), ('unshare', '-r', '-m')):
        try:
            subprocess.run([*command, 'true'], check=True, capture_output=True)
        except (OSError, subprocess.CalledProcessError):
            continue
        return command
    return None


def with_mounts(script: str, argv: Sequence[str]) -> list[str]:
    """
    Return a command line that runs another one with mounts of its own.

    Nobody else sees the mounts, and they end with the last process. The test
    is skipped where neither root's rights nor a user namespace allows them.

    :param script: Shell commands that mount, such as `mount -t tmpfs …`
    :param argv: The command line
    """
    command = _private()
    if command is None:
        pytest.skip('mounts of its own need root or a user namespace')
    return [*command, 'sh', '-ec', f'{script}\nexec {shlex.join(argv)}']


class Mounts:
    """
    Mounts that some commands have, and nobody else; end them with `close`.

    The test is skipped where neither root's rights nor a user namespace
    allows them.

    :param script: Shell commands that mount
    """

    def __init__(self, script: str) -> None:
        self._keeper = subprocess.Popen(
            with_mounts(f'{script}\necho', ['cat']),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )
        assert self._keeper.stdout is not None
        assert self._keeper.stdout.readline()

    @property
    def inside(self) -> list[str]:
        """What a command begins with that is to have them."""
        namespaces = ['-m'] if os.getuid() == 0 else ['-U', '-m']
        words = ['nsenter', '-t', str(self._keeper.pid), *namespaces]
        return [*words, '--preserve-credentials', '--']

    def run(self, *argv: str) -> None:
        """Run a command that has them."""
        subprocess.run([*self.inside, *argv], check=True)

    def close(self) -> None:
        """End them."""
        self._keeper.communicate()
