# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Sourcing a setup script, and the underlays that it chains.

Underlays are the prefixes that a workspace was built on top of. Each build
writes `install/setup.bash` anew, chaining the underlays of the shell that it
runs in. Built from a shell where none is sourced, a workspace would lose them.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import field
import os
from pathlib import Path
import re
import select
import shutil
import signal
import subprocess
import time

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.common.files import split_path, text_of
from colcon_yamllaunch.common.frozen import dataclass

#: How long a setup script may take (seconds). With hundreds of packages on a
#: small board it takes some ten.
SOURCE_TIMEOUT = 120.0
#: How much of a script's output is shown when something went wrong (lines).
SHOWN_LINES = 12

#: How much a setup script may print (bytes), and how often that is looked at
#: (seconds).
MAXIMUM_OUTPUT = 64_000_000
LOOK_INTERVAL = 0.05

#: Variables by which bash starts in another way than a fresh one would. The
#: options matter: colcon's scripts fail under `set -u`.
_BASH_VARIABLES = ('BASH_ENV', 'SHELLOPTS', 'BASHOPTS', 'POSIXLY_CORRECT')
#: Variables that bash sets for itself.
OWN_VARIABLES = ('SHLVL', '_', 'PWD', 'OLDPWD')
#: The script is called with the setup script, the `env` command and the
#: number of the descriptor for the result.
SCRIPT = """\
setup=$1 env=$2 result=$3
set --
source "$setup" 1>&2
code=$?
[ "$code" = 0 ] || exit "$code"
exec "$env" -0 >&"$result"
"""


#: How colcon names a chained prefix in setup.bash and setup.sh.
_CHAINED = re.compile(r'^COLCON_CURRENT_PREFIX="([^"$`]+)"$', re.M)


@dataclass(frozen=True, slots=True)
class Environment:
    """
    What a setup script made of an environment.

    :param messages: What the script printed
    :param packages: Packages that are known to be brought in by it
    :param notes: What the user should know about it, a line each
    """

    variables: Mapping[str, str]
    messages: str = field(default='', compare=False)
    packages: frozenset[str] = field(default=frozenset(), compare=False)
    notes: tuple[str, ...] = field(default=(), compare=False)


def source(
    setup: Path,
    environment: Mapping[str, str],
    timeout: float = SOURCE_TIMEOUT,
) -> Environment:
    """
    Return the environment that `source SETUP` makes in a fresh bash.

    :param environment: The variables before; left as they are
    :param timeout: Seconds that the script may take
    :raises WorkspaceError: when it is missing, fails or takes too long
    """
    bash, env = programs(environment)
    if not os.path.isfile(setup):
        raise _no_setup(setup)
    # in memory, so that neither a full disk nor other users matter
    result, log = os.memfd_create('result'), os.memfd_create('log')
    try:
        returncode = _run(
            [
                bash,
                *('--noprofile', '--norc', '-c', SCRIPT, 'colcon launch'),
                *(str(setup), env, str(result)),
            ],
            {k: v for k, v in environment.items() if k not in _BASH_VARIABLES},
            result,
            log,
            timeout,
        )
        if os.fstat(log).st_size > MAXIMUM_OUTPUT:
            raise WorkspaceError(
                f'the setup script {setup} writes more than '
                f'{MAXIMUM_OUTPUT // 1_000_000} MB'
            )
        output, messages = _content(result), os.fsdecode(_content(log))
    finally:
        os.close(result)
        os.close(log)
    if returncode is None:
        reason = f'did not end within {timeout:g} s'
    elif returncode:
        reason = f'failed with exit code {returncode}'
    elif not output:
        reason = 'ended the shell'
    else:
        return Environment(_variables(output, environment), messages)
    raise WorkspaceError(
        f'the setup script {setup} {reason}{shown_messages(messages)}'
    )


def shown_messages(messages: str) -> str:
    """Return the end of a script's output, to be put behind an error."""
    lines = messages.rstrip().splitlines()
    return ''.join(f'\n  {line}' for line in lines[-SHOWN_LINES:])


def programs(environment: Mapping[str, str]) -> tuple[str, str]:
    """
    Find the programs that source a script: bash and env.

    :raises WorkspaceError: when one is missing
    """
    path = environment.get('PATH', os.defpath)
    found = []
    for name in ('bash', 'env'):
        program = shutil.which(name, path=path)
        program = program or shutil.which(name, path=os.defpath)
        if program is None:
            raise WorkspaceError(
                f"the program '{name}' is needed to source setup.bash, and "
                'it is not on the PATH',
                'install it',
            )
        found.append(program)
    return found[0], found[1]


def _no_setup(setup: Path) -> WorkspaceError:
    if not os.path.isfile(setup.with_suffix('.sh')):
        return WorkspaceError(
            f'there is no {setup}', 'build the workspace first'
        )
    return WorkspaceError(
        f'there is no {setup}, only a setup.sh',
        'install the package colcon-bash (pip install colcon-bash), then '
        'build again',
    )


