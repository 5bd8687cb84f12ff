# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

import fcntl
import json
import os
import shutil

from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.events import (
    Exited,
    MessageShown,
    Output,
    Planned,
    Started,
)
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.observers.log_files import (
    folder_names,
    lock_folder,
    Logs,
)
import pytest


@pytest.fixture
def logged(process, tmp_path):
    """Return a function that logs events and returns the folder."""

    def log(*events, complain=print, **attributes):
        folder = tmp_path / 'log'
        members = [process('counter', **attributes)]
        logs = Logs(folder, members, complain, now=lambda: 1732000000.25)
        for event in events:
            if isinstance(event, Output):
                logs.record(event.process, event.stream, event.data)
            logs.handle(event)
        logs.close()
        return folder

    return log


@pytest.fixture
def logs_of(tmp_path):
    """Return a function that makes the logs of processes."""
    made = []

    def make(*processes):
        made.append(Logs(tmp_path, processes, pytest.fail))
        return made[-1]

    yield make
    for logs in made:
        logs.close()


def output_of(process):
    out, err = ('stdout', b'one\r\n\xff\n'), ('stderr', b'two\n')
    written = (out, err, ('stdout', b'partial'))
    return Started(process, 12), *(Output(process, *one) for one in written)


def test_process_logs_have_exact_bytes(logged, process):
    folder = logged(*output_of(process('counter'))) / 'counter'
    assert (folder / 'stdout.log').read_bytes() == b'one\r\n\xff\npartial'
    assert (folder / 'stderr.log').read_bytes() == b'two\n'
    assert (folder / 'stdout_stderr.log').read_bytes() == (
        b'one\r\n\xff\ntwo\npartial'
    )


def test_common_log_has_time_and_label_in_each_line(logged, process):
    folder = logged(
        *output_of(process('counter')), MessageShown('INFO', 'hello')
    )
    assert (folder / 'launch.log').read_bytes().splitlines() == [
        b'1732000000.250000 [launch] counter: started, pid 12',
        b'1732000000.250000 [counter] one',
        b'1732000000.250000 [counter] \xff',
        b'1732000000.250000 [counter] two',
        b'1732000000.250000 [counter] partial',
        b'1732000000.250000 [INFO] [launch.user]: hello',
    ]


@pytest.mark.parametrize(
    ('mode', 'own', 'common'),
    [
        ('both', True, True),
        ('full', True, True),
        ('log', True, True),
        ('own_log', True, False),
        ('screen', False, False),
    ],
)
def test_output_mode_selects_logs(logged, process, mode, own, common):
    folder = logged(*output_of(process('counter', output=mode)), output=mode)
    assert (folder / 'counter').exists() is own
    text = (folder / 'launch.log').read_bytes()
    assert (b'[counter] one' in text) is common
    assert b'started' in text


def test_events_are_json_objects(logged, process):
    counter = process('counter', name='talker-1')
    crash = Exited(counter, 12, Outcome(signal=11), 0.5, False, True, 2.0)
    folder = logged(Started(counter, 12), crash)
    _, line = (folder / 'events.jsonl').read_text().splitlines()
    assert json.loads(line) == {
        'time': 1732000000.25,
        'event': 'exited',
        'label': 'counter',
        'name': 'talker-1',
        'pid': 12,
        'exit_code': None,
        'signal': 'SIGSEGV',
        'core_dumped': False,
        'seconds': 0.5,
        'asked': False,
        'failed': True,
        'respawn_delay': 2.0,
    }


def test_partial_lines_are_logged_at_once(process, logs_of, tmp_path):
    one = process('one')
    logs = logs_of(one)
    log = tmp_path / 'one/stdout_stderr.log'
    logs.record(one, 'stdout', b'pie')
    assert (tmp_path / 'one/stdout.log').read_bytes() == b'pie'
    # what goes on at once is not mixed with the other stream
    logs.record(one, 'stderr', b'error\n')
    logs.record(one, 'stdout', b'ce\nprompt: ')
    logs.flush()
    both = b'error\npiece\n'
    assert log.read_bytes() == both
    # and what waits longer is not held back
    logs.flush()
    both += b'prompt: '
    assert log.read_bytes() == both
    assert not logs.flush()
    logs.record(one, 'stdout', b'x' * (limits.READ_BYTES + 1))
    assert log.read_bytes() == both + b'x' * (limits.READ_BYTES + 1)


