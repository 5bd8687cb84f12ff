# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The index finds what colcon finds, now and after every change."""

import importlib.util
import os
import shutil
import textwrap

import pytest
from support.file_clock import let_files_settle
from support.manifest import manifest

SHOW = """\
import logging
logging.getLogger('colcon').setLevel(logging.CRITICAL)
from colcon_yamllaunch.workspace.colcon.colcon_cache import CachedColcon

def settings(name):
    if isinstance(colcon, CachedColcon):
        return colcon.settings(name)
    return colcon.arguments.settings | dict(metadata=colcon.metadata(name))

colcon = {kind}(Path({root!r}), {arguments!r})
listed = [
    [p.name, str(p.path), p.type, sorted(p.build_depends),
     sorted(p.run_depends), settings(p.name)]
    for p in colcon.packages()
]
show([listed, getattr(colcon, '_colcon', None) is not None])
"""
CMAKE = 'cmake_minimum_required(VERSION 3.16)\nproject({} NONE)\n{}'
SETUP = 'from setuptools import setup\nsetup(name={!r}, version="1")\n'
BARE = 'from setuptools import setup\nsetup()'
CFG = """\
[metadata]
name = {}
version = 1
[options]
install_requires =
    ros_a
    {}
"""
FORMAT_1 = """\
<package>
  <name>old</name><version>1.0.0</version><description>d</description>
  <maintainer email="a@example.com">A</maintainer><license>MIT</license>
  <buildtool_depend>catkin</buildtool_depend>
  <build_depend>ros_a</build_depend><run_depend>ros_b</run_depend>
</package>
"""
FORMAT_2 = """\
<package format="2">
  <name>middle</name><version>1.0.0</version><description>d</description>
  <maintainer email="a@example.com">A</maintainer><license>MIT</license>
  <depend>ros_a</depend><test_depend>ros_b</test_depend>
  <export><build_type>cmake</build_type></export>
</package>
"""
CONDITIONS = """\
<depend condition="$FLAVOUR == sweet">ros_a</depend>
<exec_depend condition="$FLAVOUR != sweet">ros_b</exec_depend>
"""


def named(workspace, path, build_type='ament_cmake'):
    """Write a manifest for a package named like its folder."""
    text = manifest(path.rpartition('/')[2], build_type)
    workspace.write(f'src/{path}/package.xml', text)


def write_packages_with_manifests(workspace):
    workspace.manifest('ros_a')
    workspace.manifest('ros_b', 'ament_python')
    workspace.write('src/ros_b/setup.py', SETUP.format('ros_b'))
    workspace.manifest('conditional', depends=CONDITIONS)
    workspace.write('src/old/package.xml', FORMAT_1)
    workspace.write('src/middle/package.xml', FORMAT_2)
    workspace.manifest(
        'member', depends='<member_of_group>interfaces</member_of_group>'
    )
    workspace.manifest(
        'bridge', depends='<group_depend>interfaces</group_depend>'
    )
    bad = manifest('bad', 'ament_cmake', mail='nobody')
    workspace.write('src/bad/package.xml', bad)
    workspace.write('src/worse/package.xml', '<package>')
    workspace.write('src/worse/CMakeLists.txt', CMAKE.format('worse', ''))
    text = manifest('twice', 'ament_cmake').replace(
        '</export>', '<build_type>cmake</build_type></export>'
    )
    workspace.write('src/twice/package.xml', text)
    text = manifest('latin', 'ament_cmake').replace('A package', 'Größe')
    path = workspace.write('src/latin/package.xml')
    path.write_bytes(text.encode('latin-1'))
    # the same name at two places
    for place in ('one', 'two'):
        text = manifest('clash', 'ament_cmake')
        workspace.write(f'src/clash/{place}/package.xml', text)
    # a package in a package is none
    workspace.write('src/ros_a/inner/package.xml', manifest('inner', 'cmake'))


