# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The environment as hooks describe it; nothing is run for it."""

import os
from pathlib import Path

from colcon_yamllaunch.workspace.environment.hooks import described_environment
import pytest


def write(path: Path, text: str = '') -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding='utf-8')


def package(prefix: Path, name: str, hooks: str, needs: str = '') -> None:
    write(prefix / f'share/colcon-core/packages/{name}', needs)
    write(prefix / f'share/{name}/package.dsv', hooks)


@pytest.mark.parametrize('merged', [False, True])
def test_packages_come_behind_what_they_need(
    tmp_path: Path, merged: bool
) -> None:
    layout = 'merged' if merged else 'isolated'
    write(tmp_path / '.colcon_install_layout', f'{layout}\n')
    write(tmp_path / '_local_setup_util_sh.py')
    for name, needs in (('a', 'c:ros_x'), ('b', 'b'), ('c', '')):
        prefix = tmp_path if merged else tmp_path / name
        hooks = f'prepend-non-duplicate;P;{name}/bin\n'
        package(prefix, name, hooks, needs)
    found = described_environment(tmp_path / 'setup.bash', {'P': '/x'})
    own = [tmp_path if merged else tmp_path / name for name in 'abc']
    # b needs itself, which is a circle
    order = [f'{own[0]}/a/bin', f'{own[2]}/c/bin', f'{own[1]}/b/bin', '/x']
    assert sorted(found.variables['P'].split(':')) == sorted(order)
    values = found.variables['P'].split(':')
    assert values.index(order[0]) < values.index(order[1])
    assert found.variables['COLCON_PREFIX_PATH'] == str(tmp_path)


def test_packages_that_need_one_another_are_there_once(
    tmp_path: Path,
) -> None:
    write(tmp_path / '_local_setup_util_sh.py')
    write(tmp_path / '.colcon_install_layout', 'merged')
    for name, needs in (('a', 'b'), ('b', 'c'), ('c', 'a'), ('d', 'a:e:e')):
        hooks = f'append-non-duplicate;P;/{name}\n'
        package(tmp_path, name, hooks, needs)
    found = described_environment(tmp_path / 'local_setup.bash', {})
    assert found.variables['P'] == '/a:/c:/b:/d'


def test_prefix_of_ament(tmp_path: Path) -> None:
    index = tmp_path / 'share/ament_index/resource_index'
    write(index / 'packages/one')
    write(index / 'packages/two')
    write(index / 'package_run_dependencies/one', 'two;three')
    write(tmp_path / 'share/one/package.dsv', 'source;share/one/hook.sh\n')
    write(tmp_path / 'share/one/hook.dsv', 'set;ROS_DISTRO;x\n')
    write(
        tmp_path / 'share/two/package.dsv',
        'prepend-non-duplicate;AMENT_PREFIX_PATH;\nset;ROS_DISTRO;y\n'
        'set-if-unset;A;1\nset-if-unset;B;1\nappend-non-duplicate;C;/c\n'
        'prepend-non-duplicate-if-exists;D;none\nset;E;share\n',
    )
    found = described_environment(
        tmp_path / 'local_setup.bash', {'A': '0', 'B': '', 'C': '/b'}
    )
    assert found.variables == {
        'AMENT_PREFIX_PATH': str(tmp_path),
        'ROS_DISTRO': 'x',
        'A': '0',
        'B': '1',
        'C': '/b:/c',
        'E': f'{tmp_path}/share',
    }


@pytest.mark.hostile
def test_what_is_damaged_is_left_out(tmp_path: Path) -> None:
    write(tmp_path / '_local_setup_util_sh.py')
    write(tmp_path / '.colcon_install_layout', 'merged')
    package(tmp_path, 'bad', 'nothing\n')
    package(tmp_path, 'good', 'set;GOOD;1\n')
    package(tmp_path, 'pipe', '')
    (tmp_path / 'share/pipe/package.dsv').unlink()
    os.mkfifo(tmp_path / 'share/pipe/package.dsv')
    (tmp_path / 'share/colcon-core/packages/pipe').unlink()
    os.mkfifo(tmp_path / 'share/colcon-core/packages/pipe')
    package(tmp_path, 'tape', '')
    (tmp_path / 'share/tape/package.dsv').unlink()
    (tmp_path / 'share/tape/package.dsv').symlink_to('/dev/zero')
    found = described_environment(tmp_path / 'setup.bash', {})
    assert found.variables['GOOD'] == '1'


def test_script_without_a_description_is_told(tmp_path: Path) -> None:
    underlay = tmp_path / 'underlay'
    for prefix in (underlay, tmp_path / 'install'):
        write(prefix / '_local_setup_util_sh.py')
        write(prefix / '.colcon_install_layout', 'merged')
        package(prefix, 'one', 'source;share/one/hook.sh\n')
        write(prefix / 'local_setup.bash')
    write(
        tmp_path / 'install/setup.bash',
        f'COLCON_CURRENT_PREFIX="{underlay}"\n',
    )
    setup = tmp_path / 'install/setup.bash'
    own = f'{tmp_path}/install/share/one/hook.sh'
    (note,) = described_environment(setup, {}).notes
    assert note.startswith('left out of the environment')
    assert note.endswith(f': {underlay}/share/one/hook.sh, {own}')
    # what the shell has sourced is in the environment already
    shell = {'COLCON_PREFIX_PATH': str(underlay)}
    (note,) = described_environment(setup, shell).notes
    assert note.endswith(f'launch: {own}')


def test_underlay_that_is_gone_is_told(tmp_path: Path) -> None:
    write(
        tmp_path / 'setup.bash',
        f'COLCON_CURRENT_PREFIX="{tmp_path}/none"\n',
    )
    found = described_environment(tmp_path / 'setup.bash', {})
    assert 'which is not there any more' in found.notes[0]
