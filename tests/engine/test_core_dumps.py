# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

import os
from pathlib import Path
import resource

from colcon_yamllaunch.engine.debugging import find_core_dump, KERNEL
import pytest

NOW = 1732000000.0


@pytest.fixture
def find(tmp_path):
    """Return a function that looks in a folder with some files."""

    def look(pattern, *names, uses_pid='0', age=0.5, cwd='here'):
        (tmp_path / 'core_pattern').write_text(f'{pattern}\n')
        (tmp_path / 'core_uses_pid').write_text(f'{uses_pid}\n')
        folder = tmp_path / cwd
        folder.mkdir()
        for index, name in enumerate(names):
            (folder / name).write_text('')
            time = NOW - age - index
            os.utime(folder / name, (time, time))
        found = find_core_dump(12, str(folder), 1.5, tmp_path, lambda: NOW)
        return found and found.removeprefix(f'{folder}/')

    return look


EVENTS = ('core-talker.12.1732', 'core-talker.12.1731', 'core-x.13.1732')


@pytest.mark.parametrize(
    ('pattern', 'names', 'more', 'expected'),
    [
        ('core', ('core', 'core.12'), {'cwd': 'a [1]'}, 'core'),
        ('core', ('core', 'core.12'), {'uses_pid': '1'}, 'core.12'),
        # what is not known matches anything
        ('core-%e.%p.%t', EVENTS, {'uses_pid': '1'}, EVENTS[0]),
        ('100%%[a]%p', ('100%a12', '100%[a]12'), {}, '100%[a]12'),
        # older than the process
        ('core', ('core',), {'age': 60}, None),
        ('core', (), {}, None),
    ],
)
def test_core_dump_is_found_by_the_pattern_of_the_system(
    find, pattern, names, more, expected
):
    assert find(pattern, *names, **more) == expected


def test_a_program_may_take_it(find, tmp_path):
    command = '|/lib/systemd/systemd-coredump %P %u'
    assert find(command) == 'coredumpctl debug 12'
    (tmp_path / 'core_pattern').write_text('|/usr/share/apport/apport -p%p')
    found = find_core_dump(12, '/', 1.0, tmp_path)
    assert found == 'passed to /usr/share/apport/apport'


@pytest.mark.skipif(
    (KERNEL / 'core_pattern').read_text()[:1] in '|/'
    or resource.getrlimit(resource.RLIMIT_CORE)[1] == 0,
    reason='core dumps do not stay in the working directory here',
)
def test_the_closing_lines_name_the_core_dump(launch, sh, tmp_path):
    one = launch(
        sh('bad', 'kill -SEGV $$', cwd=str(tmp_path)),
        popen={'preexec_fn': _allow_core_dumps},
    )
    assert one.ends() == 1
    assert 'core dumped' in one.screen
    line = next(t for t in one.screen.splitlines() if 'core dump:' in t)
    path = Path(line.partition('core dump: ')[2])
    assert path.parent == tmp_path
    path.unlink()


def _allow_core_dumps():
    _, hard = resource.getrlimit(resource.RLIMIT_CORE)
    resource.setrlimit(resource.RLIMIT_CORE, (hard, hard))