def write_other_packages(workspace):
    find = 'find_package(ros_a)\n# find_package(ros_b)\n'
    workspace.write('src/plain/CMakeLists.txt', CMAKE.format('plain', find))
    workspace.write(
        'src/plain/cmake/more.cmake',
        'pkg_check_modules(X REQUIRED ros_b>=1 other)\n',
    )
    workspace.write('src/plain/.hidden/x.cmake', 'find_package(hidden)')
    workspace.write('src/unnamed/CMakeLists.txt', 'add_library(x)\n')
    path = workspace.write('src/bytes/CMakeLists.txt')
    path.write_bytes(b'# \xff\xfe\nproject(bytes NONE)\n')
    workspace.write('src/both/CMakeLists.txt', CMAKE.format('both', ''))
    workspace.write('src/both/setup.py', BARE)
    workspace.write('src/both/setup.cfg', CFG.format('both', ''))
    workspace.write('src/py/setup.py', SETUP.format('py'))
    workspace.write('src/cfg/setup.py', BARE)
    workspace.write('src/cfg/setup.cfg', CFG.format('cfg', ''))
    workspace.write('src/cfg_only/setup.cfg', CFG.format('cfg_only', ''))
    workspace.write('src/toml/pyproject.toml', '[project]\nname = "toml"\n')
    workspace.write('src/broken/setup.py', 'raise SystemExit(3)\n')
    workspace.write('src/dry/manifest.xml', '<package/>')
    workspace.write('src/dry/CMakeLists.txt', CMAKE.format('dry', ''))
    workspace.write('src/meta/colcon.pkg', 'name: meta\ntype: cmake\n')
    workspace.write(
        'src/toplevel/CMakeLists.txt', 'project(Project)\ncatkin_workspace()\n'
    )


def write_ignored_folders(workspace):
    for marker in ('COLCON_IGNORE', 'AMENT_IGNORE', 'CATKIN_IGNORE'):
        name = marker.lower()
        workspace.manifest(name)
        workspace.write(f'src/{name}/{marker}')
        # without a manifest there is nothing that the last two ignore
        workspace.write(f'src/group_{name}/{marker}')
        named(workspace, f'group_{name}/below_{name}')
    named(workspace, 'nested/build/a')
    workspace.write('src/nested/build/COLCON_IGNORE')
    named(workspace, 'nested/install/b')
    named(workspace, '.hidden/c')
    named(workspace, 'catkin_install/d')
    workspace.write('src/catkin_install/_setup_util.py')
    workspace.manifest('dangling')
    (workspace.root / 'src/dangling/COLCON_IGNORE').symlink_to('nowhere')
    (workspace.root / 'src/nested/AMENT_IGNORE').symlink_to('nowhere')


def write_links(workspace):
    elsewhere = workspace.root.parent / 'elsewhere'
    shutil.copytree(workspace.root / 'src/ros_a', elsewhere / 'linked')
    text = manifest('linked', 'ament_cmake')
    (elsewhere / 'linked/package.xml').write_text(text)
    source = workspace.root / 'src'
    (source / 'to_folder').symlink_to(elsewhere)
    (source / 'a_second_name').symlink_to(source / 'ros_a')
    (source / 'cycle').symlink_to(source)
    (source / 'no_target').symlink_to('nowhere')


@pytest.fixture
def odd(workspace):
    write_packages_with_manifests(workspace)
    write_other_packages(workspace)
    write_ignored_folders(workspace)
    write_links(workspace)
    workspace.write('build/COLCON_IGNORE')
    let_files_settle(workspace.root.parent)
    return workspace


@pytest.fixture
def show(workspace):
    """Find packages; get what was found, and the output."""

    def run(kind, arguments=(), variables=None):
        text = SHOW.format(
            kind=kind, root=str(workspace.root), arguments=arguments
        )
        environment = workspace.environment(**(variables or {}))
        (result,), output = workspace.run(text, environment=environment)
        return result, output

    return run


@pytest.fixture
def cached(show):
    """Get the packages without comparing, and whether colcon was asked."""

    def run():
        (found, asked), _ = show('CachedColcon')
        return {package[0]: package for package in found}, asked

    return run


@pytest.fixture
def compare(show):
    """Compare both; get the packages, and whether colcon was asked."""

    def run(arguments=(), **variables):
        (found, asked), output = show('CachedColcon', arguments, variables)
        # colcon's extensions keep what they read for the whole process
        (expected, _), _ = show('Colcon', arguments, variables)
        assert found == expected, output
        return {package[0]: package for package in found}, asked

    return run


def test_odd_packages(odd, compare):
    first, asked = compare()
    assert asked
    assert {'ros_a', 'plain', 'py', 'cfg', 'linked', 'bytes'} <= set(first)
    assert {'bad', 'inner', 'toml', 'hidden', 'both'}.isdisjoint(first)
    # some of them make colcon complain each time; it is asked each time
    again, asked = compare()
    assert again == first
    assert asked
    sweet, _ = compare(FLAVOUR='sweet')
    assert sweet['conditional'][3] == ['ros_a']


