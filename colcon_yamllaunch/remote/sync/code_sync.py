# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The code of a launch sent to one machine, by that machine's `sync:`."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import partial
import json
import os
from pathlib import Path
import platform
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.files import content_of
from colcon_yamllaunch.common.fingerprint import digest
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.remote.agent.part_sockets import boot_of_machine
from colcon_yamllaunch.remote.connection.machine_connection import (
    MachineConnection,
    Say,
)
from colcon_yamllaunch.remote.sync import listing
from colcon_yamllaunch.remote.sync.inspection import system, version_of
from colcon_yamllaunch.remote.sync.transfer import ChangeTexts, Transfer
from colcon_yamllaunch.workspace.environment.sourcing import (
    chained_underlays,
    sourced_underlays,
)
from colcon_yamllaunch.workspace.packages.package import closure, Package

#: They name files here; their values are in the settings.
_LEFT_OUT = frozenset({'--mixin', '--mixin-files'})
#: A launch sets the first, and the layout of the workspace the second.
_ANYWAY = ('symlink_install', 'merge_install')
_FOLDERS = {'build_base': 'build', 'install_base': 'install'}


@dataclass(frozen=True, slots=True)
class Code:
    """
    The workspace here, for all machines.

    :param root: The root of the workspace
    :param packages: All packages of the workspace
    :param build_base: Where packages are built
    :param install_base: Where they are installed
    :param merge_install: Whether all packages are installed into one prefix
    :param build_arguments: Further arguments for `colcon build`
    :param settings: The arguments that packages are built with, as
      `BuildArguments.settings` has them
    :param environment: The user's variables
    :param title: The command, for other launches that wait for it there
    """

    root: Path
    packages: Sequence[Package]
    build_base: Path
    install_base: Path
    merge_install: bool
    build_arguments: Sequence[str]
    settings: Mapping[str, str]
    environment: Mapping[str, str]
    title: str

    @property
    def origin(self) -> str:
        """The identity of this workspace among those of others."""
        return f'{platform.node()}:{os.path.realpath(self.root)}'


@dataclass(frozen=True, slots=True)
class Synced:
    """
    The result of sending code to a machine.

    :param transferred: How many files were sent or deleted
    :param built: The packages that were built there
    """

    transferred: int = 0
    built: frozenset[str] = frozenset()


