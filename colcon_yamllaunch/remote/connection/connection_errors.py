# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Why a machine cannot be connected with, and what the user can do."""

from collections.abc import Sequence
import re
import shlex

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.remote.connection.bootstrap import Bootstrap
from colcon_yamllaunch.remote.connection.bootstrap import OLDEST_PYTHON
from colcon_yamllaunch.remote.deployment.machine import Machine

#: Lines of what a command said that are shown.
_SHOWN_LINES = 4
_OLDEST = '.'.join(map(str, OLDEST_PYTHON))
# what a shell says of a program that is not there (POSIX, 2.8.2)
_NOT_FOUND, _NOT_EXECUTABLE = 127, 126

# what ssh writes (readconf.c, sshconnect.c, sshconnect2.c of OpenSSH), what is
# wrong then, what to do, and whether ssh would have asked on a terminal
_SSH: Sequence[tuple[str, str, str, bool]] = (
    (
        'REMOTE HOST IDENTIFICATION HAS CHANGED',
        'its host key is another one than before, so it may be another '
        'machine',
        'if that is right, remove the old key: ssh-keygen -R {host}',
        False,
    ),
    (
        'Host key verification failed|host key is known for',
        'its host key is not known yet',
        'connect once by hand, look at the key and accept it: ssh {host}',
        True,
    ),
    (
        'Could not resolve hostname|Name or service not known',
        'its name is not known',
        'correct the name, or give it an address: Host and HostName in '
        '~/.ssh/config',
        False,
    ),
    (
        r'Permission denied|Too many authentication failures',
        'it does not let us in',
        'give it your key: ssh-copy-id {host}; or load the key: ssh-add',
        True,
    ),
    (
        'Connection refused',
        'nothing listens for ssh there',
        'start its ssh server, or correct the port',
        False,
    ),
    (
        'Connection timed out|No route to host|Network is unreachable'
        '|Host is down|Operation timed out',
        'it cannot be reached',
        'see whether it is switched on and in the network: ping {host}',
        False,
    ),
    (
        'Bad configuration option|terminating, .* bad configuration',
        'the configuration of ssh is wrong',
        'correct it: ssh -G {host}',
        False,
    ),
)
_SLURM: Sequence[tuple[str, str, str]] = (
    (
        'Unable to contact slurm controller|Unable to contact',
        'the controller of Slurm cannot be reached',
        'ask it: sinfo',
    ),
    (
        'invalid partition',
        'there is no such partition',
        'the partitions are listed by sinfo',
    ),
    (
        'Unable to allocate resources|Unable to create step'
        '|configuration is not available|More processors requested',
        'Slurm does not give what is asked for',
        'correct the options; what there is is listed by sinfo',
    ),
    (
        'unrecognized option|invalid option|Invalid numeric value',
        'srun does not know an option',
        'correct the options',
    ),
)


class ConnectError(UserError):
    """
    A machine cannot be connected with.

    :ivar may_be_asked: Whether it helps to ask the user on a terminal
    """

    def __init__(self, text: str, *, may_be_asked: bool = False) -> None:
        super().__init__(text)
        self.may_be_asked = may_be_asked


def described(machine: Machine) -> str:
    """Return a machine as errors begin with it."""
    how = {'ssh': ['ssh'], 'slurm': ['srun'], 'connect': []}[machine.kind]
    return f'{machine.name} ({shlex.join([*how, *machine.words])})'


def no_command(machine: Machine, program: str, error: OSError) -> ConnectError:
    """Tell that the command that connects cannot be started."""
    reason = error.strerror
    if isinstance(error, FileNotFoundError):
        reason = f"the program '{program}' is not on the PATH; install it"
        if machine.kind == 'ssh':
            reason += ' (Debian: openssh-client)'
        elif machine.kind == 'slurm':
            reason += ' (Debian: slurm-client)'
    return ConnectError(f'{described(machine)}: {reason}')


