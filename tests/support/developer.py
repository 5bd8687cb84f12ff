# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Somebody with a workspace here and a machine that it is brought to."""

from dataclasses import replace
from pathlib import Path
import subprocess

from colcon_yamllaunch.remote.connection.machine_connection import (
    MachineConnection,
)
from colcon_yamllaunch.remote.sync.code_sync import Code
from colcon_yamllaunch.remote.sync.code_sync import sync_code
from colcon_yamllaunch.remote.sync.code_sync import Synced
from colcon_yamllaunch.workspace.packages.package import Package
from support.file_clock import let_files_settle
from support.machine_here import MachineHere
from support.user import CMAKE
from support.user import HELLO

#: What is asked when there is nothing to bring.
QUIET = ['build.begin', 'build.end']


class Developer:
    """Somebody with a workspace here and a machine."""

    def __init__(self, folder: Path) -> None:
        self.root = folder / 'here'
        self.machine = MachineHere(folder / 'arm')
        #: How it is reached.
        self.connection: MachineConnection = self.machine
        self.packages: list[Package] = []
        self.said: list[str] = []
        self.build_arguments: tuple[str, ...] = ()
        self.merge_install = False
        self.environment: dict[str, str] = {}

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
        self.add(name, f'src/{name}', 'cmake', *needs)

    def add(
        self, name: str, place: str, package_type: str, *needs: str
    ) -> None:
        """Have a package whose files are there."""
        path = self.root / place
        self.packages.append(
            Package(name, path, package_type, frozenset(needs))
        )

    def move(self, name: str, place: str) -> None:
        """Have a package elsewhere, where it was moved to."""
        self.packages = [
            replace(package, path=self.root / place)
            if package.name == name
            else package
            for package in self.packages
        ]

    def sync(self, *needed: str, mode: str = 'build') -> Synced:
        let_files_settle(self.root)
        self.said.clear()
        self.machine.asked.clear()
        code = Code(
            self.root,
            self.packages,
            self.root / 'build',
            self.root / 'install',
            merge_install=self.merge_install,
            build_arguments=self.build_arguments,
            settings={},
            environment=self.environment,
            title='colcon launch a',
        )
        return sync_code(
            mode,
            'arm',
            str(self.machine.root),
            self.connection,
            code,
            frozenset(needed),
            self.said.append,
        )

    def hello(self, name: str) -> str:
        path = self.machine.root / f'install/{name}/lib/{name}/hello.sh'
        return subprocess.run([path], capture_output=True, text=True).stdout
