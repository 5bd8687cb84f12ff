# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The underlays that a workspace is built on top of."""

from colcon_yamllaunch.workspace.environment.sourcing import (
    build_environment,
    chained_underlays,
    Environment,
    sourced_underlays,
)
import pytest


@pytest.fixture
def install(tmp_path):
    """An install folder that chains two underlays."""
    for name in ('ros', 'robot'):
        (tmp_path / name).mkdir()
        (tmp_path / name / 'local_setup.bash').touch()
    path = tmp_path / 'ws/install'
    path.mkdir(parents=True)
    (path / 'setup.bash').write_text(
        f'# source chained prefixes\n'
        f'COLCON_CURRENT_PREFIX="{tmp_path}/ros"\n'
        '_x "$COLCON_CURRENT_PREFIX/local_setup.bash"\n'
        f'COLCON_CURRENT_PREFIX="{tmp_path}/robot"\n'
        '_x "$COLCON_CURRENT_PREFIX/local_setup.bash"\n'
        'COLCON_CURRENT_PREFIX="$(builtin cd "`dirname "x"`" && pwd)"\n'
    )
    return path


def sourcing(script, environment):
    done = environment.get('DONE', '')
    return Environment({**environment, 'DONE': f'{done} {script}'})


def test_chained_underlays(tmp_path, install):
    expected = [tmp_path / 'ros', tmp_path / 'robot']
    assert chained_underlays(install) == expected
    (install / 'setup.bash').rename(install / 'setup.sh')
    assert chained_underlays(install) == expected
    assert chained_underlays(tmp_path / 'none') == []


def test_shell_without_underlay_gets_the_chained_ones(tmp_path, install):
    own = {
        'COLCON_PREFIX_PATH': str(install),
        'AMENT_PREFIX_PATH': str(install / 'a'),
    }
    (install / '.colcon_install_layout').write_text('isolated\n')
    for environment in ({}, own):
        result = build_environment(environment, install, sourcing)
        assert result.variables['DONE'] == (
            f' {tmp_path}/ros/local_setup.bash'
            f' {tmp_path}/robot/local_setup.bash'
        )
        assert 'nothing is sourced' in result.notes[0]


def test_underlay_that_is_gone(tmp_path, install):
    (tmp_path / 'ros/local_setup.bash').unlink()
    result = build_environment({}, install, sourcing)
    assert result.variables['DONE'] == f' {tmp_path}/robot/local_setup.bash'
    assert f'{tmp_path}/ros, which is not there' in result.notes[0]


def test_shell_with_the_same_underlays_is_left_alone(tmp_path, install):
    variables = {'COLCON_PREFIX_PATH': f'{tmp_path}/robot:{tmp_path}/ros'}
    result = build_environment(variables, install, sourcing)
    assert result.variables == variables
    assert result.notes == ()


def test_shell_with_another_underlay_is_followed(tmp_path, install):
    variables = {'AMENT_PREFIX_PATH': f'{tmp_path}/ros'}
    result = build_environment(variables, install, sourcing)
    assert result.variables == variables
    assert f'{tmp_path}/robot, which is not sourced' in result.notes[0]


def test_workspace_without_underlay(tmp_path):
    result = build_environment({'A': '1'}, tmp_path, sourcing)
    assert (result.variables, result.notes) == ({'A': '1'}, ())


def test_only_what_colcon_would_chain_is_an_underlay(tmp_path):
    isolated = tmp_path / 'isolated'
    (isolated / 'a').mkdir(parents=True)
    (isolated / '.colcon_install_layout').write_text('isolated\n')
    # such as a virtual environment with ROS packages
    bare = tmp_path / 'bare'
    bare.mkdir()
    variables = {'AMENT_PREFIX_PATH': f'{isolated}/a:{bare}:/nowhere'}
    assert sourced_underlays(variables, tmp_path / 'ws') == [isolated]


def test_underlay_survives_a_build_from_a_bare_shell(workspace, update, forks):
    workspace.cmake('below')
    assert update('below')[0][0] == 0
    underlay = workspace.root / 'install'
    overlay = type(workspace)(workspace.root.parent / 'over', forks)
    overlay.root.mkdir()
    overlay.cmake('above')
    code = (
        'from colcon_yamllaunch.workspace.environment.sourcing '
        'import build_environment\n'
        f'colcon = CachedColcon(Path({str(overlay.root)!r}))\n'
        'built = build_environment(dict(os.environ), colcon.install_base)\n'
        'result = bring_up_to_date('
        'colcon, ["above"], built.variables, print)\n'
        'show([result.returncode, dict(result.stale), built.notes])\n'
    )
    sourced = overlay.environment(COLCON_PREFIX_PATH=str(underlay))
    assert overlay.run(code, environment=sourced)[0] == [
        [0, {'above': 'never built'}, []]
    ]
    install = overlay.root / 'install'
    assert chained_underlays(install) == [underlay]
    overlay.write('src/above/new.txt')
    ((returncode, stale, notes),), _ = overlay.run(code)
    assert (returncode, stale) == (0, {'above': 'new file new.txt'})
    assert 'as before' in notes[0]
    assert chained_underlays(install) == [underlay]
    # it makes no difference any more whether it is sourced
    assert overlay.run(code)[0][0][:2] == [0, {}]
    assert overlay.run(code, environment=sourced)[0][0][:2] == [0, {}]
