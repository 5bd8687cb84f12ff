# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The remembered environment is always what a fresh bash would give."""

import json
import os
from pathlib import Path
import shutil
import sys
import time

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.workspace.environment.environment_cache import (
    cached_environment,
    FOLDER_NAME,
    MAXIMUM_RECORDS,
)
from colcon_yamllaunch.workspace.environment.sourcing import source
import pytest
from support.file_clock import let_files_settle
from support.install_space import in_bash, InstallSpace

pytestmark = pytest.mark.full

BASE = {'PATH': os.defpath, 'HOME': '/nowhere', 'LANG': 'C.UTF-8'}


class Memory:
    """A workspace whose environment is remembered."""

    def __init__(self, root: Path, **kind: object) -> None:
        self.install = InstallSpace(root / 'install', **kind)
        self.build = root / 'build'
        self.build.mkdir()
        self.sourced = 0

    def get(self, environment=None, settled=True, times=1):
        """Source, maybe several times, and compare with a real bash."""
        environment = BASE if environment is None else environment
        raw = {os.fsencode(k): os.fsencode(v) for k, v in environment.items()}
        results = []
        for _ in range(times):
            if settled:
                self.settle()
            results.append(
                cached_environment(
                    self.install.setup, environment, self.build, self._source
                )
            )
        expected = in_bash(self.install.setup, raw, self.build)
        for result in results:
            variables = result.variables.items()
            assert {
                os.fsencode(k): os.fsencode(v) for k, v in variables
            } == expected
        return results[-1]

    def settle(self):
        """Wait until any change of a file would show."""
        let_files_settle(self.install.path.parent)

    def _source(self, setup, environment):
        self.sourced += 1
        return source(setup, environment)

    def records(self):
        return sorted((self.build / FOLDER_NAME).glob('*'))


@pytest.fixture(params=['isolated', 'merged'])
def memory(tmp_path, request):
    memory = Memory(tmp_path / 'ws', merged=request.param == 'merged')
    memory.install.package('a')
    memory.install.package('b', 'prepend-non-duplicate;PATH;bin', needs='a')
    return memory


def test_sourced_once(memory):
    first = memory.get()
    assert memory.sourced == 1
    assert memory.get() == first
    assert memory.sourced == 1
    assert first.packages == {'a', 'b'}


def test_every_kind_of_hook(memory):
    (memory.install.prefix('c') / 'here').mkdir(parents=True)
    memory.install.package(
        'c',
        '# a comment',
        'set;PLACE;here',
        'set;TEXT;a text; with more',
        'set;EMPTY;',
        'set-if-unset;GIVEN;no',
        'set-if-unset;MISSING;yes',
        'append-non-duplicate;LAST;x;y',
        'prepend-non-duplicate-if-exists;PATH;here;gone',
    )
    environment = {**BASE, 'GIVEN': 'yes', 'LAST': ''}
    variables = memory.get(environment, times=2).variables
    assert variables['PLACE'] == str(memory.install.prefix('c') / 'here')
    assert variables['GIVEN'] == 'yes'
    assert memory.sourced == 1


#: What a caller may have in the environment.
ODD = [
    {},
    {'PATH': os.defpath},
    {**BASE, 'A': 'two\nlines\n', 'B': '\udcff\udc80', 'C': '', 'ü': 'ö'},
    {**BASE, 'BASH_FUNC_f%%': '() {  echo "$1"\n}', 'x.y': '1', '1': '2'},
    {**BASE, 'BASH_FUNC_dirname%%': '() {  command dirname "$1"; }'},
    {**BASE, 'PATH': ':'.join([os.defpath, *['/x' * 30] * 1500])},
    {**BASE, 'PATH': f'{os.defpath}:relative:'},
    {**BASE, 'SHLVL': '7', '_': 'x', 'PWD': '/etc', 'OLDPWD': '/usr'},
    {**BASE, 'COLCON_TRACE': '1', 'AMENT_TRACE_SETUP_FILES': '1'},
    {**BASE, 'COLCON_PREFIX_PATH': '/*:/x y:$(echo 1)'},
    {**BASE, 'AMENT_PREFIX_PATH': '/*:/x y:$(echo 1)', 'IFS': '/'},
    {**BASE, 'PYTHONPATH': ':relative:/x', 'CDPATH': '/', 'IFS': 'x'},
    {**BASE, 'COLCON_PYTHON_EXECUTABLE': sys.executable},
    {**BASE, 'COLCON_PYTHON_EXECUTABLE': '/nowhere/python'},
    {**BASE, 'COLCON_CURRENT_PREFIX': '/x', 'RANDOM': '1', 'UID': '2'},
]


@pytest.mark.parametrize('environment', ODD)
def test_odd_environment_of_the_caller(memory, environment):
    memory.get(environment, times=2)


