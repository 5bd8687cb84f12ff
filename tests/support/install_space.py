# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Install spaces as colcon and ament leave them, made without a build."""

from collections.abc import Iterable
import os
from pathlib import Path
import subprocess
from unittest.mock import patch

from colcon_bash.shell.bash import BashShell
from colcon_core.shell.sh import ShShell

#: Variables by which colcon would chain what this process has sourced.
_CHAINING = ('COLCON_PREFIX_PATH', 'AMENT_PREFIX_PATH', 'CMAKE_PREFIX_PATH')


class InstallSpace:
    """
    An install space.

    :param path: Its folder, which is made
    :param merged: Whether all packages share one prefix
    :param chained: The install spaces that it is built on top of, the last
      one sourced first
    """

    def __init__(
        self, path: Path, merged: bool = False, chained: Iterable[Path] = ()
    ) -> None:
        self.path = path
        self.merged = merged
        path.mkdir(parents=True)
        _write_scripts(path, merged, chained)

    @property
    def setup(self) -> Path:
        return self.path / 'setup.bash'

    def prefix(self, name: str) -> Path:
        return self.path if self.merged else self.path / name

    def write(self, name: str, path: str, text: str) -> Path:
        """Write a file into the prefix of a package."""
        file = self.prefix(name) / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        return file

    def package(
        self, name: str, *lines: str, needs: str = '', script: str = ''
    ) -> None:
        """
        Install a package.

        :param name: Its name
        :param lines: What its hook does, as lines of a dsv file
        :param needs: The packages that it needs, with colons between
        :param script: A hook that is a script
        """
        share = f'share/{name}'
        self.write(name, f'share/colcon-core/packages/{name}', needs)
        self.write(name, f'{share}/package.sh', '')
        hooks = f'source;{share}/hook/own.dsv\nsource;{share}/hook/own.sh\n'
        self.write(name, f'{share}/hook/own.sh', 'export NEVER=1\n')
        self.write(
            name,
            f'{share}/hook/own.dsv',
            '\n'.join(lines or ('prepend-non-duplicate;AMENT_PREFIX_PATH;',)),
        )
        if script:
            hooks += f'source;{share}/hook/more.sh\n'
            self.write(name, f'{share}/hook/more.sh', script)
        self.write(name, f'{share}/package.dsv', hooks)


def _write_scripts(path: Path, merged: bool, chained: Iterable[Path]) -> None:
    variables = {k: v for k, v in os.environ.items() if k not in _CHAINING}
    variables['COLCON_PREFIX_PATH'] = os.pathsep.join(map(str, chained))
    with patch.dict(os.environ, variables, clear=True):
        for shell in (ShShell(), BashShell()):
            shell.create_prefix_script(path, merged)


def in_bash(
    setup: Path, environment: dict[bytes, bytes], cwd: Path
) -> dict[bytes, bytes]:
    """
    Get the variables that sourcing gives in a fresh bash, byte for byte.

    What bash keeps for itself stays as the caller has it.
    """
    printed = subprocess.run(
        ['bash', '--noprofile', '--norc', '-c', f". '{setup}' >&2; env -0"],
        env=environment,
        cwd=cwd,
        check=True,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    ).stdout
    own = (b'SHLVL', b'_', b'PWD', b'OLDPWD')
    entries = (e.split(b'=', 1) for e in printed.split(b'\0') if e)
    variables = {name: value for name, value in entries if name not in own}
    kept = {name: environment[name] for name in own if name in environment}
    return variables | kept
