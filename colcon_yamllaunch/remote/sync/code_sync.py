# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The code of a launch brought to one machine, by that machine's `sync:`."""

from collections.abc import Callable
from collections.abc import Mapping
from collections.abc import Sequence
from contextlib import suppress
import os
from pathlib import Path
import platform
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.fingerprint import digest
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.text_files import content_of
from colcon_yamllaunch.remote.sync.build_words import build_words
from colcon_yamllaunch.remote.sync.build_words import path_there
from colcon_yamllaunch.remote.sync.install_listing import InstallListing
from colcon_yamllaunch.remote.sync.install_there import system
from colcon_yamllaunch.remote.sync.presence_there import version_of
from colcon_yamllaunch.remote.sync.remote_connection import Connection
from colcon_yamllaunch.remote.sync.remote_connection import Say
from colcon_yamllaunch.remote.sync.same_system import check_system
from colcon_yamllaunch.remote.sync.source_listing import Digests
from colcon_yamllaunch.remote.sync.source_listing import DIGESTS_NAME
from colcon_yamllaunch.remote.sync.source_listing import place_of
from colcon_yamllaunch.remote.sync.source_listing import source_trees
from colcon_yamllaunch.remote.sync.tree_bringing import bring
from colcon_yamllaunch.workspace.environment.underlays import chained_underlays
from colcon_yamllaunch.workspace.environment.underlays import sourced_underlays
from colcon_yamllaunch.workspace.packages.closure import closure
from colcon_yamllaunch.workspace.packages.package import Package

_BOOT_ID = Path('/proc/sys/kernel/random/boot_id')


class Code:
    """
    The workspace here, as far as machines need it; one for all of them.

    :param root: The root of the workspace
    :param packages: All packages of the workspace
    :param build_base: Where packages are built
    :param install_base: Where they are installed
    :param merge_install: Whether all packages are installed into one prefix
    :param build_arguments: Further arguments for `colcon build`
    :param settings: The arguments that packages are built with, as
      `BuildArguments.settings` has them
    :param environment: The user's variables
    :param title: The command, for those who wait for it there
    """

    def __init__(
        self,
        root: Path,
        packages: Sequence[Package],
        build_base: Path,
        install_base: Path,
        *,
        merge_install: bool,
        build_arguments: Sequence[str],
        settings: Mapping[str, str],
        environment: Mapping[str, str],
        title: str,
    ) -> None:
        self.root = root
        self.packages = tuple(packages)
        self.build_base = build_base
        self.install_base = install_base
        self.merge_install = merge_install
        self.build_arguments = tuple(build_arguments)
        self.settings = settings
        self.environment = environment
        self.title = title
        #: The digests of its files.
        self.digests = Digests(build_base / DIGESTS_NAME)

    @property
    def origin(self) -> str:
        """What tells this workspace from those of others."""
        return f'{platform.node()}:{os.path.realpath(self.root)}'


@dataclass(frozen=True, slots=True)
class Synced:
    """
    What came of it.

    :param transferred: How many files were brought or deleted
    :param built: The packages that were built there
    """

    transferred: int = 0
    built: frozenset[str] = frozenset()


def sync_code(
    mode: str,
    machine: str,
    workspace_there: str,
    connection: Connection,
    code: Code | None,
    needed: frozenset[str],
    say: Say,
) -> Synced:
    """
    Bring the code to one machine; in a thread for each machine.

    To interrupt it the connection is closed in another thread: what runs
    here and there is ended then, and it raises.

    :param mode: `build`, `install` or `none`
    :param machine: The name of the machine, for errors
    :param workspace_there: The root of the workspace there, absolute or
      with a leading `~/`
    :param code: The workspace here, or None: then there is nothing to do
    :param needed: The names of the packages that the parts there use; those
      that these need come along, those of underlays do not
    :param say: Is called with a line that the user should see at once
    :raises UserError: when the parts there cannot run with it; it names the
      machine and the way out
    """
    if code is None:
        return Synced()
    modes: dict[str, Callable[[_Sync], Synced]] = {
        'build': _Sync.build,
        'install': _Sync.install,
        'none': _Sync.check,
    }
    sync = _Sync(machine, workspace_there, connection, code, needed, say)
    try:
        return modes[mode](sync)
    except UserError as e:
        if str(e).startswith(f'{machine}: '):
            raise
        raise UserError(f'{machine}: {e}') from e
    except (KeyError, TypeError, ValueError, AttributeError) as e:
        raise UserError(
            f'{machine}: it answers what makes no sense when code is to be '
            f'brought there: {e!r}. Is that our own program?'
        ) from e