def test_underlays(tmp_path):
    below = InstallSpace(tmp_path / 'below')
    below.package('x', 'prepend-non-duplicate;PATH;bin')
    middle = InstallSpace(tmp_path / 'mid dle', merged=True)
    middle.package('y', 'set;Y;1', 'prepend-non-duplicate;PATH;bin')
    chained = [middle.path, below.path]
    memory = Memory(tmp_path / 'ws', chained=chained)
    memory.install.package('z', 'set;Z;1')
    result = memory.get(times=2)
    assert result.variables['Y'] == '1'
    assert result.packages == {'z'}
    assert memory.sourced == 1
    below.package('x', 'set;Y;2')
    assert memory.get().variables['Y'] == '1'
    middle.package('new', 'set;Y;3')
    assert memory.get().variables['Y'] in '13'
    middle.package('y', 'set;W;1')
    assert memory.get().variables['W'] == '1'
    assert memory.sourced == 4


def test_underlay_of_ament(tmp_path):
    templates = pytest.importorskip(
        'ament_package.templates', reason='needs the ROS wheels'
    )
    prefix = tmp_path / 'ros'
    ament_prefix(templates, prefix)
    memory = Memory(tmp_path / 'ws', chained=[prefix])
    memory.install.package('z')
    (prefix / 'local_setup.bash').stat()
    variables = memory.get(times=2).variables
    assert variables['ROS_DISTRO'] == 'any'
    assert variables['AMENT_PREFIX_PATH'].endswith(str(prefix))
    assert memory.sourced == 1
    hook = prefix / 'share/r/environment/distro.dsv'
    hook.write_text('set;ROS_DISTRO;new\n')
    assert memory.get().variables['ROS_DISTRO'] == 'new'
    (prefix / 'share/r/package.dsv').unlink()
    (prefix / 'share/r/local_setup.sh').write_text('export SCRIPT=1\n')
    assert memory.get(times=2).variables['SCRIPT'] == '1'
    assert memory.sourced == 4


def ament_prefix(templates, prefix):
    """Write a prefix such as /opt/ros/jazzy."""
    index = prefix / 'share/ament_index/resource_index'
    for folder in ('packages', 'package_run_dependencies'):
        (index / folder).mkdir(parents=True)
        (index / folder / 'r').touch()
    folder = prefix / 'share/r/environment'
    folder.mkdir(parents=True)
    (folder / 'distro.dsv').write_text(
        'set;ROS_DISTRO;any\nprepend-non-duplicate;AMENT_PREFIX_PATH;\n'
    )
    (folder.parent / 'package.dsv').write_text(
        'source;share/r/environment/distro.sh\n'
    )
    for path in templates.get_prefix_level_template_names(all_platforms=True):
        template = Path(templates.get_prefix_level_template_path(path))
        text = template.read_text()
        text = text.replace('@CMAKE_INSTALL_PREFIX@', str(prefix))
        text = text.replace(
            '@ament_package_PYTHON_EXECUTABLE@', sys.executable
        )
        (prefix / path.removesuffix('.in')).write_text(text)


@pytest.mark.parametrize(
    'text',
    [
        'export N=$(($(cat "$COUNTER" 2>/dev/null) + 1))\n'
        'echo $N >"$COUNTER"\n',
        '',
    ],
)
def test_script_of_unknown_content_is_not_remembered(memory, tmp_path, text):
    environment = {**BASE, 'COUNTER': str(tmp_path / 'no/counter')}
    memory.install.package('s', script=f'# a script\n{text}')
    memory.get(environment, times=2)
    assert memory.sourced == 2
    assert memory.records() == []


@pytest.mark.parametrize(
    'line',
    [
        'set;A;$(cat $COUNTER)',
        'set;A;`cat $COUNTER`',
        'set;A;"; A=1; "',
        'set;A;$RANDOM',
        'append-non-duplicate;SECONDS;1',
        'set;A B;1',
    ],
)
def test_value_that_bash_evaluates_is_not_cached(tmp_path, line):
    memory = Memory(tmp_path)
    memory.install.package('s', line)
    for _ in range(2):
        memory.settle()
        cached_environment(
            memory.install.setup, BASE, memory.build, memory._source
        )
    assert memory.sourced == 2
    assert memory.records() == []


@pytest.mark.parametrize(
    ('line', 'sourced'), [('THE_END=1', 2), ('export THE_END=1', 3)]
)
@pytest.mark.parametrize('name', ['setup.bash', 'local_setup.bash'])
def test_edited_script_that_sets_variables_is_not_cached(
    memory, name, line, sourced
):
    memory.get()
    with (memory.install.path / name).open('a') as file:
        file.write(f'\n{line}\n')
    memory.get(times=2)
    assert memory.sourced == sourced


def test_caller_with_other_variables(memory):
    for _ in range(2):
        for value in 'ab':
            memory.get({**BASE, 'A': value})
    assert memory.sourced == 2
    memory.get({**BASE, 'A': 'a', 'PWD': '/etc', 'SHLVL': '3'})
    assert memory.sourced == 2


