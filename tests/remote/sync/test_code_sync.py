# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Code is brought to a machine and built there, exactly what is needed."""

from dataclasses import replace
import os
from pathlib import Path
import shutil
import threading
import time

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.remote.sync.code_sync import Synced
import pytest
from support.developer import Developer, QUIET
from support.file_clock import let_files_settle
from support.install_space import InstallSpace

pytestmark = pytest.mark.full


def test_sources_are_sent_and_built_once(developer: Developer) -> None:
    developer.package('a')
    developer.package('b')
    assert developer.sync('a').built == {'a'}
    assert developer.hello('a') == 'hello from a\n'
    assert 'made the workspace' in developer.said[0]
    assert not (developer.machine.root / 'src/b').exists()
    # the second time nothing goes there, and no rsync is started
    assert developer.sync('a') == Synced()
    assert developer.machine.asked == QUIET


def test_file_edited_here_is_sent(developer: Developer) -> None:
    developer.package('a')
    developer.sync('a')
    developer.write('src/a/scripts/hello.sh', '#!/bin/sh\necho new\n', 0o755)
    assert developer.sync('a').transferred == 1
    assert developer.hello('a') == 'new\n'
    assert developer.sync('a') == Synced()


def test_file_edited_there_is_not_overwritten(developer: Developer) -> None:
    developer.package('a')
    developer.sync('a')
    edited = developer.machine.write('src/a/config/hello.txt', 'theirs')
    with pytest.raises(UserError, match=r'arm: .*\n  src/a/config/hello.txt'):
        developer.sync('a')
    assert edited.read_text() == 'theirs'
    edited.unlink()
    assert developer.sync('a').transferred == 1
    assert edited.read_text() == 'hello\n'


def test_file_deleted_here_is_deleted_there(developer: Developer) -> None:
    developer.package('a')
    gone = developer.write('src/a/config/deep/gone.txt', 'gone')
    developer.sync('a')
    theirs = developer.machine.write('src/a/config/theirs.txt', 'theirs')
    shutil.rmtree(gone.parent)
    assert developer.sync('a').transferred == 1
    there = developer.machine.root / 'src/a/config'
    assert sorted(os.listdir(there)) == ['hello.txt', 'theirs.txt']
    assert theirs.read_text() == 'theirs'


def test_a_moved_package_leaves_nothing_behind(developer: Developer) -> None:
    developer.package('a')
    developer.package('b')
    developer.sync('a', 'b')
    (developer.root / 'src/group').mkdir()
    shutil.move(developer.root / 'src/a', developer.root / 'src/group/a')
    developer.move('a', 'src/group/a')
    developer.sync('a')
    assert sorted(os.listdir(developer.machine.root / 'src')) == ['b', 'group']


def test_equal_file_from_others_is_kept(developer: Developer) -> None:
    developer.package('a')
    clone = developer.machine.root / 'src/a'
    shutil.copytree(developer.root / 'src/a', clone)
    assert developer.sync('a') == Synced(0, frozenset({'a'}))
    (developer.root / 'src/a/config/hello.txt').unlink()
    developer.sync('a')
    assert (clone / 'config/hello.txt').exists()
    assert 'config/hello.txt is left there' in developer.said[0]


def test_source_written_by_a_build_is_not_in_the_way(
    developer: Developer,
) -> None:
    developer.package('a')
    file = developer.root / 'src/a/CMakeLists.txt'
    file.write_text(
        file.read_text() + 'string(TIMESTAMP now "%s %f")\n'
        'file(WRITE ${CMAKE_SOURCE_DIR}/config/version "${now}")\n'
    )
    developer.write('src/a/config/version', 'from here')
    developer.sync('a')
    there = developer.machine.root / 'src/a/config/version'
    assert there.read_text() != 'from here'
    assert developer.sync('a').transferred == 0
    developer.write('src/a/config/hello.txt', 'new')
    assert developer.sync('a').transferred == 1
    developer.write('src/a/config/version', 'again from here')
    assert developer.sync('a').transferred == 1
    let_files_settle(developer.machine.root)
    time.sleep(1.1)
    there.write_text('by hand')
    with pytest.raises(UserError, match='src/a/config/version'):
        developer.sync('a')


def test_files_in_the_way_are_named(developer: Developer) -> None:
    developer.package('a')
    for number in range(9):
        developer.write(f'src/a/config/{number}', 'here')
        developer.machine.write(f'src/a/config/{number}', 'there')
    with pytest.raises(UserError, match='and 4 more') as told:
        developer.sync('a')
    assert 'sync: none' in str(told.value)
    assert not (developer.machine.root / 'src/a/scripts').exists()


