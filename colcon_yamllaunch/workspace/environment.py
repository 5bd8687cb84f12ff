# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The environment that a setup script makes."""

from collections.abc import Mapping
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from dataclasses import field
import os
from pathlib import Path
import shutil
import signal
import subprocess
import tempfile
from typing import IO

from colcon_yamllaunch.workspace.error import WorkspaceError

#: How long a setup script may take (seconds). With hundreds of packages on a
#: small board it takes some ten.
SOURCE_TIMEOUT = 120.0
#: How much of a script's output is shown when something went wrong (lines).
SHOWN_LINES = 12

#: Variables by which bash starts in another way than a fresh one would. The
#: options matter: colcon's scripts fail under `set -u`.
_BASH_VARIABLES = ('BASH_ENV', 'SHELLOPTS', 'BASHOPTS', 'POSIXLY_CORRECT')
#: Variables that bash sets for itself.
_OWN_VARIABLES = ('SHLVL', '_', 'PWD', 'OLDPWD')
#: The script is called with the setup script, the `env` command and the
#: number of the descriptor for the result.
_SCRIPT = """\
setup=$1 env=$2 result=$3
set --
source "$setup" 1>&2
code=$?
[ "$code" = 0 ] || exit "$code"
exec "$env" -0 >&"$result"
"""


@dataclass(frozen=True, slots=True)
class Environment:
    """
    What a setup script made of an environment.

    :param variables: All variables
    :param messages: What the script printed
    """

    variables: Mapping[str, str]
    messages: str = field(default='', compare=False)


def source(
    setup: Path,
    environment: Mapping[str, str],
    timeout: float = SOURCE_TIMEOUT,
) -> Environment:
    """
    Get the environment that `source SETUP` makes in a fresh bash.

    :param setup: The script
    :param environment: The variables before; left as they are
    :param timeout: Seconds that the script may take
    :raises WorkspaceError: when it is missing, fails or takes too long
    """
    bash, env = _programs(environment)
    if not setup.is_file():
        raise WorkspaceError(_no_setup(setup))
    with tempfile.TemporaryFile() as result, tempfile.TemporaryFile() as log:
        returncode = _run(
            [
                bash,
                *('--noprofile', '--norc', '-c', _SCRIPT, 'colcon launch'),
                *(str(setup), env, str(result.fileno())),
            ],
            _without(environment, _BASH_VARIABLES),
            result,
            log,
            timeout,
        )
        output, messages = _content(result), os.fsdecode(_content(log))
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


def missing_packages(
    environment: Environment,
    names: Sequence[str],
    install_base: Path,
    merge_install: bool,
) -> dict[str, str]:
    """
    Find packages that sourcing did not bring in, though it returned 0.

    colcon's scripts return 0 when a file of theirs is broken, and when
    installed packages depend on each other in a circle (colcon-core issue
    734). So what the packages' hooks put in is looked for.

    :param environment: What the setup script made
    :param names: Packages of the workspace
    :param install_base: The install folder of the workspace
    :param merge_install: Whether all packages are installed into one prefix
    :returns: For each missing one the explanation with the cure
    """
    missing = {}
    for name in names:
        prefix = install_base if merge_install else install_base / name
        reason = _missing(environment.variables, name, prefix, install_base)
        if reason is not None:
            missing[name] = (
                f'sourcing {install_base / "setup.bash"} did not bring in '
                f'{name}: {reason}{shown_messages(environment.messages)}\n'
                f'Remove {prefix}, then launch again to have it built anew'
            )
    return missing


def shown_messages(messages: str) -> str:
    """Get the end of a script's output, to be put behind an error."""
    lines = messages.rstrip().splitlines()
    if not lines:
        return ''
    return ''.join(f'\n  {line}' for line in ['', *lines[-SHOWN_LINES:]][1:])


def split_path(value: str | None) -> list[str]:
    """Get the entries of a variable such as PATH that are not empty."""
    return [entry for entry in (value or '').split(os.pathsep) if entry]


