# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The machines that may be meant by `--on`."""

from collections.abc import Iterator
from contextlib import suppress
import os
from pathlib import Path

from colcon_yamllaunch.verb.completion.candidates import Candidates

#: The largest file that is read for that, in bytes.
MAXIMUM_SIZE = 1_000_000


def hosts(deployment: str | None, prefix: str, folder: Path) -> Candidates:
    """
    Find the hosts that the user's ssh knows, or the machines of a file.

    :param deployment: The deployment file that is given, if one is
    :param prefix: What is begun, maybe with a user in front of the host
    :param folder: The user's folder for ssh
    """
    if deployment:
        # it is read for this only
        from colcon_yamllaunch.remote.deployment.deployment_file import (
            read_deployment,
        )

        return dict.fromkeys(read_deployment(deployment).machines, '')
    user, at, _ = prefix.rpartition('@')
    names = {*_configured(folder / 'config'), *_known(folder / 'known_hosts')}
    return {f'{user}{at}{name}': '' for name in sorted(names)}


def _configured(path: Path) -> Iterator[str]:
    """Return the hosts that a configuration names (ssh_config(5))."""
    for line in _lines(path):
        key, *names = line.replace('=', ' ', 1).split() or ['']
        if key.lower() == 'host':
            yield from (n for n in names if not set(n) & set('*?!"'))


def _known(path: Path) -> Iterator[str]:
    """Return the hosts whose keys are known, unless they are hashed."""
    for line in _lines(path):
        names, *_ = line.split() or ['']
        if names.startswith(('#', '|', '@')):
            continue
        # what has a port of its own stands in brackets
        yield from (n for n in names.split(',') if n and n[0] not in '[!*')


def _lines(path: Path) -> list[str]:
    with suppress(OSError):
        if os.path.isfile(path) and path.stat().st_size <= MAXIMUM_SIZE:
            return path.read_text(errors='replace').splitlines()
    return []
