# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a change requires on other machines, for every kind of file."""

from dataclasses import dataclass
import itertools
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from colcon_yamllaunch.common.fingerprint import Fingerprint
from colcon_yamllaunch.language.policies.evaluate import Evaluation
from colcon_yamllaunch.language.syntax.source_text import Source
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.watch.consequences import affected_by_build
from colcon_yamllaunch.watch.consequences import consequences
from colcon_yamllaunch.watch.consequences import Steps
from colcon_yamllaunch.watch.consequences import steps
from colcon_yamllaunch.watch.dependencies import Dependencies
from colcon_yamllaunch.watch.dependencies import find_dependencies
from colcon_yamllaunch.watch.dependencies import RemoteDependencies
from colcon_yamllaunch.watch.watched_files import Change
from colcon_yamllaunch.workspace.freshness.build_record import Record
from colcon_yamllaunch.workspace.freshness.build_record import RECORD_NAME
from colcon_yamllaunch.workspace.freshness.build_record import write_record
from colcon_yamllaunch.workspace.packages.package import Package
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator
import pytest

HERE = Position('demo.yaml', 1, 1)
ELF = '\x7fELF'
PYTHON = '#!/usr/bin/python3\n'
LAUNCH = 'launch/demo.yaml'


@dataclass(frozen=True)
class Kind:
    """
    A kind of file in the package `arm`, and the process that uses it.

    :param source: The file that is saved
    :param program: The program of the process, in the install space
    :param code: How that begins
    :param built: What differs on a machine once it has the change, in the
      install space
    :param is_live: Whether it is linked into the install space here
    """

    source: str
    program: str
    code: str
    built: str
    is_live: bool = True


KINDS = {
    'ament_cmake script': Kind(
        'scripts/talk.py', 'lib/arm/talk.py', PYTHON, 'lib/arm/talk.py'
    ),
    'library': Kind(
        'src/word.cpp', 'lib/arm/talk', ELF, 'lib/libword.so', is_live=False
    ),
    'C++ program': Kind(
        'src/talk.cpp', 'lib/arm/talk', ELF, 'lib/arm/talk', is_live=False
    ),
    'ament_python module': Kind(
        'arm/word.py',
        'lib/arm/run',
        PYTHON,
        'lib/python3.12/site-packages/arm/word.py',
    ),
    'configuration': Kind(
        'config/c.yaml', 'lib/arm/talk', ELF, 'share/arm/config/c.yaml'
    ),
    'launch file': Kind(LAUNCH, 'lib/arm/talk', ELF, 'share/arm/' + LAUNCH),
}


class Launched:
    """A launch whose process `talk` runs on the machine `arm`."""

    def __init__(
        self, root: Path, kind: Kind, sync: str, label: str, *, installed: bool
    ) -> None:
        self.kind = kind
        self.label = label
        self.source = root / 'src/arm' / kind.source
        self.install = root / 'install/arm'
        self.program = str(self.install / kind.program)
        config = str(self.install / 'share/arm/config/c.yaml')
        self._write(self.source, kind.code)
        if installed:
            self._install(root)
        package = Package('arm', root / 'src/arm', 'ros.ament_cmake')
        colcon: Any = SimpleNamespace(
            root=root,
            build_base=root / 'build',
            install_base=root / 'install',
        )
        locator = PackageLocator([package], root / 'install', False, {})
        talk = Process(
            *(label, (self.program, config), str(root), HERE, 'talk'),
            package='arm',
        )
        files = frozenset((self.program, config))
        there = RemoteDependencies(
            {label: 'arm'},
            {label: files},
            {'arm': frozenset(('arm',))},
            {'arm': 'sync: none'} if sync == 'none' else {},
        )
        launch = str(root / 'src/arm' / LAUNCH)
        self.known = find_dependencies(
            Plan((talk,)),
            Evaluation((), (Source(launch, launch, ''),), {}, (), (), Plan()),
            *(colcon, locator, ('arm',) if installed else ()),
            *({}, {}, there),
        )

    def _install(self, root: Path) -> None:
        kind = self.kind
        self._write(self.install / kind.program, kind.code)
        live = frozenset({kind.source} if kind.is_live else ())
        links = {}
        if kind.is_live:
            link = self.install / kind.built
            link.unlink(missing_ok=True)
            link.parent.mkdir(parents=True, exist_ok=True)
            link.symlink_to(self.source)
            told = Fingerprint(1, 1, True, f'link to {self.source}')
            links = {f'arm/{kind.built}': told}
        record = Record(
            str(root / 'src/arm'),
            {},
            succeeded=True,
            live=live,
            installed=links,
        )
        (root / 'build/arm').mkdir(parents=True)
        write_record(root / 'build/arm' / RECORD_NAME, record)

    def _write(self, path: Path, text: str) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        path.chmod(0o755)

    @property
    def steps(self) -> Steps:
        """What follows when the file is saved."""
        change = Change('changed', str(self.source), str(self.source))
        return steps(consequences([change], self.known), self.known)

    def touched(self, *places: str) -> set[str]:
        """Return what is restarted as places have the change."""
        path = f'{self.install}/{self.kind.built}'
        changed = {place + path: 'arm' for place in places}
        return set(affected_by_build(changed, self.known))


CASES = [
    pytest.param(
        *(KINDS[name], sync, label, installed),
        id=f'{name}-{sync}-{way}-{"here, too" if installed else "only there"}',
    )
    for name, sync, (way, label), installed in itertools.product(
        KINDS,
        ('build', 'install', 'none'),
        (('--deploy', 'arm│talk'), ('--on', 'talk')),
        (True, False),
    )
]


@pytest.mark.parametrize(('kind', 'sync', 'label', 'installed'), CASES)
def test_only_changes_on_the_machine_restart_its_processes(
    tmp_path: Path, kind: Kind, sync: str, label: str, installed: bool
) -> None:
    launched = Launched(
        tmp_path.resolve(), kind, sync, label, installed=installed
    )
    found = launched.steps
    # nothing is restarted before the machine has the change
    assert found.restart == found.after_build == ()
    is_launch = kind.source == LAUNCH
    assert found.replan == is_launch
    if sync == 'none':
        assert found.kept == (() if is_launch else ('arm (sync: none)',))
    else:
        assert found.build == {'arm'}
        assert found.kept == ()
    # what is built here is not there
    assert launched.touched('') == set()
    # the plan tells what another launch file restarts
    expected = set() if is_launch else {label}
    assert launched.touched('arm│') == expected
    assert launched.touched('gpu│') == set()


def test_file_of_no_package_is_compared_on_the_machine() -> None:
    path = '/home/me/a.yaml'
    files = {'arm│talk': frozenset((path,))}
    known = Dependencies(remote=RemoteDependencies(files=files))
    assert known.files() == (path,)
    change = Change('changed', path, path)
    assert steps(consequences([change], known), known) == Steps(replan=True)