def _programs(environment: Mapping[str, str]) -> tuple[str, str]:
    path = environment.get('PATH', os.defpath)
    found = []
    for name in ('bash', 'env'):
        program = shutil.which(name, path=path)
        program = program or shutil.which(name, path=os.defpath)
        if program is None:
            raise WorkspaceError(
                f"the program '{name}' is needed to source setup.bash, and "
                'it is not on the PATH: install it'
            )
        found.append(program)
    return found[0], found[1]


def _no_setup(setup: Path) -> str:
    if not setup.with_suffix('.sh').is_file():
        return f'there is no {setup}: build the workspace first'
    return (
        f'there is no {setup}, only a setup.sh: install the package '
        'colcon-bash (pip install colcon-bash), then build again'
    )


def _run(
    command: Sequence[str],
    environment: Mapping[str, str],
    result: IO[bytes],
    log: IO[bytes],
    timeout: float,
) -> int | None:
    # files, not pipes: a process that a script left behind keeps a pipe open
    with subprocess.Popen(
        command,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=log,
        stderr=log,
        pass_fds=(result.fileno(),),
        start_new_session=True,
    ) as process:
        try:
            return process.wait(timeout)
        except subprocess.TimeoutExpired:
            return None
        finally:
            if process.returncode is None:
                with suppress(ProcessLookupError):
                    os.killpg(process.pid, signal.SIGKILL)


def _content(file: IO[bytes]) -> bytes:
    file.seek(0)
    return file.read()


def _variables(output: bytes, before: Mapping[str, str]) -> Mapping[str, str]:
    variables = {}
    for entry in output.split(b'\0'):
        name, separator, value = os.fsdecode(entry).partition('=')
        if separator:
            variables[name] = value
    for name in _OWN_VARIABLES:
        variables.pop(name, None)
    kept = (*_OWN_VARIABLES, *_BASH_VARIABLES)
    restored = {name: before[name] for name in kept if name in before}
    return {**restored, **variables}


def _without(
    environment: Mapping[str, str], names: Sequence[str]
) -> dict[str, str]:
    return {k: v for k, v in environment.items() if k not in names}


def _missing(
    variables: Mapping[str, str], name: str, prefix: Path, install_base: Path
) -> str | None:
    if not (prefix / 'share' / name / 'package.sh').is_file():
        return f'it is not installed in {prefix}'
    if not _has(variables, 'COLCON_PREFIX_PATH', install_base):
        return f'COLCON_PREFIX_PATH lacks {install_base}'
    for variable, path in _promised(prefix, f'share/{name}/package.dsv'):
        if not _has(variables, variable, path):
            return f'{variable} lacks {path}'
    return None


def _has(variables: Mapping[str, str], name: str, path: Path) -> bool:
    entries = split_path(variables.get(name))
    if str(path) in entries:
        return True
    real = os.path.realpath(path)
    return any(os.path.realpath(entry) == real for entry in entries)


def _promised(prefix: Path, relative: str) -> list[tuple[str, Path]]:
    """
    Get the path entries that a dsv file puts in.

    The format is that of colcon's prefix scripts, one
    `operation;argument;…` a line (colcon-core, shell/template/prefix_util.py).
    """
    promised: list[tuple[str, Path]] = []
    pending, seen = [relative], set[str]()
    while pending:
        current = pending.pop()
        if current in seen or not current.endswith('.dsv'):
            continue
        seen.add(current)
        for operation, arguments in _dsv_lines(prefix / current):
            if operation == 'source' and arguments:
                pending.append(arguments[0])
            elif operation.startswith('prepend-non-duplicate'):
                promised += _entries(operation, arguments, prefix)
    return promised


def _entries(
    operation: str, arguments: list[str], prefix: Path
) -> list[tuple[str, Path]]:
    if not arguments:
        return []
    variable, *values = arguments
    paths = [
        Path(os.path.normpath(prefix / value)) for value in values or ['']
    ]
    if operation.endswith('-if-exists'):
        paths = [path for path in paths if path.exists()]
    return [(variable, path) for path in paths]


def _dsv_lines(path: Path) -> list[tuple[str, list[str]]]:
    try:
        text = path.read_text(encoding='utf-8', errors='replace')
    except OSError:
        return []
    lines = [line.split(';') for line in text.splitlines() if line]
    return [(fields[0], fields[1:]) for fields in lines]
