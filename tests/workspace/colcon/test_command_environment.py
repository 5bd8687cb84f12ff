# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

import asyncio
from collections import OrderedDict

from colcon_core.shell import get_command_environment, get_shell_extensions
from colcon_yamllaunch.workspace.colcon.colcon_adapter import (
    remember_command_environment,
)
import pytest

SCRIPT = 'colcon_command_prefix_build.sh'


@pytest.fixture
def remembered(tmp_path, monkeypatch):
    """Return the folder of a build whose environment is remembered."""
    monkeypatch.setenv('A_VARIABLE', 'one line\nand another = with this')
    remember_command_environment(tmp_path / 'warm')
    yield tmp_path / 'build'
    for extensions in get_shell_extensions().values():
        for extension in extensions.values():
            vars(extension).pop('generate_command_environment', None)


def asked(folder, dependencies=()):
    """Return the environment for a build, as colcon's tasks ask for it."""
    needed = OrderedDict(dependencies)
    return dict(asyncio.run(get_command_environment('build', folder, needed)))


def is_answered_by_a_shell(folder):
    """Tell whether a shell was run, of which colcon writes what it printed."""
    log = folder / f'{SCRIPT}.env'
    answered = log.exists()
    log.unlink(missing_ok=True)
    return answered


def test_no_shell_is_run_for_what_one_has_answered(remembered, monkeypatch):
    first = asked(remembered)
    # there is no script yet
    assert is_answered_by_a_shell(remembered)
    assert asked(remembered) == first
    assert not is_answered_by_a_shell(remembered)
    assert first['PWD'] == str(remembered)
    monkeypatch.setenv('ANOTHER', 'variable')
    assert asked(remembered) == {**first, 'ANOTHER': 'variable'}
    assert not is_answered_by_a_shell(remembered)


def test_a_variable_that_shells_may_drop_has_one_asked(
    remembered, monkeypatch
):
    asked(remembered)
    is_answered_by_a_shell(remembered)
    monkeypatch.setenv('BASH_FUNC_hello%%', '() { true; }')
    asked(remembered)
    assert is_answered_by_a_shell(remembered)


def test_dependencies_are_sourced(remembered, tmp_path):
    script = tmp_path / 'install/share/needed/package.sh'
    script.parent.mkdir(parents=True)
    script.write_text('export FROM_NEEDED=yes\n')
    needed = {'needed': str(tmp_path / 'install')}
    before = asked(remembered)
    assert asked(remembered, needed) == {**before, 'FROM_NEEDED': 'yes'}
    is_answered_by_a_shell(remembered)
    # what stands there for users is to be brought up to date
    assert asked(remembered) == before
    assert is_answered_by_a_shell(remembered)
    assert 'needed' not in (remembered / SCRIPT).read_text()


def test_a_shell_that_changes_variables_is_asked_on(tmp_path, monkeypatch):
    # shells take no other one from outside
    monkeypatch.setenv('IFS', ':')
    remember_command_environment(tmp_path / 'warm')
    asked(tmp_path)
    assert is_answered_by_a_shell(tmp_path)
    assert asked(tmp_path)['IFS'] != ':'
    assert is_answered_by_a_shell(tmp_path)
