# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is installed here is brought to a machine, or only looked for there."""

import os
import shutil
import subprocess

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.remote.sync import inspection
from colcon_yamllaunch.remote.sync.code_sync import Synced
from colcon_yamllaunch.remote.sync.inspection import check_system, system
import pytest
from support.developer import Developer
from support.manifest import manifest

pytestmark = pytest.mark.full

_SETUP = """\
from setuptools import setup
setup(
    name='p',
    version='0.1.0',
    packages=['p'],
    py_modules=['single'],
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/p']),
        ('share/p', ['package.xml']),
        ('share/p/launch', ['launch/p.yaml']),
    ],
    entry_points={'console_scripts': ['hi = p.main:main']},
)
"""
_CONFIGURATION = """\
[develop]
script_dir=$base/lib/p
[install]
install_scripts=$base/lib/p
"""


def build(developer: Developer, *words: str) -> None:
    command = ['colcon', 'build', '--symlink-install', *words]
    environment = os.environ | {
        'PATH': developer.machine.environment['PATH'],
        # as launches build
        'CMAKE_INSTALL_MODE': 'ABS_SYMLINK_OR_COPY',
    }
    subprocess.run(
        command,
        cwd=developer.root,
        env=environment,
        check=True,
        capture_output=True,
    )


def run_there(developer: Developer, command: str) -> str:
    setup = developer.machine.root / 'install/setup.bash'
    return subprocess.run(
        ['bash', '-c', f'. {setup}\n{command}'],
        env=developer.machine.environment,
        capture_output=True,
        text=True,
    ).stdout


@pytest.mark.parametrize('merged', [False, True])
def test_installed_files_are_sent_with_links_resolved(
    developer: Developer, merged: bool
) -> None:
    developer.package('a')
    developer.merge_install = merged
    build(developer, *(['--merge-install'] if merged else []))
    synced = developer.sync('a', mode='install')
    assert synced.transferred > 5
    # nothing there leads to the workspace here
    shutil.move(developer.root, developer.root.with_name('away'))
    found = subprocess.run(
        ['grep', '-rIl', f'{developer.root}/', developer.machine.root],
        capture_output=True,
        text=True,
    ).stdout.split()
    record = developer.machine.root / '.colcon_launch.synced.json'
    assert found in ([], [str(record)])
    links = [
        path for path in developer.machine.root.rglob('*') if path.is_symlink()
    ]
    assert links == []
    prefix = '$COLCON_PREFIX_PATH' if merged else '$COLCON_PREFIX_PATH/a'
    printed = run_there(developer, f'{prefix}/lib/a/hello.sh')
    assert printed == 'hello from a\n'


def test_second_sync_sends_nothing(developer: Developer) -> None:
    developer.package('a')
    build(developer)
    developer.sync('a', mode='install')
    assert developer.sync('a', mode='install') == Synced()
    assert developer.machine.asked == [
        'build.begin',
        'build.end',
    ]
    developer.write('src/a/config/hello.txt', 'new')
    assert developer.sync('a', mode='install').transferred == 1
    there = developer.machine.root / 'install/a/share/a/config/hello.txt'
    assert there.read_text() == 'new'


def test_python_package_in_its_build_folder_is_sent(
    developer: Developer,
) -> None:
    developer.write('src/p/setup.py', _SETUP)
    developer.write('src/p/setup.cfg', _CONFIGURATION)
    developer.write('src/p/package.xml', manifest('p', 'ament_python'))
    developer.write('src/p/resource/p', '')
    developer.write('src/p/launch/p.yaml', 'launch:\n')
    developer.write('src/p/single.py', 'TEXT = "hi"\n')
    developer.write('src/p/p/__init__.py', '')
    developer.write(
        'src/p/p/main.py',
        'import single\ndef main():\n    print(single.TEXT)\n',
    )
    developer.add('p', 'src/p', 'ros.ament_python')
    build(developer)
    developer.sync('p', mode='install')
    shutil.move(developer.root, developer.root.with_name('away'))
    printed = run_there(
        developer, f'{developer.machine.root}/install/p/lib/p/hi 2>&1'
    )
    assert printed == 'hi\n'


def test_package_not_built_here_is_an_error(developer: Developer) -> None:
    developer.package('a')
    with pytest.raises(UserError, match=r'arm: not built here, .*: a$'):
        developer.sync('a', mode='install')


@pytest.mark.parametrize(
    ('key', 'value', 'told'),
    [
        ('architecture', 'aarch64', 'it is aarch64'),
        ('system', 'beos 5', 'it runs beos 5'),
        ('glibc', '2.1', 'its C library is glibc 2.1'),
        ('python', '3.4', 'its python3 is 3.4'),
    ],
)
def test_a_machine_of_another_kind_is_refused(
    key: str, value: str, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    here = system()
    pythons = [here['python']]
    check_system(here, pythons, [])
    monkeypatch.setattr(inspection, 'system', lambda: here | {key: value})
    with pytest.raises(UserError, match=told) as error:
        check_system(here, pythons, [])
    assert '`sync: build`' in str(error.value)


def test_missing_and_other_packages_there_are_reported(
    developer: Developer,
) -> None:
    developer.package('a')
    text = manifest('a', 'cmake')
    developer.write('src/a/package.xml', text)
    with pytest.raises(UserError, match='arm: not installed there: a; looked'):
        developer.sync('a', mode='none')
    installed = developer.machine.write('install/a/share/a/package.xml', text)
    assert developer.sync('a', mode='none') == Synced()
    assert developer.said == []
    installed.write_text(text.replace('0.1.0', '0.2.0'))
    developer.sync('a', mode='none')
    assert developer.said == [
        'warning: a has version 0.2.0 there, and 0.1.0 here'
    ]
    installed.write_text(text.replace('A package', 'Another package'))
    developer.sync('a', mode='none')
    assert 'another package.xml' in developer.said[0]


def test_package_of_an_underlay_is_found(developer: Developer) -> None:
    developer.package('a')
    with pytest.raises(UserError, match='demo_nodes; looked in no folder'):
        developer.sync('demo_nodes', mode='none')
    underlay = developer.machine.home / 'ros'
    marker = underlay / 'share/demo_nodes/package.xml'
    marker.parent.mkdir(parents=True)
    marker.write_text('<package/>')
    developer.machine.environment['AMENT_PREFIX_PATH'] = str(underlay)
    assert developer.sync('demo_nodes', mode='none') == Synced()