def _run(
    command: Sequence[str],
    environment: Mapping[str, str],
    result: int,
    log: int,
    timeout: float,
) -> int | None:
    # files, not pipes: a process that a script left behind keeps a pipe open
    with subprocess.Popen(
        command,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=log,
        stderr=log,
        pass_fds=(result,),
        start_new_session=True,
    ) as process:
        try:
            return _wait(process, timeout, log)
        except subprocess.TimeoutExpired:
            return None
        finally:
            if process.returncode is None:
                with suppress(ProcessLookupError):
                    os.killpg(process.pid, signal.SIGKILL)


def _wait(process: subprocess.Popen[bytes], timeout: float, log: int) -> int:
    # Popen.wait() with a time-out looks only now and then
    with suppress(OSError, AttributeError):
        descriptor = os.pidfd_open(process.pid)
        deadline = time.monotonic() + timeout
        try:
            poll = select.poll()
            poll.register(descriptor, select.POLLIN)
            while not poll.poll(LOOK_INTERVAL * 1000):
                is_endless = os.fstat(log).st_size > MAXIMUM_OUTPUT
                if is_endless or time.monotonic() > deadline:
                    raise subprocess.TimeoutExpired(process.args, timeout)
        finally:
            os.close(descriptor)
    return process.wait(timeout)


def _content(file: int) -> bytes:
    return os.pread(file, os.fstat(file).st_size, 0)


def _variables(output: bytes, before: Mapping[str, str]) -> Mapping[str, str]:
    variables = {}
    for entry in output.split(b'\0'):
        name, separator, value = os.fsdecode(entry).partition('=')
        if separator:
            variables[name] = value
    for name in OWN_VARIABLES:
        variables.pop(name, None)
    kept = (*OWN_VARIABLES, *_BASH_VARIABLES)
    restored = {name: before[name] for name in kept if name in before}
    return {**restored, **variables}


def build_environment(
    environment: Mapping[str, str],
    install_base: Path,
    sourcing: Callable[[Path, Mapping[str, str]], Environment] = source,
) -> Environment:
    """
    Return the environment to build in, with the underlays that must survive.

    A shell with underlays is followed, as `colcon build` does; one without
    gets those that the workspace was built with before.

    :param environment: The caller's
    :raises WorkspaceError: when an underlay's script fails
    """
    chained = chained_underlays(install_base)
    sourced = sourced_underlays(environment, install_base)
    if not chained:
        return Environment(environment)
    if sourced:
        lost = [str(path) for path in chained if path not in sourced]
        if not lost:
            return Environment(environment)
        note = (
            f'the workspace was built on top of {", ".join(lost)}, which is '
            'not sourced in this shell: a build follows the shell. Source it '
            'and launch again if it is still needed'
        )
        return Environment(environment, notes=(note,))
    notes = list(gone_notes(install_base))
    used = []
    for prefix in chained:
        script = prefix / 'local_setup.bash'
        if os.path.isfile(script):
            environment = sourcing(script, environment).variables
            used.append(str(prefix))
    if used:
        notes.append(
            'nothing is sourced in this shell: building on top of '
            f'{", ".join(used)} as before'
        )
    return Environment(environment, notes=tuple(notes))


def chained_underlays(install_base: Path) -> list[Path]:
    """Return the underlays that the setup script sources first, in order."""
    for name in ('setup.bash', 'setup.sh'):
        path = install_base / name
        if os.path.isfile(path):
            prefixes = map(Path, _CHAINED.findall(text_of(path)))
            return [prefix for prefix in prefixes if prefix != install_base]
    return []


def gone_notes(install_base: Path) -> tuple[str, ...]:
    """
    Return notes on the underlays of the workspace that are gone.

    bash returns 0 nevertheless when it sources the workspace.
    """
    return tuple(
        f'the workspace was built on top of {prefix}, which is not '
        'there any more: source its successor if it has one'
        for prefix in chained_underlays(install_base)
        if not os.path.isfile(prefix / 'local_setup.bash')
    )


def sourced_underlays(
    environment: Mapping[str, str], install_base: Path
) -> list[Path]:
    """
    Return the underlays that colcon would chain in an environment.

    The rules are those of the `colcon_core.prefix_path` extensions of
    colcon-core and colcon-ros: the entries of COLCON_PREFIX_PATH, then those
    of AMENT_PREFIX_PATH that have a setup script of their own or belong to an
    isolated install space.

    :param install_base: The workspace's own, which is no underlay
    """
    prefixes = [
        Path(entry)
        for entry in split_path(environment.get('COLCON_PREFIX_PATH'))
        if Path(entry).exists()
    ]
    for entry in split_path(environment.get('AMENT_PREFIX_PATH')):
        path = Path(entry)
        if any(path.glob('local_setup.*')):
            prefixes.append(path)
        elif os.path.isfile(path.parent / '.colcon_install_layout'):
            prefixes.append(path.parent)
    return [p for p in dict.fromkeys(prefixes) if p != install_base]
