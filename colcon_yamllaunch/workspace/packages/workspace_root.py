# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Where a workspace begins, and whether it may be used.

What is in a workspace runs as whoever launches there. So it has to be the
user's own or root's, as git has it for its repositories (`safe.directory`).
Owners count and modes do not, as in git: file systems without owners show
everything as writable for everyone. A folder with the sticky bit is the
exception, as others are invited to put files there.
"""

from collections import deque
from collections.abc import Mapping
import os
from pathlib import Path
import shlex
import stat

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.files import split_path, text_of

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


#: How many folders deep packages are looked for to tell a workspace.
PACKAGE_SEARCH_DEPTH = 5
#: How many folders are read at most to tell a workspace.
PACKAGE_SEARCH_FOLDERS = 500
#: Files that colcon makes, which nothing else does.
_STRONG_MARKERS = ('install/.colcon_install_layout', 'build/.built_by')
_WEAK_MARKERS = ('install', 'build')
_PACKAGE_FILES = (
    *('package.xml', 'CMakeLists.txt', 'setup.py', 'pyproject.toml'),
    'colcon.pkg',
)
_BUILD_FILES = (*_PACKAGE_FILES, 'setup.cfg')
#: The file that makes a folder a virtual environment (PEP 405). colcon crawls
#: it, and takes what is installed there for packages of the workspace.
VIRTUAL_ENVIRONMENT = 'pyvenv.cfg'
#: What colcon does not crawl below (colcon-core, colcon-ros).
IGNORE_MARKERS = (
    *('COLCON_IGNORE', 'AMENT_IGNORE', 'CATKIN_IGNORE'),
    VIRTUAL_ENVIRONMENT,
)


class UntrustedError(UserError):
    """A workspace belongs to somebody else, who is not trusted."""


class Trust:
    """
    Whose files may run: those of the user, of root, and of listed folders.

    :param environment: The variables of the user; for root, `SUDO_UID` names
      the user who called `sudo`, as in git
    """

    def __init__(self, environment: Mapping[str, str]) -> None:
        user = os.geteuid()
        self._users = {0, user}
        sudo = environment.get('SUDO_UID', '')
        if user == 0 and sudo.isascii() and sudo.isdecimal():
            self._users.add(int(sudo))
        self._listed = split_path(environment.get(TRUST))

    def may_search(self, folder: Path) -> bool:
        """Return whether a folder is the user's or root's, or listed."""
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
        if self._is_listed(root):
            return
        for path in paths:
            stranger = self._stranger(path)
            if stranger is not None:
                raise UntrustedError(
                    f'the workspace {root} is not used: {path} belongs to '
                    f'{_name(stranger)}, and what is in it would run as you',
                    self._cure(root),
                )
        for_everyone = stat.S_ISVTX | stat.S_IWOTH
        if _mode(root) & for_everyone == for_everyone:
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
        """Return whether the user trusts a folder, whosever it is."""
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


def _mode(folder: Path) -> int:
    try:
        return folder.stat().st_mode
    except OSError:
        return 0


def _name(user: int) -> str:
    # nearly all workspaces are one's own
    import pwd

    try:
        return f'{pwd.getpwuid(user).pw_name} (user {user})'
    except KeyError:
        return f'user {user}'


def find_root(
    start: Path,
    home: Path | None = None,
    trust: Trust | None = None,
    *,
    searches: bool = True,
) -> Path | None:
    """
    Find the workspace that a folder belongs to, if any.

    It is the nearest folder from here upwards that colcon built in, or that
    has an `install/`, a `build/` or a `src/` with packages. Only a folder that
    colcon built in may be a package itself or the home folder. A folder below
    the `src/` of a workspace that was built is never taken for one of its own
    just because of the names in it.

    What belongs to others is passed over, and not looked through.

    :param home: The user's home folder; the current user's if not given
    :param trust: Who is trusted; as the environment has it if not given
    :param searches: Whether a folder that has only packages below may be one
    :raises UntrustedError: when there are only workspaces of others
    """
    start = Path(os.path.realpath(start))
    home = Path(os.path.realpath(home or Path('~').expanduser()))
    trust = trust or Trust(os.environ)
    weak: Path | None = None
    refused: UntrustedError | None = None
    for folder in (start, *start.parents):
        is_strong = any(os.path.isfile(folder / m) for m in _STRONG_MARKERS)
        if not (is_strong or (not weak and _is_weak(folder, home, trust))):
            continue
        try:
            trust.check(folder)
        except UntrustedError as e:
            refused = refused or e
            continue
        if is_strong:
            inside = weak is not None and weak.is_relative_to(folder / 'src')
            return folder if weak is None or inside else weak
        weak = folder
    if weak is not None:
        return weak
    depth = PACKAGE_SEARCH_DEPTH if trust.may_search(start) else 1
    searches = searches and _may_be_weak(start, home)
    if searches and has_package_below(start, depth):
        trust.check(start)
        return start
    if refused is not None:
        raise refused
    return None


def is_package(folder: Path) -> bool:
    """Return whether a folder looks like a package of any type."""
    # unlike Path.is_file(), this copes with links that may not be followed
    return any(
        os.path.isfile(folder / name) for name in _PACKAGE_FILES
    ) or _names_a_project(folder / 'setup.cfg')


def has_package_below(
    folder: Path, levels: int = PACKAGE_SEARCH_DEPTH
) -> bool:
    """
    Return whether there is a package in a folder below the given one.

    At most :data:`PACKAGE_SEARCH_FOLDERS` folders are looked at, nearest
    first.

    :param levels: How many folders deep to look
    """
    pending = deque([(str(folder), 0)])
    seen = 0
    while pending and seen <= PACKAGE_SEARCH_FOLDERS:
        current, depth = pending.popleft()
        seen += 1
        try:
            with os.scandir(current) as scanned:
                entries = sorted(scanned, key=lambda entry: entry.name)
        except OSError:
            continue
        names = {entry.name for entry in entries}
        if depth and not names.isdisjoint(IGNORE_MARKERS):
            continue
        may_be_one = depth > 0 and not names.isdisjoint(_BUILD_FILES)
        if may_be_one and is_package(Path(current)):
            return True
        if depth < levels:
            pending += [
                (entry.path, depth + 1)
                for entry in entries
                if not entry.name.startswith('.') and is_folder(entry)
            ]
    return False


def is_folder(entry: os.DirEntry[str]) -> bool:
    """Return whether an entry is a folder, or a link to one."""
    try:
        return entry.is_dir()
    except OSError:
        return False


def is_ignored(folder: Path) -> bool:
    """Return whether no packages of a workspace are in a folder."""
    return any(os.path.lexists(folder / name) for name in IGNORE_MARKERS)


def _is_weak(folder: Path, home: Path, trust: Trust) -> bool:
    if not _may_be_weak(folder, home):
        return False
    if any(os.path.isdir(folder / marker) for marker in _WEAK_MARKERS):
        return True
    source = folder / 'src'
    if not os.path.isdir(source):
        return False
    return not trust.may_search(folder) or has_package_below(source)


def _may_be_weak(folder: Path, home: Path) -> bool:
    # in /proc there are links to all that processes use
    is_common = (
        home.is_relative_to(folder)
        or folder.is_relative_to('/proc')
        # such as /tmp: what lies there says nothing about what is beside it
        or bool(_mode(folder) & stat.S_ISVTX)
    )
    return not is_common and not is_package(folder)


def _names_a_project(path: Path) -> bool:
    if not os.path.isfile(path):
        return False
    _, _, metadata = f'\n{text_of(path)}'.partition('\n[metadata]')
    lines = metadata.partition('\n[')[0].splitlines()
    return any(line.partition('=')[0].strip() == 'name' for line in lines)