def not_started(machine: Machine, bootstrap: Bootstrap) -> ConnectError:
    """Tell why our program does not start there."""
    place = described(machine)
    detail = one_line(bootstrap.detail)
    if bootstrap.failure == 'none':
        which = machine.python or 'python3'
        return ConnectError(
            f'{place}: there is no {which} on its PATH: install Python '
            f"{_OLDEST} or later there, or name it with 'python:'"
        )
    if bootstrap.failure == 'old':
        return ConnectError(
            f'{place}: its Python is {detail}, but {_OLDEST} or later is '
            "needed: install one there, or name it with 'python:'"
        )
    if bootstrap.failure == 'full':
        return ConnectError(
            f'{place}: what is to run there cannot be stored, neither in '
            f'~/.cache nor in /tmp: {detail}'
        )
    return ConnectError(
        f'{place}: something else answers than a shell: '
        f"'{one_line(bootstrap.noise)}'; a '.bashrc' or a login there must "
        'not start another program'
    )


def ended(
    machine: Machine, command: Sequence[str], code: int, messages: str
) -> ConnectError:
    """
    Tell why the command that connects has ended.

    :param code: Its exit code, negative for a signal
    :param messages: What it wrote to standard error
    """
    place, said = described(machine), _shown(messages)
    if machine.kind == 'slurm':
        for pattern, reason, cure in _SLURM:
            if re.search(pattern, messages, re.IGNORECASE):
                return ConnectError(f'{place}: {reason}: {cure}{said}')
    elif any(word.rpartition('/')[2] == 'ssh' for word in command[:1]) or (
        'ssh: ' in messages
    ):
        host = _host(machine)
        for pattern, reason, cure, asks in _SSH:
            if re.search(pattern, messages):
                cure = cure.format(host=host)
                return ConnectError(
                    f'{place}: {reason}: {cure}{said}', may_be_asked=asks
                )
    if code in (_NOT_FOUND, _NOT_EXECUTABLE):
        return ConnectError(
            f"{place}: there is no 'sh' there, or it cannot be run{said}"
        )
    how = f'exit code {code}' if code >= 0 else f'signal {-code}'
    return ConnectError(
        f'{place}: the connection ended before it stood ({how}): try '
        f'{shlex.join([*command, "-c", "true"])}{said}'
    )


def silent(
    machine: Machine, seconds: float, messages: str, noise: str
) -> ConnectError:
    """Tell that nothing has come for long."""
    said = _shown('\n'.join(filter(None, (noise, messages))))
    return ConnectError(
        f'{described(machine)}: no answer within {seconds:g} s: see whether '
        f'it is switched on, and whether its login waits for a key{said}'
    )


def no_protocol(machine: Machine, reason: str) -> ConnectError:
    """Tell that what comes is not what we send."""
    return ConnectError(
        f'{described(machine)}: the connection is damaged: {reason}; the '
        'command that connects must pass on all bytes as they are, without a '
        'terminal in between'
    )


def lost(machine: Machine, messages: str) -> ConnectError:
    """Tell that the connection broke off, or died, before the launch."""
    return ConnectError(
        f'{described(machine)}: the connection broke off{_shown(messages)}'
    )


def no_workspace(machine: Machine, workspace: str) -> ConnectError:
    """Tell that the workspace is missing there."""
    return ConnectError(
        f'{described(machine)}: there is no workspace {workspace}: name it '
        "with 'workspace:', or have it brought there with 'sync: build'"
    )


def _host(machine: Machine) -> str:
    words = [w for w in machine.words if not w.startswith('-')]
    return shlex.quote(words[-1]) if words else machine.name


def _shown(messages: str) -> str:
    lines = [one_line(line) for line in messages.splitlines() if line.strip()]
    lines = [line for line in lines if set(line) != {'@'}]
    return ''.join(f'\n  {line}' for line in lines[-_SHOWN_LINES:])