def test_log_files_are_opened_with_output_or_on_flush(
    process, logs_of, tmp_path
):
    quiet, loud = process('quiet'), process('loud')
    logs = logs_of(quiet, loud)
    logs.handle(Started(quiet, 12))
    logs.handle(Started(loud, 13))
    logs.record(loud, 'stdout', b'one\n')
    assert (tmp_path / 'loud/stdout.log').read_bytes() == b'one\n'
    assert not (tmp_path / 'quiet').exists()
    logs.flush()
    assert (tmp_path / 'quiet/stdout_stderr.log').exists()


def test_log_files_of_many_processes_are_opened_in_turns(
    process, logs_of, tmp_path
):
    many = [process(f'p{n}') for n in range(3 * limits.LOGS_OPENED_PER_TURN)]
    logs = logs_of(*many)
    for one in many:
        logs.handle(Started(one, 12))
    counts = [2]
    while logs.flush():
        counts.append(len(list(tmp_path.iterdir())))
    assert len(counts) == 3
    assert counts == sorted(set(counts))
    assert len(list(tmp_path.iterdir())) == 2 + len(many)


def test_folder_that_cannot_be_made_warns_once(logged, process, tmp_path):
    (tmp_path / 'log').write_text('in the way')
    complaints = []
    logged(*output_of(process('counter')), complain=complaints.append)
    assert len(complaints) == 1
    assert str(tmp_path / 'log') in complaints[0]


@pytest.mark.hostile
def test_a_folder_that_was_deleted_is_locked_again(process, tmp_path):
    folder = tmp_path / 'log'
    logs = Logs(folder, [process('one')], pytest.fail)
    exclusive = fcntl.LOCK_EX | fcntl.LOCK_NB
    shutil.rmtree(folder)
    logs.flush()
    assert not folder.exists()
    logs.handle(MessageShown('INFO', 'on'))
    logs.flush()
    assert b'on' in (folder / 'launch.log').read_bytes()
    assert b'on' in (folder / 'events.jsonl').read_bytes()
    assert lock_folder(folder, exclusive) is None
    logs.close()
    descriptor = lock_folder(folder, exclusive)
    assert descriptor is not None
    os.close(descriptor)


def test_any_label_has_a_valid_unique_folder(process):
    labels = ['a/b', 'a_b', '.', '..', 'launch.log', 'ä ö', 'x' * 400]
    labels += ['y' * 300 + '1', 'y' * 300 + '2', 'line\nend', '']
    names = folder_names(map(process, labels))
    assert len(set(names.values())) == len(labels)
    for name in names.values():
        assert '/' not in name
        assert name not in ('.', '..', 'launch.log', 'events.jsonl', '')
        assert len(name.encode()) < 255
        assert name.isprintable()
    assert names['ä ö'] == 'ä ö'


def test_folder_name_has_the_number_of_the_process(process):
    nodes = [
        process('talker', name='talker-1'),
        process('left/camera', name='driver.py-2'),
        process('driver.py-3', name='driver.py-3'),
    ]
    assert folder_names(nodes) == {
        'talker': 'talker-1',
        'left/camera': 'left.camera-2',
        'driver.py-3': 'driver.py-3',
    }


def test_processes_planned_later_have_logs(logged, process):
    later = process('talker', name='talker-2')
    other = process('talker.2', name='talker.2')
    unlogged = process('counter', output='screen')
    folder = logged(
        *(Planned((later, other)), *output_of(later)),
        *(Planned((unlogged,)), *output_of(unlogged)),
    )
    assert (folder / 'talker-2/stderr.log').read_bytes() == b'two\n'
    folders = [p.name for p in folder.iterdir() if p.is_dir()]
    assert folders == ['talker-2']
