# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What sourcing a setup script gives, with a real bash."""

import os
import subprocess
import tempfile

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.workspace.environment import sourcing
from colcon_yamllaunch.workspace.environment.hooks import missing_packages
from colcon_yamllaunch.workspace.environment.sourcing import source
import pytest

BASE = {'PATH': os.environ['PATH'], 'HOME': '/nowhere', 'SHLVL': '3'}


def script(tmp_path, text, name='setup.bash'):
    path = tmp_path / name
    path.write_text(text)
    return path


def test_variables_are_set_changed_and_unset(tmp_path):
    setup = script(tmp_path, 'export A=1 B="$B:2"\nunset C\nlocal=3\n')
    before = {**BASE, 'B': '1', 'C': 'x'}
    environment = source(setup, before)
    assert environment.variables == {**BASE, 'A': '1', 'B': '1:2'}
    assert before['C'] == 'x'


def test_odd_values_survive(tmp_path):
    value = 'two\nlines = "quoted" $HOME \udcff ü'
    setup = script(tmp_path, 'export COPY="$VALUE"\n')
    variables = source(setup, {**BASE, 'VALUE': value}).variables
    assert variables['COPY'] == value
    assert variables['VALUE'] == value


def test_output_is_kept_apart(tmp_path):
    setup = script(tmp_path, 'echo X=1\necho Y=2 >&2\nexport Z=3\n')
    environment = source(setup, BASE)
    assert environment.variables == {**BASE, 'Z': '3'}
    assert environment.messages == 'X=1\nY=2\n'


def test_path_with_odd_characters(tmp_path):
    folder = tmp_path / 'a b\'c$(touch x)"d'
    folder.mkdir()
    setup = script(folder, 'export HERE="${BASH_SOURCE[0]}" COUNT=$#\n')
    variables = source(setup, BASE).variables
    assert variables['HERE'] == str(setup)
    assert variables['COUNT'] == '0'


def test_bash_starts_fresh(tmp_path):
    trap = script(tmp_path, 'export TRAPPED=1\n', 'env.bash')
    setup = script(tmp_path, 'export N="$UNKNOWN"\n')
    before = {**BASE, 'BASH_ENV': str(trap), 'SHELLOPTS': 'nounset'}
    assert source(setup, before).variables == {**before, 'N': ''}


def test_functions_and_own_variables(tmp_path):
    setup = script(tmp_path, 'cd /\nf() { echo; }\nexport -f f\n')
    before = {'PATH': BASE['PATH'], 'PWD': '/somewhere'}
    variables = source(setup, before).variables
    assert variables['PWD'] == '/somewhere'
    assert set(variables) == {'PATH', 'PWD', 'BASH_FUNC_f%%'}


def test_script_has_no_input(tmp_path):
    setup = script(tmp_path, 'read -r line || export EMPTY=1\n')
    assert source(setup, BASE).variables['EMPTY'] == '1'


def test_path_that_the_script_breaks(tmp_path):
    setup = script(tmp_path, 'export PATH=/nowhere\n')
    assert source(setup, BASE).variables['PATH'] == '/nowhere'


def test_process_left_behind_is_not_waited_for(tmp_path):
    setup = script(tmp_path, 'sleep 300 &\nexport PID=$!\n')
    variables = source(setup, BASE, timeout=60).variables
    os.kill(int(variables['PID']), 9)


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('echo oh no >&2\nreturn 3\n', 'failed with exit code 3\n  oh no'),
        ('exit 0\n', 'ended the shell'),
        ('exit 4\n', 'exit code 4'),
        ('if\n', 'syntax error'),
    ],
)
def test_failing_script(tmp_path, text, message):
    setup = script(tmp_path, text)
    with pytest.raises(WorkspaceError) as error:
        source(setup, BASE)
    assert message in str(error.value)
    assert str(setup) in str(error.value)


def test_script_that_hangs(tmp_path):
    setup = script(tmp_path, 'echo waiting\nsleep 300\n')
    with pytest.raises(WorkspaceError, match=r'within 0\.5 s\n  waiting'):
        source(setup, BASE, timeout=0.5)


def test_missing_script(tmp_path):
    with pytest.raises(WorkspaceError, match='build the workspace first'):
        source(tmp_path / 'setup.bash', BASE)
    script(tmp_path, '', 'setup.sh')
    with pytest.raises(WorkspaceError, match='colcon-bash'):
        source(tmp_path / 'setup.bash', BASE)


def test_same_as_a_shell(workspace, update):
    workspace.ament_cmake('node', '<exec_depend>flow</exec_depend>')
    workspace.cmake('flow')
    workspace.ament_python('talker')
    assert update('node', 'talker')[0][0] == 0
    setup = workspace.root / 'install/setup.bash'
    before = workspace.environment(A='1')
    printed = subprocess.run(
        ['bash', '--norc', '-c', f'. {setup} && env -0'],
        env=before,
        check=True,
        capture_output=True,
        text=True,
    )
    expected = dict(
        entry.split('=', 1) for entry in printed.stdout.split('\0') if entry
    )
    for name in ('SHLVL', '_', 'PWD', 'OLDPWD'):
        expected.pop(name, None)
    environment = source(setup, before)
    assert environment.variables == expected
    names = ['node', 'talker', 'flow']
    install = workspace.root / 'install'
    assert missing_packages(environment, names, install, False) == {}


@pytest.mark.hostile
def test_no_temporary_file_is_needed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(tempfile, 'tempdir', '/does/not/exist')
    setup = script(tmp_path, 'echo noise\nexport A=1\n')
    assert source(setup, BASE).variables == {**BASE, 'A': '1'}


@pytest.mark.hostile
def test_a_script_that_prints_without_end_is_ended(tmp_path, monkeypatch):
    monkeypatch.setattr(sourcing, 'MAXIMUM_OUTPUT', 1_000_000)
    setup = script(tmp_path, 'yes\n')
    with pytest.raises(WorkspaceError, match='more than 1 MB'):
        source(setup, BASE)