class _Sync:
    """Bringing code to one machine."""

    def __init__(
        self,
        machine: str,
        workspace_there: str,
        connection: Connection,
        code: Code,
        needed: frozenset[str],
        say: Say,
    ) -> None:
        self._machine = machine
        self._workspace_there = workspace_there
        self._connection = connection
        self._code = code
        self._say = say
        self._needed = needed
        names = frozenset(closure(code.packages, needed))
        self._packages = [p for p in code.packages if p.name in names]

    def build(self) -> Synced:
        """Bring the sources, and build them there."""
        if not self._packages:
            return Synced()
        code = self._code
        trees = source_trees(self._packages, code.root, code.digests)
        begun = self._begin({tree.place: tree.digest for tree in trees}, True)
        try:
            if not begun['changed']:
                return Synced(built=frozenset(begun['built']))
            transferred = bring(
                self._connection,
                begun['root'],
                code.origin,
                trees,
                [
                    *(place_of(p, code.root) for p in code.packages),
                    *(tree.place for tree in trees),
                ],
                begun['changed'],
                lambda: source_trees(self._packages, code.root, code.digests),
                self._say,
            )
            words = self._build_arguments() | {'root': begun['root']}
            built = self._ask('build_there.build', words)['built']
            return Synced(transferred, frozenset(built))
        finally:
            self._release(begun)

    def install(self) -> Synced:
        """Bring what is installed here."""
        if not self._packages:
            return Synced()
        code = self._code
        listing = InstallListing(
            code.root,
            code.install_base,
            [package.name for package in self._packages],
            code.digests,
            merged=code.merge_install,
        )
        underlays = list(map(str, chained_underlays(code.install_base)))
        found = self._ask(
            'install_there.look',
            {
                'workspace': self._workspace_there,
                'interpreters': listing.interpreters,
                'underlays': underlays,
            },
        )
        check_system(system(), found['system'], listing.pythons)
        missing = frozenset(found['missing'])
        for underlay in underlays:
            if underlay in missing:
                raise UserError(
                    f'what is built here needs {underlay}, which is not '
                    'there: install it there, or build there by `sync: build`'
                )
        root = found['root']
        trees = listing.trees(root, missing)
        begun = self._begin({tree.place: tree.digest for tree in trees}, False)
        try:
            if not begun['changed']:
                return Synced()
            transferred = bring(
                self._connection,
                root,
                code.origin,
                trees,
                # those of other packages are left as they are
                None,
                begun['changed'],
                lambda: listing.anew().trees(root, missing),
                self._say,
            )
            return Synced(transferred)
        finally:
            self._release(begun)

    def check(self) -> Synced:
        """Check that the packages are there."""
        code = self._code
        own = {package.name: package for package in self._packages}
        names = sorted({*own, *self._needed})
        if not names:
            return Synced()
        answer = self._ask(
            'presence_there.find',
            {
                'workspace': self._workspace_there,
                'install_base': path_there(code.install_base, code.root),
                'build_base': path_there(code.build_base, code.root),
                'names': names,
            },
        )
        found = answer['found']
        missing = [name for name in names if name not in found]
        if missing:
            raise UserError(
                f'not installed there: {", ".join(missing)}; looked in '
                f'{", ".join(answer["prefixes"]) or "no folder at all"}. '
                'Build it there, or let launches bring it by `sync: build`'
            )
        for name, package in own.items():
            line = _difference(package, *found[name])
            if line:
                self._say(line)
        return Synced()

    def _release(self, begun: Mapping[str, Any]) -> None:
        # if the connection is lost, so is the lock
        with suppress(UserError):
            self._ask('lock_there.release', {'holder': begun['holder']})

    def _begin(
        self, digests: Mapping[str, str], builds: bool
    ) -> dict[str, Any]:
        code = self._code
        return self._ask(
            'build_there.begin',
            {
                'workspace': self._workspace_there,
                'build_base': path_there(code.build_base, code.root),
                'title': f'{code.title} ({platform.node()})',
                'launcher': [_boot_id(), os.getpid()],
                'digests': digests,
                'build': self._build_arguments() if builds else None,
            },
        )

    def _build_arguments(self) -> dict[str, Any]:
        code = self._code
        underlays = [
            *chained_underlays(code.install_base),
            *sourced_underlays(code.environment, code.install_base),
        ]
        return {
            'needed': sorted(package.name for package in self._packages),
            'arguments': build_words(
                code.build_arguments,
                code.settings,
                merge_install=code.merge_install,
            ),
            'here': str(code.root),
            'underlays': list(dict.fromkeys(map(str, underlays))),
            'distro': code.environment.get('ROS_DISTRO', ''),
        }

    def _ask(self, request: str, values: Mapping[str, Any]) -> dict[str, Any]:
        return self._connection.ask(request, values, self._say)


def _difference(package: Package, digest_there: str, version: str) -> str:
    """Tell how a package there differs from that here, if it does."""
    try:
        manifest = content_of(package.path / 'package.xml')
    except OSError:
        return ''
    here = version_of(manifest)
    if not digest_there or digest(manifest) == digest_there:
        return ''
    if version != here:
        return (
            f'warning: {package.name} has version {version or "none"} there, '
            f'and {here or "none"} here'
        )
    return (
        f'warning: {package.name} has another package.xml there than here, '
        'of the same version'
    )


def _boot_id() -> str:
    try:
        return _BOOT_ID.read_text().strip()
    except OSError:
        return ''