@pytest.fixture
def plain(workspace, compare, cached):
    """A workspace that nothing is wrong with, which is known."""
    workspace.manifest('ros_a')
    workspace.manifest('conditional', depends=CONDITIONS)
    find = 'find_package(ros_a)\n'
    workspace.write('src/plain/CMakeLists.txt', CMAKE.format('plain', find))
    workspace.write('src/plain/src/main.c')
    # its setup.py is not run, which takes longer than all else
    workspace.write('src/py/setup.py', BARE)
    workspace.write('src/py/setup.cfg', CFG.format('py', ''))
    named(workspace, 'group/ignored')
    workspace.write('src/group/ignored/AMENT_IGNORE')
    workspace.write('src/group/notes/readme.txt')
    workspace.write('build/COLCON_IGNORE')
    let_files_settle(workspace.root.parent)
    first, asked = compare()
    assert asked
    workspace.known, asked = cached()
    assert not asked
    assert workspace.known == first
    return workspace


def other_setup_to_run(workspace):
    (workspace.root / 'src/py/setup.cfg').unlink()
    workspace.write('src/py/setup.py', SETUP.format('pi'))


def same_size_and_time(workspace):
    path = workspace.root / 'src/ros_a/package.xml'
    status = path.stat()
    path.write_text(path.read_text().replace('ros_a', 'ros_b'))
    os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))


def link_to_a_package(workspace):
    elsewhere = workspace.root.parent / 'elsewhere'
    elsewhere.mkdir()
    text = manifest('linked', 'ament_cmake')
    (elsewhere / 'package.xml').write_text(text)
    (workspace.root / 'src/link').symlink_to(elsewhere)


def new_member_of_a_group(workspace):
    depends = '<group_depend>interfaces</group_depend>'
    workspace.manifest('bridge', depends=depends)
    depends = '<member_of_group>interfaces</member_of_group>'
    workspace.manifest('ros_a', depends=depends)


CHANGES = {
    'new_package': lambda w: named(w, 'group/notes/new'),
    'deleted_package': lambda w: shutil.rmtree(w.root / 'src/ros_a'),
    'renamed_folder': lambda w: (w.root / 'src/ros_a').rename(
        w.root / 'src/other'
    ),
    'other_dependencies': lambda w: w.manifest(
        'ros_a', depends='<depend>plain</depend>'
    ),
    'other_name': lambda w: w.write(
        'src/plain/CMakeLists.txt', CMAKE.format('renamed', '')
    ),
    'new_cmake_file': lambda w: w.write(
        'src/plain/src/more.cmake', 'find_package(py)'
    ),
    'other_setup': lambda w: w.write('src/py/setup.cfg', CFG.format('pi', '')),
    'other_setup_to_run': other_setup_to_run,
    'ignored_now': lambda w: w.write('src/ros_a/COLCON_IGNORE'),
    'no_longer_ignored': lambda w: (
        w.root / 'src/group/ignored/AMENT_IGNORE'
    ).unlink(),
    'package_around_others': lambda w: w.write(
        'src/package.xml', manifest('around', 'ament_cmake')
    ),
    'manifest_for_cmake': lambda w: w.manifest('plain'),
    'invalid_manifest': lambda w: w.write(
        'src/ros_a/package.xml', '<package/>'
    ),
    'same_size_and_time': same_size_and_time,
    'link_to_a_package': link_to_a_package,
    'new_member_of_a_group': new_member_of_a_group,
    'workspace_defaults': lambda w: w.write(
        'colcon_defaults.yaml',
        'build: {merge-install: true, cmake-args: [-DA=1]}\n',
    ),
    'other_base_paths': lambda w: w.write(
        'colcon_defaults.yaml', 'build: {base-paths: [src/group, src/py]}\n'
    ),
    'patterns_as_base_paths': lambda w: w.write(
        'colcon_defaults.yaml', 'build: {base-paths: [src/p*]}\n'
    ),
    'ignored_by_name': lambda w: w.write(
        'colcon_defaults.yaml', 'build: {packages-ignore: [ros_a]}\n'
    ),
}


def test_paths_in_the_defaults(plain, compare):
    # a default does not count as given, but who knows
    workspace_defaults = 'build: {paths: [src/py]}\n'
    plain.write('colcon_defaults.yaml', workspace_defaults)
    assert compare()[1]


@pytest.mark.parametrize('change', CHANGES.values(), ids=CHANGES)
def test_change_is_noticed(plain, compare, cached, change):
    change(plain)
    after, _ = compare()
    assert after != plain.known
    # and is not forgotten
    assert cached()[0] == after