def test_links_and_modes_are_sent(
    developer: Developer, tmp_path: Path
) -> None:
    developer.package('a')
    source = developer.root / 'src/a'
    outside = tmp_path / 'outside'
    outside.mkdir()
    (outside / 'mesh.stl').write_text('mesh')
    (source / 'config/inside').symlink_to('../scripts/hello.sh')
    (source / 'config/meshes').symlink_to(outside)
    (source / 'config/mesh').symlink_to(outside / 'mesh.stl')
    (source / 'config/dangling').symlink_to('/nowhere')
    (source / 'config/loop').symlink_to('..')
    os.mkfifo(source / 'config/pipe')
    developer.sync('a')
    there = developer.machine.root / 'src/a/config'
    assert os.readlink(there / 'inside') == '../scripts/hello.sh'
    assert os.readlink(there / 'dangling') == '/nowhere'
    assert (there / 'mesh').read_text() == 'mesh'
    assert not (there / 'mesh').is_symlink()
    assert not (there / 'meshes').is_symlink()
    assert (there / 'meshes/mesh.stl').read_text() == 'mesh'
    assert os.readlink(there / 'loop') == '..'
    assert not (there / 'pipe').exists()
    hello = there.parent / 'scripts/hello.sh'
    assert os.access(hello, os.X_OK)
    (source / 'scripts/hello.sh').chmod(0o644)
    assert developer.sync('a').transferred == 0
    assert not hello.stat().st_mode & 0o111


def test_link_becomes_a_file_and_a_file_a_folder(
    developer: Developer,
) -> None:
    developer.package('a')
    # what is not installed, as CMake replaces no folder by a file
    config = developer.root / 'src/a/data'
    config.mkdir()
    (config / 'hello.txt').touch()
    (config / 'one').symlink_to('hello.txt')
    (config / 'two').write_text('file')
    (config / 'three').mkdir()
    (config / 'three/inner').write_text('inner')
    developer.sync('a')
    (config / 'one').unlink()
    (config / 'one').write_text('file')
    (config / 'two').unlink()
    (config / 'two').mkdir()
    (config / 'two/inner').write_text('inner')
    shutil.rmtree(config / 'three')
    (config / 'three').symlink_to('hello.txt')
    developer.sync('a')
    there = developer.machine.root / 'src/a/data'
    assert not (there / 'one').is_symlink()
    assert (there / 'one').read_text() == 'file'
    assert (there / 'two/inner').read_text() == 'inner'
    assert os.readlink(there / 'three') == 'hello.txt'
    assert developer.sync('a') == Synced()


@pytest.mark.hostile
def test_odd_names(developer: Developer) -> None:
    developer.package('a')
    config = os.fsencode(developer.root / 'src/a/config')
    names = [
        b'-rf',
        b'--delete',
        b' leading and trailing ',
        b'two\nlines',
        b'no \xff utf-8 \xfe',
        'größe 🤖'.encode(),
        b'$(reboot)',
        b'*?[a]',
        b'quote\'"\\',
        b':colon:',
        b'host:path',
        b'#hash',
        b'%s',
        b'\x1b[31m',
        b'n' * 255,
    ]
    for name in names:
        with open(os.path.join(config, name), 'wb') as file:
            file.write(name)
    developer.sync('a')
    there = os.fsencode(developer.machine.root / 'src/a/config')
    assert sorted(os.listdir(there)) == sorted([*names, b'hello.txt'])
    for name in names:
        with open(os.path.join(there, name), 'rb') as file:
            assert file.read() == name
    assert developer.sync('a') == Synced()
    for name in names:
        os.unlink(os.path.join(config, name))
    assert developer.sync('a').transferred == len(names)
    assert os.listdir(there) == [b'hello.txt']


