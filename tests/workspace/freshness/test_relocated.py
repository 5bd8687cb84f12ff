# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Workspaces that were moved or copied."""

from pathlib import Path

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.workspace.freshness.build_products import (
    former_place,
    Products,
    remove_builds,
)
from colcon_yamllaunch.workspace.freshness.build_record import (
    Record,
    write_record,
)
from colcon_yamllaunch.workspace.freshness.freshness import Freshness
from colcon_yamllaunch.workspace.packages.package import Package
import pytest

OLD = Path('/old/src/flow')


@pytest.fixture
def package(tmp_path):
    folder = tmp_path / 'src/flow'
    folder.mkdir(parents=True)
    (tmp_path / 'build/flow').mkdir(parents=True)
    return Package('flow', folder, 'cmake')


def write_cache(tmp_path, source, build):
    (tmp_path / 'build/flow/CMakeCache.txt').write_text(
        '# a comment\n'
        f'CMAKE_CACHEFILE_DIR:INTERNAL={build}\n'
        f'CMAKE_HOME_DIRECTORY:INTERNAL={source}\n'
    )


def place(package, build):
    return former_place(package.path, build / 'flow', package.path)


def test_cmake_cache(tmp_path, package):
    build = tmp_path / 'build'
    assert place(package, build) is None
    write_cache(tmp_path, package.path, build / 'flow')
    assert place(package, build) is None
    write_cache(tmp_path, '/old/src/flow', build / 'flow')
    assert place(package, build) == OLD
    write_cache(tmp_path, package.path, '/old/build/flow')
    assert place(package, build) == Path('/old/build/flow')


@pytest.mark.parametrize(('source', 'is_found'), [('', False), ('/old', True)])
def test_link_of_a_python_package(tmp_path, package, source, is_found):
    link = tmp_path / 'build/flow/setup.py'
    link.symlink_to(f'{source or package.path}/setup.py')
    assert (place(package, tmp_path / 'build') is not None) == is_found


@pytest.mark.parametrize(
    ('source', 'is_found'),
    [(None, False), ('src/flow', False), ('/old/src/flow', True)],
)
def test_record_of_another_place_is_found(tmp_path, package, source, is_found):
    file = tmp_path / 'build/flow/colcon_launch.json'
    if source is None:
        file.write_text('{"source": "/old')
    else:
        write_record(file, Record(str(tmp_path / source), {}))
    products = Products(tmp_path / 'build', tmp_path / 'install', False)
    lines = []
    Freshness(products, {}).remove_relocated([package], lines.append)
    assert [str(OLD) in line for line in lines] == [True] * is_found
    assert file.exists() != is_found


def test_package_path_through_a_link_is_the_same(tmp_path, package):
    (tmp_path / 'link').symlink_to(tmp_path / 'src')
    linked = Package('flow', tmp_path / 'link/flow', 'cmake')
    write_cache(tmp_path, package.path, tmp_path / 'build/flow')
    assert place(linked, tmp_path / 'build') is None


def test_removal_follows_no_link(tmp_path, package):
    precious = tmp_path / 'precious'
    precious.mkdir()
    (precious / 'file').touch()
    build, install = tmp_path / 'build', tmp_path / 'install'
    (build / 'flow/link').symlink_to(precious)
    (build / 'other').mkdir()
    install.mkdir()
    (install / 'flow').symlink_to(precious)
    products = Products(build, install, merge_install=False)
    remove_builds({'flow': OLD, 'unknown': OLD}, products)
    assert sorted(p.name for p in build.iterdir()) == ['other']
    assert list(install.iterdir()) == []
    assert (precious / 'file').exists()


def test_merged_install_space_loses_old_links_only(tmp_path, package):
    share = tmp_path / 'install/share/flow'
    share.mkdir(parents=True)
    kept = share / 'kept.yaml'
    kept.symlink_to(package.path / 'kept.yaml')
    for name in ('src/flow/x.yaml', 'build/flow/y.sh'):
        (share / Path(name).name).symlink_to(Path('/old') / name)
    products = Products(tmp_path / 'build', tmp_path / 'install', True)
    remove_builds({'flow': OLD}, products)
    assert list(share.iterdir()) == [kept]
    assert not (tmp_path / 'build/flow').exists()


@pytest.mark.parametrize('name', ['..', '.', '', '../src', '/etc'])
def test_nothing_outside_is_removed(tmp_path, package, name):
    products = Products(tmp_path / 'build', tmp_path / 'install', False)
    with pytest.raises(WorkspaceError):
        remove_builds({name: OLD}, products)
    assert package.path.exists()
