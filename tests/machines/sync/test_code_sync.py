# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Code is brought to a machine and built there, exactly what is needed."""

from collections.abc import Iterator
from pathlib import Path
import subprocess

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.machines.sync.code_sync import Code
from colcon_yamllaunch.machines.sync.code_sync import sync_code
from colcon_yamllaunch.machines.sync.code_sync import Synced
from colcon_yamllaunch.workspace.packages.package import Package
import pytest
from support.file_clock import let_files_settle
from support.machine_here import MachineHere
from support.user import CMAKE
from support.user import HELLO

pytestmark = pytest.mark.full
QUIET = ['build_there.begin', 'lock_there.release']


class Developer:
    """Somebody with a workspace here and a machine."""

    def __init__(self, folder: Path) -> None:
        self.root = folder / 'here'
        self.machine = MachineHere(folder / 'arm')
        self.packages: list[Package] = []
        self.said: list[str] = []
        self.build_arguments: tuple[str, ...] = ()

    def write(self, path: str, text: str, mode: int = 0o644) -> Path:
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        file.chmod(mode)
        return file

    def package(self, name: str, *needs: str) -> None:
        self.write(f'src/{name}/CMakeLists.txt', CMAKE.format(name=name))
        hello = HELLO.format(name=name)
        self.write(f'src/{name}/scripts/hello.sh', hello, 0o755)
        self.write(f'src/{name}/config/hello.txt', 'hello\n')
        (self.root / f'src/{name}/launch').mkdir()
        path = self.root / 'src' / name
        self.packages.append(Package(name, path, 'cmake', frozenset(needs)))

    def sync(self, *needed: str, mode: str = 'build') -> Synced:
        let_files_settle(self.root)
        self.said.clear()
        self.machine.asked.clear()
        code = Code(
            self.root,
            self.packages,
            self.root / 'build',
            self.root / 'install',
            merge_install=False,
            build_arguments=self.build_arguments,
            settings={},
            environment={},
            title='colcon launch a',
        )
        return sync_code(
            mode,
            'arm',
            str(self.machine.root),
            self.machine,
            code,
            frozenset(needed),
            self.said.append,
        )

    def hello(self, name: str) -> str:
        path = self.machine.root / f'install/{name}/lib/{name}/hello.sh'
        return subprocess.run([path], capture_output=True, text=True).stdout


@pytest.fixture
def developer(tmp_path: Path) -> Iterator[Developer]:
    developer = Developer(tmp_path)
    yield developer
    developer.machine.close()


def test_sources_are_brought_and_built_once(developer: Developer) -> None:
    developer.package('a')
    developer.package('b')
    assert developer.sync('a').built == {'a'}
    assert developer.hello('a') == 'hello from a\n'
    assert 'made the workspace' in developer.said[0]
    assert not (developer.machine.root / 'src/b').exists()
    # the second time nothing goes there, and no rsync is started
    assert developer.sync('a') == Synced()
    assert developer.machine.asked == QUIET


def test_what_is_edited_here_is_brought(developer: Developer) -> None:
    developer.package('a')
    developer.sync('a')
    developer.write('src/a/scripts/hello.sh', '#!/bin/sh\necho new\n', 0o755)
    assert developer.sync('a').transferred == 1
    assert developer.hello('a') == 'new\n'
    assert developer.sync('a') == Synced()


def test_what_is_edited_there_is_not_overwritten(developer: Developer) -> None:
    developer.package('a')
    developer.sync('a')
    edited = developer.machine.write('src/a/config/hello.txt', 'theirs')
    with pytest.raises(UserError, match=r'arm: .*\n  src/a/config/hello.txt'):
        developer.sync('a')
    assert edited.read_text() == 'theirs'
    edited.unlink()
    assert developer.sync('a').transferred == 1
    assert edited.read_text() == 'hello\n'
