# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Whose workspaces are used.

What is in a workspace runs as whoever launches there. So it has to be the
user's own or root's, as git has it for its repositories (`safe.directory`).
Owners count and modes do not, as in git: file systems without owners show
everything as writable for everyone. A folder with the sticky bit is the
exception, as others are invited to put files there.
"""

from collections.abc import Mapping
import os
from pathlib import Path
import shlex
import stat

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.search_path import split_path

#: The variable that lists the folders of others whose workspaces are used.
TRUST = 'COLCON_LAUNCH_TRUST'
#: What stands for all folders in it.
ALL = '*'

#: What a workspace consists of beside its packages: in the root, in the build
#: folder and in the install folder.
_OWN = ('', '/log', '/colcon_defaults.yaml')
_BUILT = (
    *('', '/.built_by', '/.colcon_launch.lock', '/.colcon_launch.index.json'),
    '/.colcon_launch_environments',
)
_INSTALLED = (
    *('', '/.colcon_install_layout', '/setup.bash', '/setup.sh'),
    *('/local_setup.bash', '/local_setup.sh', '/_local_setup_util_sh.py'),
)


class UntrustedError(UserError):
    """A workspace belongs to somebody else, who is not trusted."""


class Trust:
    """
    Whose files the user lets run as himself: his own, root's, and listed ones.

    :param environment: The variables of the user; for root, `SUDO_UID` is who
      he is beside, as in git
    """

    def __init__(self, environment: Mapping[str, str]) -> None:
        user = os.geteuid()
        self._users = {0, user}
        sudo = environment.get('SUDO_UID', '')
        if user == 0 and sudo.isascii() and sudo.isdecimal():
            self._users.add(int(sudo))
        self._listed = split_path(environment.get(TRUST))

    def may_search(self, folder: Path) -> bool:
        """Tell whether a folder is the user's or root's, or listed."""
        return self._stranger(folder) is None or self._is_listed(folder)

    def check(
        self,
        root: Path,
        build_base: Path | None = None,
        install_base: Path | None = None,
    ) -> None:
        """
        Check that a workspace may be used.

        :param root: Its root, without symbolic links
        :param build_base: Its build folder, if it has another name
        :param install_base: Its install folder likewise
        :raises UntrustedError: when it may not
        """
        build = build_base or root / 'build'
        install = install_base or root / 'install'
        paths = [
            *(f'{root}{name}' for name in _OWN),
            *(f'{build}{name}' for name in _BUILT),
            *(f'{install}{name}' for name in _INSTALLED),
        ]
        for path in paths:
            stranger = self._stranger(path)
            if stranger is not None and not self._is_listed(root):
                raise UntrustedError(
                    f'the workspace {root} is not used: {path} belongs to '
                    f'{_name(stranger)}, and what is in it would run as you',
                    self._cure(root),
                )
        if _is_for_everyone(root) and not self._is_listed(root):
            raise UntrustedError(
                f'{root} is not used as a workspace: everyone may put files '
                f'there, and they would run as you',
                self._cure(root),
            )

    def _stranger(self, path: Path | str) -> int | None:
        """Return the user whose a path is, unless it is one's own."""
        try:
            status = os.lstat(path)
            # of a link both count: whoever made it chose where it leads
            if status.st_uid in self._users and stat.S_ISLNK(status.st_mode):
                status = os.stat(path)
        except OSError:
            return None
        return None if status.st_uid in self._users else status.st_uid

    def _is_listed(self, folder: Path) -> bool:
        """Tell whether the user trusts a folder, whosever it is."""
        return any(
            entry == ALL
            or (
                os.path.isabs(entry)
                and folder.is_relative_to(os.path.realpath(entry))
            )
            for entry in self._listed
        )

    def _cure(self, root: Path) -> str:
        words = shlex.quote(os.pathsep.join((*self._listed, str(root))))
        return (
            f'to use it nevertheless: export {TRUST}={words} (or name another '
            'one with --workspace)'
        )


def _is_for_everyone(folder: Path) -> bool:
    try:
        mode = folder.stat().st_mode
    except OSError:
        return False
    bits = stat.S_ISVTX | stat.S_IWOTH
    return mode & bits == bits


def _name(user: int) -> str:
    # nearly all workspaces are one's own
    import pwd

    try:
        return f'{pwd.getpwuid(user).pw_name} (user {user})'
    except KeyError:
        return f'user {user}'