def sync_code(
    mode: str,
    machine: str,
    remote_workspace: str,
    connection: MachineConnection,
    code: Code | None,
    needed: frozenset[str],
    say: Say,
) -> Synced:
    """
    Send the code to one machine; each machine has its own thread.

    Another thread can interrupt it: it closes the connection, which stops the
    processes here and there, and this raises.

    :param mode: `build`, `install` or `none`
    :param machine: The name of the machine, for errors
    :param remote_workspace: The root of the workspace there, absolute or
      with a leading `~/`
    :param code: The workspace here, or None: then there is nothing to do
    :param needed: The names of the packages that the parts there use; their
      dependencies are added, and packages of underlays are not sent
    :param say: Called with lines for the user
    :raises UserError: when the parts there cannot run; it names the machine
      and the fix
    """
    if code is None:
        return Synced()
    sync = _Sync(remote_workspace, connection, code, needed, say)
    if mode != 'none' and not sync.packages:
        return Synced()
    modes = {'build': sync.build, 'install': sync.install, 'none': sync.check}
    try:
        return modes[mode]()
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
    """One transfer of code to a machine."""

    def __init__(
        self,
        remote_workspace: str,
        connection: MachineConnection,
        code: Code,
        needed: frozenset[str],
        say: Say,
    ) -> None:
        self._remote_workspace = remote_workspace
        self._connection = connection
        self._code = code
        self._say = say
        self._needed = needed
        names = frozenset(closure(code.packages, needed))
        #: The packages that are needed there.
        self.packages = [p for p in code.packages if p.name in names]

    def build(self) -> Synced:
        """Send the sources, and build them there."""
        code = self._code
        list_trees = partial(listing.source_trees, self.packages, code.root)
        trees = list_trees()
        places = [listing.place_of(p, code.root) for p in code.packages]
        places += [tree.place for tree in trees]
        words = self._build_arguments()
        with self._locked(trees, build=words) as answer:
            count = self._transfer(answer, trees, list_trees, places)
            if answer['changed']:
                words['root'] = answer['root']
                answer = self._ask('build.build', words)
            return Synced(count, frozenset(answer['built']))

    def install(self) -> Synced:
        """Send the installed files."""
        code = self._code
        list_trees = partial(
            listing.install_trees,
            code.root,
            code.install_base,
            [package.name for package in self.packages],
            merged=code.merge_install,
        )
        trees = list_trees()
        needs = {
            'built_on': system(),
            'pythons': listing.pythons_of(trees),
            'underlays': list(map(str, chained_underlays(code.install_base))),
        }
        with self._locked(trees, needs=needs) as begun:
            change_texts = partial(
                listing.changed_texts,
                root=code.root,
                remote_root=begun['root'],
                missing_of=lambda paths: self._ask(
                    'inspection.find_missing', {'paths': paths}
                )['missing'],
            )
            # those of other packages are left as they are
            return Synced(
                self._transfer(begun, trees, list_trees, None, change_texts)
            )

    def _transfer(
        self,
        begun: Mapping[str, Any],
        trees: Sequence[listing.FileTree],
        list_trees: Callable[[], Sequence[listing.FileTree]],
        places: Sequence[str] | None,
        change_texts: ChangeTexts = lambda _: {},
    ) -> int:
        """Send what differs, and return how many files were sent."""
        if not begun['changed']:
            return 0
        return Transfer(
            self._connection,
            begun['root'],
            self._code.origin,
            list_trees,
            places,
            self._say,
            change_texts,
        ).send(trees, begun['changed'])

    def check(self) -> Synced:
        """Check that the packages are there."""
        code = self._code
        own = {package.name: package for package in self.packages}
        names = sorted({*own, *self._needed})
        if not names:
            return Synced()
        answer = self._ask(
            'inspection.find_packages',
            {
                'workspace': self._remote_workspace,
                'install_base': remote_path(code.install_base, code.root),
                'build_base': remote_path(code.build_base, code.root),
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

    @contextmanager
    def _locked(
        self,
        trees: Sequence[listing.FileTree],
        *,
        build: Mapping[str, Any] | None = None,
        needs: Mapping[str, Any] | None = None,
    ) -> Iterator[dict[str, Any]]:
        """Hold the lock of the workspace there; yield the answer."""
        code = self._code
        begun = self._ask(
            'build.begin',
            {
                'workspace': self._remote_workspace,
                'build_base': remote_path(code.build_base, code.root),
                'title': f'{code.title} ({platform.node()})',
                'launcher': [boot_of_machine(), os.getpid()],
                'origin': code.origin,
                'states': {tree.place: tree.state for tree in trees},
                'build': build,
                'needs': needs,
            },
        )
        try:
            yield begun
        finally:
            # if the connection is lost, so is the lock
            with suppress(UserError):
                self._ask('build.end', {'holder': begun['holder']})

    def _build_arguments(self) -> dict[str, Any]:
        code = self._code
        underlays = [
            *chained_underlays(code.install_base),
            *sourced_underlays(code.environment, code.install_base),
        ]
        return {
            'needed': sorted(package.name for package in self.packages),
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


def _difference(package: Package, remote_digest: str, version: str) -> str:
    """Return a line about the difference to a package there, if any."""
    try:
        manifest = content_of(package.path / 'package.xml')
    except OSError:
        return ''
    here = version_of(manifest)
    if not remote_digest or digest(manifest) == remote_digest:
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


def build_words(
    given: Sequence[str], settings: Mapping[str, str], *, merge_install: bool
) -> list[str]:
    """
    Return the arguments of `colcon build` there.

    Defaults and mixins belong to the user, and may differ there; so the
    arguments that they have resulted in here replace them.

    :param given: The arguments of the user
    :param settings: All arguments, with the defaults and mixins here
    :param merge_install: Whether all packages are installed into one prefix
    """
    values = {
        f'--{name.replace("_", "-")}': (name, json.loads(text))
        for name, text in sorted(settings.items())
    }
    lists = {o for o, (_, value) in values.items() if isinstance(value, list)}
    words = _without(given, _LEFT_OUT | lists)
    for option, (name, value) in values.items():
        if isinstance(value, list) and value:
            # colcon takes a word with a dash for an option of its own
            words += [
                option,
                *(f' {w}' if w[:1] == '-' else w for w in map(str, value)),
            ]
        elif value is True and name not in _ANYWAY and option not in words:
            words.append(option)
        elif name in _FOLDERS and value not in (None, _FOLDERS[name]):
            words = [*_without(words, {option}), option, str(value)]
    if merge_install and '--merge-install' not in words:
        words.append('--merge-install')
    return words


def remote_path(path: Path, root: Path) -> str:
    """Return a folder for the machine: relative if it is in the workspace."""
    if path.is_relative_to(root):
        return os.path.relpath(path, root)
    return str(path)


def _without(words: Sequence[str], options: Collection[str]) -> list[str]:
    """Return words without some options and their values."""
    kept = []
    is_left_out = False
    for word in words:
        if word.startswith('--'):
            is_left_out = word.partition('=')[0] in options
        if not is_left_out:
            kept.append(word)
    return kept