def test_setup_is_run_again_for_another_one(workspace, compare, cached):
    workspace.write('src/py/setup.py', SETUP.format('py'))
    workspace.write('build/COLCON_IGNORE')
    let_files_settle(workspace.root.parent)
    assert list(compare()[0]) == ['py']
    assert not cached()[1]
    workspace.write('src/py/setup.py', SETUP.format('pi'))
    assert list(compare()[0]) == ['pi']
    assert list(cached()[0]) == ['pi']


def test_whole_source_is_ignored(plain, compare):
    plain.write('src/COLCON_IGNORE')
    assert compare()[0] == {}


def test_conditions_follow_the_environment(plain, compare):
    packages, asked = compare(FLAVOUR='sweet')
    assert asked
    assert packages['conditional'][3] == ['ros_a']
    packages, _ = compare(FLAVOUR='sour')
    assert packages['conditional'][4] == ['ros_b']


def test_edits_of_other_files_need_no_colcon(plain, compare):
    plain.write('src/plain/src/more.c')
    plain.write('src/ros_a/README.md')
    plain.write('src/group/notes/below/more.txt')
    plain.write('build/ros_a/made.txt')
    assert not compare()[1]


def test_own_arguments(plain, compare):
    packages, asked = compare(arguments=('--cmake-args', '-DA=1'))
    assert asked
    assert '-DA=1' in packages['plain'][5]['cmake_args']
    packages, asked = compare()
    assert asked
    assert '-DA=1' not in packages['plain'][5]['cmake_args']


def test_user_defaults(plain, compare):
    home = plain.root.parent / 'colcon_home'
    home.mkdir()
    text = 'build: {cmake-args: [-DA=1]}\n'
    (home / 'defaults.yaml').write_text(text)
    packages, asked = compare()
    assert asked
    assert '-DA=1' in packages['plain'][5]['cmake_args']
    # as good as edited just now
    (home / 'defaults.yaml').write_text(text.replace('1', '2'))
    packages, _ = compare()
    assert '-DA=2' in packages['plain'][5]['cmake_args']
    other = plain.write('other.yaml', text.replace('1', '3'))
    packages, _ = compare(COLCON_DEFAULTS_FILE=str(other))
    assert '-DA=3' in packages['plain'][5]['cmake_args']


def test_blocked_extension(plain, compare):
    name = 'colcon_core.package_identification.ros'
    packages, asked = compare(COLCON_EXTENSION_BLOCKLIST=name)
    assert asked
    assert 'ros_a' not in packages


@pytest.mark.skipif(
    importlib.util.find_spec('colcon_metadata') is None,
    reason='needs colcon-metadata',
)
def test_metadata_files(plain, compare):
    plain.write('src/group/notes/colcon.pkg', 'name: noted\ntype: cmake\n')
    assert 'noted' in compare()[0]
    text = """\
    paths:
      src/group:
        name: grouped
        type: cmake
    names:
      plain:
        cmake-args: [-DB=1]
        dependencies: [py]
    """
    plain.write('colcon.meta', textwrap.dedent(text))
    packages, _ = compare()
    assert 'grouped' in packages
    assert '-DB=1' in packages['plain'][5]['metadata']
    plain.write('colcon.meta', textwrap.dedent(text).replace('B=1', 'B=2'))
    packages, _ = compare()
    assert '-DB=2' in packages['plain'][5]['metadata']


@pytest.mark.skipif(
    importlib.util.find_spec('colcon_mixin') is None,
    reason='needs colcon-mixin',
)
def test_index_depends_on_mixins(plain, compare):
    folder = plain.root.parent / 'colcon_home/mixin/own'
    folder.mkdir(parents=True)
    mixin = folder / 'a.mixin'
    mixin.write_text('{build: {a: {cmake-args: [-DM=1]}}}\n')
    arguments = ('--mixin', 'a')
    packages, _ = compare(arguments=arguments)
    assert '-DM=1' in packages['plain'][5]['cmake_args']
    mixin.write_text('{build: {a: {cmake-args: [-DM=2]}}}\n')
    packages, _ = compare(arguments=arguments)
    assert '-DM=2' in packages['plain'][5]['cmake_args']


def test_a_virtual_environment_has_no_packages(plain, cached):
    site = 'venv/lib/python3/site-packages'
    plain.write(f'{site}/numpy/setup.py', SETUP.format('numpy'))
    plain.write(f'{site}/share/ros_a/package.xml', manifest('ros_a', 'cmake'))
    plain.write('venv/pyvenv.cfg', 'home = /usr/bin')
    let_files_settle(plain.root)
    found, asked = cached()
    assert (found, asked) == (plain.known, True)
    assert cached() == (plain.known, False)