def test_folders_of_libraries_in_another_order(memory):
    # as a Python with the ROS wheels has them, whenever it starts
    memory.install.package('c', 'prepend-non-duplicate;LD_LIBRARY_PATH;lib')
    for value in ('/x:/y:/z', '/z:/x:/y'):
        variables = memory.get({**BASE, 'LD_LIBRARY_PATH': value}).variables
        assert variables['LD_LIBRARY_PATH'].endswith(f'lib:{value}')
    assert memory.sourced == 1
    memory.get({**BASE, 'LD_LIBRARY_PATH': '/x:/y'})
    memory.get({**BASE, 'PATH': f'/x:{os.defpath}'})
    memory.get({**BASE, 'PATH': f'{os.defpath}:/x'})
    assert memory.sourced == 4


def test_few_records_are_kept(memory):
    environments = [{**BASE, 'A': str(n)} for n in range(MAXIMUM_RECORDS + 2)]
    memory.settle()
    for environment in environments:
        cached_environment(memory.install.setup, environment, memory.build)
    assert len(memory.records()) == MAXIMUM_RECORDS


def test_no_secret_gets_to_the_disk(memory):
    environment = {**BASE, 'TOKEN': 'confidential'}
    memory.get(environment)
    (record,) = memory.records()
    assert 'confidential' not in record.read_text()
    assert record.stat().st_mode & 0o777 == 0o600
    assert record.parent.stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize(
    'content',
    [
        *('', '{', '[]', '{}', 'null', '{"paths": 1, "state": 2}'),
        '%s, "changes": {"A": [1]}}',
    ],
)
def test_damaged_record_counts_as_none(memory, content):
    memory.get()
    (record,) = memory.records()
    text = record.read_text().removesuffix('}')
    record.write_text(content.replace('%s', text))
    memory.get(times=2)
    assert memory.sourced == 2


@pytest.mark.parametrize('value', ['first', 'other'])
def test_change_in_the_same_tick_as_the_record(memory, value, monkeypatch):
    memory.install.package('a', 'set;WORD;first')
    # as if the clock of the file system stood still since the scripts came
    now = max(p.stat().st_ctime_ns for p in memory.install.path.rglob('*'))
    monkeypatch.setattr(time, 'time_ns', lambda: now + 1)

    def get():
        return cached_environment(
            memory.install.setup, BASE, memory.build, memory._source
        ).variables['WORD']

    assert get() == 'first'
    memory.install.package('a', f'set;WORD;{value}')
    assert get() == value
    # in doubt it is sourced
    assert memory.sourced == 2


def test_written_anew_with_the_same_content(memory):
    first = memory.get()
    for path in memory.install.path.rglob('*'):
        if path.is_file():
            content, mode = path.read_bytes(), path.stat().st_mode
            path.unlink()
            path.write_bytes(content)
            path.chmod(mode)
    (record,) = memory.records()
    before = json.loads(record.read_text())
    assert memory.get(settled=False) == first
    assert memory.get() == first
    assert memory.sourced == 1
    # so that the next one need not read them
    assert json.loads(record.read_text())['state'] != before['state']


def test_a_build_that_brought_something(memory):
    memory.get()
    memory.install.package('c', 'set;NEW;1')
    assert memory.get(settled=False).variables['NEW'] == '1'
    shutil.rmtree(memory.install.prefix('c') / 'share/c')
    index = memory.install.prefix('c') / 'share/colcon-core/packages/c'
    index.unlink()
    assert 'NEW' not in memory.get(settled=False).variables
    assert memory.sourced == 3


def test_change_while_the_scripts_are_sourced(memory):
    def sourcing(setup, environment):
        result = source(setup, environment)
        memory.install.package('a', 'set;LATE;1')
        return result

    memory.settle()
    cached_environment(memory.install.setup, BASE, memory.build, sourcing)
    assert memory.get().variables['LATE'] == '1'


def test_without_a_build_folder(memory):
    memory.build.rmdir()
    memory.settle()
    for _ in range(2):
        result = cached_environment(memory.install.setup, BASE, memory.build)
        assert result.packages == {'a', 'b'}
    assert not memory.build.exists()


def test_moved_workspace(memory, tmp_path):
    memory.get()
    moved = shutil.move(tmp_path / 'ws', tmp_path / 'other')
    memory.install.path = Path(moved) / 'install'
    memory.build = Path(moved) / 'build'
    assert str(moved) in memory.get().variables['COLCON_PREFIX_PATH']
    assert memory.sourced == 2


def test_missing_underlay_is_noticed_each_time(tmp_path):
    below = InstallSpace(tmp_path / 'below')
    memory = Memory(tmp_path / 'ws', chained=[below.path])
    memory.install.package('a')
    assert memory.get().notes == ()
    shutil.rmtree(below.path)
    for _ in range(2):
        (note,) = memory.get().notes
        assert str(below.path) in note
        assert 'source its successor' in note
    assert memory.sourced == 3


def test_script_that_fails_names_the_cure(memory):
    text = memory.install.setup.read_text()
    memory.install.setup.write_text(text[: text.index('fi\n')])
    with pytest.raises(WorkspaceError) as error:
        cached_environment(memory.install.setup, BASE, memory.build)
    assert 'syntax error' in str(error.value)
    assert 'run `colcon build`' in str(error.value)