@pytest.mark.parametrize('where', ['here', 'there'])
def test_missing_rsync_is_an_error_with_the_command_that_installs_it(
    developer: Developer, where: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    developer.package('a')
    if where == 'there':
        developer.machine.forget('rsync')
    else:
        monkeypatch.setenv('PATH', str(developer.root))
    text = f'arm: rsync is not installed {where}.* install rsync'
    with pytest.raises(UserError, match=text):
        developer.sync('a')
    assert not (developer.machine.root / 'src').exists()


def test_three_launches_at_once_build_once(developer: Developer) -> None:
    developer.package('a')
    results: list[Synced] = []
    threads = [
        threading.Thread(target=lambda: results.append(developer.sync('a')))
        for _ in range(3)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(len(result.built) for result in results) == [0, 0, 1]


def test_missing_colcon_is_an_error_with_the_fix(developer: Developer) -> None:
    developer.package('a')
    developer.machine.forget('colcon')
    with pytest.raises(UserError, match='arm: colcon is not installed there'):
        developer.sync('a')


def test_failed_build_is_an_error_and_frees_the_lock(
    developer: Developer,
) -> None:
    developer.package('a')
    file = developer.root / 'src/a/CMakeLists.txt'
    text = file.read_text()
    file.write_text(text + 'message(FATAL_ERROR "no way")')
    with pytest.raises(UserError, match='arm: the build failed there: a fail'):
        developer.sync('a')
    assert 'no way' in '\n'.join(developer.said)
    # each time, and the lock is free again
    for _ in range(2):
        with pytest.raises(UserError, match='the build failed there'):
            developer.sync('a')
        assert developer.machine.asked == ['build.begin']
    file.write_text(text)
    assert developer.sync('a').built == {'a'}


def test_missing_parent_of_the_workspace_is_an_error(
    developer: Developer,
) -> None:
    developer.package('a')
    developer.machine.root /= 'deep'
    with pytest.raises(UserError, match=r'there is no folder .*arm/ws to'):
        developer.sync('a')


def test_package_of_an_underlay_is_not_sent(developer: Developer) -> None:
    developer.package('a')
    assert developer.sync('demo_nodes') == Synced()
    assert developer.machine.asked == []


def test_build_arguments_are_used_there(developer: Developer) -> None:
    developer.package('a')
    developer.build_arguments = ('--cmake-args', '-DMARK=yes')
    developer.merge_install = True
    developer.sync('a')
    cache = developer.machine.root / 'build/a/CMakeCache.txt'
    assert 'MARK:UNINITIALIZED=yes' in cache.read_text()
    assert (developer.machine.root / 'install/lib/a/hello.sh').exists()


def test_settings_of_the_workspace_are_sent(developer: Developer) -> None:
    developer.package('a')
    meta = '{"names": {"a": {"cmake-args": ["-DMARK=meta"]}}}'
    file = developer.write('colcon.meta', meta)
    developer.sync('a')
    cache = developer.machine.root / 'build/a/CMakeCache.txt'
    assert 'MARK:UNINITIALIZED=meta' in cache.read_text()
    developer.write('src/a/config/hello.txt', 'edited')
    assert developer.sync('a').transferred == 1
    assert (developer.machine.root / 'colcon.meta').exists()
    file.unlink()
    developer.write('src/a/config/hello.txt', 'new')
    developer.sync('a')
    assert not (developer.machine.root / 'colcon.meta').exists()


def test_package_that_colcon_there_ignores_is_an_error(
    developer: Developer,
) -> None:
    developer.package('a')
    developer.machine.write('src/COLCON_IGNORE', '')
    with pytest.raises(UserError, match=r'arm: .* does not find a below'):
        developer.sync('a')


def test_build_there_uses_the_underlays_from_here(
    developer: Developer, tmp_path: Path
) -> None:
    developer.package('a')
    underlay = InstallSpace(tmp_path / 'under')
    underlay.package('tool', 'set;TOOL_MARK;yes')
    file = developer.root / 'src/a/CMakeLists.txt'
    file.write_text(file.read_text() + 'message(NOTICE "<$ENV{TOOL_MARK}>")')
    developer.environment['COLCON_PREFIX_PATH'] = str(underlay.path)
    developer.sync('a')
    said = '\n'.join(developer.said)
    assert f'building on top of {underlay.path}' in said
    assert '<yes>' in said
    # as the workspace there says now
    developer.environment.clear()
    assert developer.sync('a') == Synced()
    setup = developer.machine.root / 'install/setup.bash'
    assert str(underlay.path) in setup.read_text()


def test_package_outside_of_the_workspace_is_sent(
    developer: Developer, tmp_path: Path
) -> None:
    developer.package('a')
    shutil.move(developer.root / 'src/a', tmp_path / 'outside')
    developer.packages = [
        replace(package, path=tmp_path / 'outside')
        for package in developer.packages
    ]
    assert developer.sync('a').built == {'a'}
    assert (developer.machine.root / 'src/a/CMakeLists.txt').exists()
    developer.package('a')
    with pytest.raises(UserError, match='several packages are named'):
        developer.sync('a')


def test_shared_workspace_is_built_and_not_sent(developer: Developer) -> None:
    developer.package('a')
    developer.machine.root = developer.root
    assert developer.sync('a') == Synced(0, frozenset({'a'}))
    assert developer.sync('a') == Synced()
    (developer.root / 'src/a/config/hello.txt').unlink()
    developer.sync('a')
    assert developer.hello('a') == 'hello from a\n'


def test_build_that_was_removed_there_is_repeated(
    developer: Developer,
) -> None:
    developer.package('a')
    developer.sync('a')
    shutil.rmtree(developer.machine.root / 'install')
    assert developer.sync('a') == Synced(0, frozenset({'a'}))
    assert developer.machine.asked == QUIET
