# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The command that connects with a machine.

It runs `sh` there, which reads everything else from its standard input: that
works with any login shell, and with commands that pass their words on as they
are (docker) or through a shell (ssh).
"""

from collections.abc import Mapping
import os

from colcon_yamllaunch.remote.deployment.machine import Machine

_SHELL = ('sh',)
_BATCH = ('-o', 'BatchMode=yes')
#: Slurm sets it within an allocation.
_ALLOCATION = 'SLURM_JOB_ID'


def connect_command(
    machine: Machine,
    environment: Mapping[str, str],
    *,
    may_ask: bool = False,
    host: str | None = None,
) -> list[str]:
    """
    Return the command line that connects with a machine.

    :param environment: The variables of the launcher
    :param may_ask: Whether `ssh` may ask for a password, or whether a host
      key is trusted
    :param host: The node of Slurm that a part runs on already
    """
    if machine.kind == 'slurm':
        return [*_slurm(machine, environment, host), '/bin/sh']
    if machine.kind == 'ssh':
        batch = () if may_ask else _BATCH
        return ['ssh', '-T', *batch, '--', *machine.words, *_SHELL]
    program, *words = machine.words
    if os.path.basename(program) == 'ssh' and not may_ask:
        words = [*_BATCH, *words]
    return [program, *words, *_SHELL]


def connect_variables(
    environment: Mapping[str, str], *, may_ask: bool
) -> dict[str, str]:
    """Return the variables of the command that connects."""
    variables = dict(environment)
    if not may_ask:
        # nor may it open a window (ssh 8.4)
        variables['SSH_ASKPASS_REQUIRE'] = 'never'
    return variables


def can_connect_again(
    machine: Machine, environment: Mapping[str, str]
) -> bool:
    """Return whether a new connection leads to the same machine."""
    # an allocation ends with the command that has made it
    return machine.kind != 'slurm' or _ALLOCATION in environment


def _slurm(
    machine: Machine, environment: Mapping[str, str], host: str | None
) -> list[str]:
    # the last options, those of the user, take precedence
    words = ['srun', '--nodes=1', '--ntasks=1', '--export=NONE']
    if _ALLOCATION in environment:
        # beside the step that the launcher may run in
        words.append('--overlap')
    words += machine.words
    if host is not None:
        words.append(f'--nodelist={host}')
    return words
