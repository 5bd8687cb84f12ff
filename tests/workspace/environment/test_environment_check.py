# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What sourcing should have brought in, and what keeps it out."""

import os

from colcon_yamllaunch.workspace.environment.hooks import missing_packages
from colcon_yamllaunch.workspace.environment.sourcing import (
    Environment,
    source,
)
import pytest
from support.install_space import InstallSpace


@pytest.fixture
def sourced(workspace, update):
    """Source a workspace that was broken; get what is missing."""
    workspace.ament_cmake('node')
    assert update('node')[0][0] == 0
    install = workspace.root / 'install'

    def get():
        environment = source(install / 'setup.bash', workspace.environment())
        return missing_packages(environment, ['node'], install, False)

    return get


def test_broken_script_is_noticed_though_bash_returns_0(workspace, sourced):
    assert sourced() == {}
    workspace.write('install/_local_setup_util_sh.py', 'boom = 1 / 0\n')
    text = sourced()['node']
    assert 'did not bring in node' in text
    assert 'ZeroDivisionError' in text
    assert 'launch again' in text


def test_circle_of_installed_packages_is_noticed(workspace, sourced):
    workspace.write('install/node/share/colcon-core/packages/node', 'x')
    workspace.write('install/x/share/colcon-core/packages/x', 'node')
    text = sourced()['node']
    assert 'PREFIX_PATH lacks' in text
    assert 'Circular dependency' in text


def test_package_that_is_not_installed(tmp_path):
    missing = missing_packages(Environment({}), ['a'], tmp_path, False)
    assert 'a: it is not installed in' in missing['a']


def test_merged_install_space(tmp_path):
    share = tmp_path / 'share/a'
    share.mkdir(parents=True)
    (share / 'package.sh').touch()
    (share / 'package.dsv').write_text('source;share/a/x.dsv\n')
    (share / 'x.dsv').write_text(
        'prepend-non-duplicate;PYTHONPATH;lib/py\n'
        'prepend-non-duplicate-if-exists;PATH;bin\n'
        'set;OTHER;1\n'
    )
    variables = {'COLCON_PREFIX_PATH': str(tmp_path)}
    missing = missing_packages(Environment(variables), ['a'], tmp_path, True)
    assert f'PYTHONPATH lacks {tmp_path}/lib/py' in missing['a']
    variables['PYTHONPATH'] = f'/x:{tmp_path}/lib/py'
    environment = Environment(variables)
    assert missing_packages(environment, ['a'], tmp_path, True) == {}


@pytest.fixture(params=['isolated', 'merged'])
def space(tmp_path, request):
    space = InstallSpace(tmp_path / 'install', request.param == 'merged')
    space.package('a')
    space.package('b', needs='a')
    return space


def missing(space, *names):
    environment = source(space.setup, {'PATH': os.defpath})
    return missing_packages(environment, names, space.path, space.merged)


def cure(space, name):
    folder = space.path / ('share' if space.merged else '') / name
    return f'\nRemove {folder}, then launch again to have it built anew'


def test_all_arrive(space):
    assert missing(space, 'a', 'b') == {}


@pytest.mark.parametrize(
    ('content', 'reason'),
    [
        ('', 'it lacks share/a/hook/own.sh'),
        ('source;share/a/hook/own.dsv\n', 'it lacks share/a/hook/own.sh'),
        ('source;share/a/hook/own', "'share/a/hook/own' has no extension"),
        ('sour', 'line 1: there is no semicolon'),
        ('source;share/a/package.dsv\n', 'it names itself'),
    ],
)
def test_truncated_description_of_a_package(space, content, reason):
    space.write(
        'a',
        'share/a/package.sh',
        '_colcon_package_sh_source_script '
        '"$COLCON_CURRENT_PREFIX/share/a/hook/own.sh"\n',
    )
    space.write('a', 'share/a/package.dsv', content)
    text = missing(space, 'a')['a']
    path = space.prefix('a') / 'share/a/package.dsv'
    assert f'{path} is damaged: ' in text
    assert reason in text
    assert text.endswith(cure(space, 'a'))


@pytest.mark.parametrize(
    ('content', 'reason'),
    [
        ('', 'it is empty'),
        ('prepend-non-', 'line 1: there is no semicolon'),
        ('prepend;PATH;bin', "line 1: there is no operation 'prepend'"),
        ('prepend-non-duplicate;PATH', 'line 1: PATH is given no path'),
        ('# x\nset;A', 'line 2: A is given no value'),
    ],
)
def test_truncated_hook(space, content, reason):
    space.write('a', 'share/a/hook/own.dsv', content)
    text = missing(space, 'a')['a']
    assert f'share/a/hook/own.dsv is damaged: {reason}' in text
    assert text.endswith(cure(space, 'a'))


def test_damaged_hook_of_another_package(space):
    space.package('a', 'nonsense')
    text = missing(space, 'b')['b']
    assert 'AMENT_PREFIX_PATH lacks' in text
    assert 'share/a/hook/own.dsv is damaged: line 1' in text
    assert text.endswith(cure(space, 'a').removeprefix('\n'))


@pytest.mark.parametrize(
    ('name', 'content'),
    [
        ('_local_setup_util_sh.py', 'import os\nif'),
        ('local_setup.bash', 'if'),
        ('setup.bash', ''),
    ],
)
def test_broken_setup_script(space, name, content):
    (space.path / name).write_text(content)
    text = missing(space, 'a')['a']
    assert 'PREFIX_PATH lacks' in text
    assert f'\nThe setup scripts in {space.path} may be damaged' in text
    assert 'then launch again to have them written anew' in text


def test_circular_packages_are_reported(space):
    space.package('a', needs='b')
    text = missing(space, 'b')['b']
    assert 'packages a, b depend on each other in a circle' in text
    assert 'Remove a dependency from a package.xml' in text


def test_what_is_known_to_arrive_is_not_looked_for(tmp_path):
    environment = Environment({}, packages=frozenset('a'))
    names = ['a', 'b']
    missing = missing_packages(environment, names, tmp_path, False)
    assert list(missing) == ['b']
