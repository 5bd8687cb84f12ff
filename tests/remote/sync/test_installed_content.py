# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The code that a machine reports, for `--watch`."""

import os
from pathlib import Path
from typing import Any

from colcon_yamllaunch.common.fingerprint import Fingerprint
from colcon_yamllaunch.remote.sync.inspection import read_contents
from colcon_yamllaunch.workspace.freshness.build_record import (
    Record,
    RECORD_NAME,
    write_record,
)
import pytest


class Machine:
    """A machine whose workspace is in a folder."""

    def __init__(self, root: Path) -> None:
        self.root = root

    def file(self, path: str, text: str) -> Path:
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        # so that only the content tells
        os.utime(file, (1, 1))
        return file

    def link(self, path: str, target: str) -> None:
        link = self.root / path
        link.parent.mkdir(parents=True, exist_ok=True)
        link.symlink_to(os.path.relpath(self.root / target, link.parent))

    def has_built(self, **links: str) -> None:
        """Record links as what the last build has made."""
        made = {
            kind: {path: Fingerprint(1, 1, False, 'link to somewhere')}
            for kind, path in links.items()
        }
        record = Record('/', {}, **made)  # type: ignore[arg-type]
        write_record(self.root / 'build/arm' / RECORD_NAME, record)

    def tells(self, *, merged: bool = False) -> dict[str, Any]:
        return read_contents(
            {
                'build_base': str(self.root / 'build'),
                'install_base': str(self.root / 'install'),
                'merge_install': merged,
                'packages': ['arm'],
                'files': [str(self.root / 'a.yaml'), '/nowhere', '/'],
            },
            print,
        )


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    machine = Machine(tmp_path)
    machine.file('a.yaml', '1')
    return machine


def test_edit_behind_a_link_changes_the_content(machine: Machine) -> None:
    machine.file('src/arm/arm/word.py', '1')
    machine.file('src/arm/talk.py', '1')
    machine.link('install/arm/lib/arm/talk.py', 'src/arm/talk.py')
    machine.link('build/arm/arm', 'src/arm/arm')
    machine.has_built(installed='arm/lib/arm/talk.py', products='arm')
    first = machine.tells()['packages']['arm']
    assert machine.tells()['packages']['arm'] == first
    machine.file('src/arm/arm/word.py', '2')
    second = machine.tells()['packages']['arm']
    # a package in Python is imported from a folder that is linked
    path = 'arm/word.py'
    assert second['products'][path] != first['products'][path]
    assert second['installed'] == first['installed']
    machine.file('src/arm/talk.py', '2')
    path = 'arm/lib/arm/talk.py'
    third = machine.tells()['packages']['arm']
    assert third['installed'][path] != first['installed'][path]


@pytest.mark.parametrize(
    ('merged', 'package', 'path'),
    [
        (False, 'arm', 'arm/lib/libword.so'),
        # it may be of any package
        (True, '*', 'lib/libword.so'),
    ],
)
def test_package_without_record_has_its_content(
    machine: Machine, merged: bool, package: str, path: str
) -> None:
    machine.file(f'install/{path}', '1')
    first = machine.tells(merged=merged)['packages']
    machine.file(f'install/{path}', '2')
    second = machine.tells(merged=merged)['packages']
    assert first.keys() == second.keys() == {package}
    told = [one[package]['installed'] for one in (first, second)]
    assert told[0].keys() == {path}
    assert told[0][path] != told[1][path]


def test_edited_file_changes_its_content(machine: Machine) -> None:
    first = machine.tells()['files']
    file = machine.file('a.yaml', '2')
    second = machine.tells()['files']
    assert first[str(file)] != second[str(file)]
    file.chmod(0o755)
    assert machine.tells()['files'][str(file)] != second[str(file)]
    assert first['/nowhere'] == first['/'] == ''


def test_files_without_packages_need_no_workspace(machine: Machine) -> None:
    path = str(machine.root / 'a.yaml')
    answer = read_contents({'packages': [], 'files': [path]}, print)
    assert answer['packages'] == {}
    assert answer['files'][path]
