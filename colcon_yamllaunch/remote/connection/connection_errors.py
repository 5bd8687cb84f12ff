# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Why a machine cannot be connected with, and what the user can do."""

from collections.abc import Sequence
import re
import shlex

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.deployment.deployment import Machine
from colcon_yamllaunch.remote.connection.bootstrap import (
    Bootstrap,
    Failure,
    OLDEST_PYTHON,
)

#: How many lines of a command's output are shown.
_SHOWN_LINES = 4
_OLDEST = '.'.join(map(str, OLDEST_PYTHON))
# the exit codes of a shell for a missing program (POSIX, 2.8.2)
_NOT_FOUND, _NOT_EXECUTABLE = 127, 126

# messages of ssh (readconf.c, sshconnect.c, sshconnect2.c of OpenSSH), their
# cause and the fix
_SSH: Sequence[tuple[str, str, str]] = (
    (
        'REMOTE HOST IDENTIFICATION HAS CHANGED',
        'its host key is another one than before, so it may be another '
        'machine',
        'if that is right, remove the old key: ssh-keygen -R {host}',
    ),
    (
        'Host key verification failed|host key is known for',
        'its host key is not known yet',
        'connect once by hand, look at the key and accept it: ssh {host}',
    ),
    (
        'Could not resolve hostname|Name or service not known',
        'its name is not known',
        'correct the name, or give it an address: Host and HostName in '
        '~/.ssh/config',
    ),
    (
        r'Permission denied|Too many authentication failures',
        'it does not let us in',
        'give it your key: ssh-copy-id {host}; or load the key: ssh-add',
    ),
    (
        'Connection refused',
        'nothing listens for ssh there',
        'start its ssh server, or correct the port',
    ),
    (
        'Connection timed out|No route to host|Network is unreachable'
        '|Host is down|Operation timed out',
        'it cannot be reached',
        'see whether it is switched on and in the network: ping {host}',
    ),
    (
        'Bad configuration option|terminating, .* bad configuration',
        'the configuration of ssh is wrong',
        'correct it: ssh -G {host}',
    ),
)
# causes of which ssh would have asked on a terminal
_ASKED = ('its host key is not known yet', 'it does not let us in')
# of srun, likewise
_SLURM: Sequence[tuple[str, str, str]] = (
    (
        '(?i)Unable to contact',
        'the controller of Slurm cannot be reached',
        'ask it: sinfo',
    ),
    (
        '(?i)invalid partition',
        'there is no such partition',
        'the partitions are listed by sinfo',
    ),
    (
        '(?i)Unable to allocate resources|Unable to create step'
        '|configuration is not available|More processors requested',
        'Slurm does not give what is asked for',
        'correct the options; what there is is listed by sinfo',
    ),
    (
        '(?i)unrecognized option|invalid option|Invalid numeric value',
        'srun does not know an option',
        'correct the options',
    ),
)


class ConnectError(UserError):
    """
    A machine cannot be connected with.

    :param reason: Why, and what the user can do
    :ivar may_be_asked: Whether it helps to ask the user on a terminal
    """

    def __init__(
        self, machine: Machine, reason: str, *, may_be_asked: bool = False
    ) -> None:
        how = {'ssh': ['ssh'], 'slurm': ['srun'], 'connect': []}[machine.kind]
        words = shlex.join([*how, *machine.words])
        super().__init__(f'{machine.name} ({words}): {reason}')
        self.may_be_asked = may_be_asked


def no_command(machine: Machine, error: OSError) -> ConnectError:
    """Return the error that the command that connects cannot be started."""
    reason = str(error.strerror)
    if isinstance(error, FileNotFoundError):
        reason = (
            f"the program '{error.filename}' is not on the PATH; install it"
        )
        if machine.kind != 'connect':
            package = {'ssh': 'openssh-client', 'slurm': 'slurm-client'}
            reason += f' (Debian: {package[machine.kind]})'
    return ConnectError(machine, reason)


def not_started(machine: Machine, bootstrap: Bootstrap) -> ConnectError:
    """Return the error that our program does not start there."""
    detail = one_line(bootstrap.detail)
    noise = one_line(bootstrap.noise)
    reasons: dict[Failure, str] = {
        'none': f'there is no {machine.python or "python3"} on its PATH: '
        f"install Python {_OLDEST} or later there, or name it with 'python:'",
        'old': f'its Python is {detail}, but {_OLDEST} or later is needed: '
        "install one there, or name it with 'python:'",
        'full': 'what is to run there cannot be stored, neither in ~/.cache '
        f'nor in /tmp: {detail}',
        'noise': f"something else answers than a shell: '{noise}'; a "
        "'.bashrc' or a login there must not start another program",
    }
    return ConnectError(machine, reasons[bootstrap.failure])


def ended(
    machine: Machine, command: Sequence[str], code: int, messages: str
) -> ConnectError:
    """
    Return the error that the command that connects has ended.

    :param code: Its exit code, negative for a signal
    :param messages: What it wrote to standard error
    """
    said = _shown(messages)
    known: Sequence[tuple[str, str, str]] = ()
    if machine.kind == 'slurm':
        known = _SLURM
    elif command[0].rpartition('/')[2] == 'ssh' or 'ssh: ' in messages:
        known = _SSH
    for pattern, reason, cure in known:
        if re.search(pattern, messages):
            return ConnectError(
                machine,
                f'{reason}: {cure.format(host=_host(machine))}{said}',
                may_be_asked=reason in _ASKED,
            )
    if code in (_NOT_FOUND, _NOT_EXECUTABLE):
        return ConnectError(
            machine, f"there is no 'sh' there, or it cannot be run{said}"
        )
    how = f'exit code {code}' if code >= 0 else f'signal {-code}'
    way = shlex.join([*command, '-c', 'true'])
    reason = f'the connection ended before it stood ({how}): try {way}{said}'
    return ConnectError(machine, reason)


def silent(machine: Machine, seconds: float, said: str) -> ConnectError:
    """
    Return the error that the machine has been silent for too long.

    :param said: What it or the command that connects has printed
    """
    return ConnectError(
        machine,
        f'no answer within {seconds:g} s: see whether it is switched on, and '
        f'whether its login waits for a key{_shown(said)}',
    )


def lost(machine: Machine, messages: str) -> ConnectError:
    """Return the error that the connection ended before the launch."""
    return ConnectError(machine, f'the connection broke off{_shown(messages)}')


def no_workspace(machine: Machine, workspace: str) -> ConnectError:
    """Return the error that there is no workspace there."""
    return ConnectError(
        machine,
        f"there is no workspace {workspace}: name it with 'workspace:', or "
        "have it brought there with 'sync: build'",
    )


def _host(machine: Machine) -> str:
    words = [w for w in machine.words if not w.startswith('-')]
    return shlex.quote(words[-1]) if words else machine.name


def _shown(messages: str) -> str:
    lines = [one_line(line) for line in messages.splitlines() if line.strip()]
    lines = [line for line in lines if set(line) != {'@'}]
    return ''.join(f'\n  {line}' for line in lines[-_SHOWN_LINES:])
