# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

from pathlib import Path
import signal

from colcon_yamllaunch.engine.events import (
    Dropped,
    Exited,
    LeftBehind,
    LinkBack,
    Loaded,
    LoadFailed,
    MachineGone,
    Output,
    PlanFailed,
    RosLost,
    ShuttingDown,
    Started,
    StartFailed,
    StateChanged,
    TransitionFailed,
    WorkerLost,
)
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.observers.failures import Failures
from colcon_yamllaunch.plan.position import Position
import pytest
from support.history import component
from support.launch_states import planned_state


def exited(process, **outcome):
    failed = outcome.get('code') != 0
    return Exited(process, 9, Outcome(**outcome), 1.25, False, failed)


def heard(*events, log_files=None):
    state = planned_state()
    state.log_files = log_files or {}
    failures = Failures(state)
    for event in events:
        happen(failures, event)
    return failures


def happen(failures, event):
    failures._state.apply(event)
    failures.handle(event)


def exit_code(failures):
    return int(failures._state.has_failed)


@pytest.mark.parametrize(
    ('happened', 'expected'),
    [
        ('start 0', 0),
        ('start 3 start 0', 0),
        ('start 0 start 3', 1),
        ('left behind', 1),
        # a machine starts it again before it is told to stop
        ('start 3 stop start asked', 1),
    ],
)
def test_last_run_decides_the_exit_code(process, happened, expected):
    a = process('a')
    known = {
        'start': Started(a, 8),
        '0': exited(a, code=0),
        '3': exited(a, code=3),
        'asked': Exited(a, 9, Outcome(code=3), 0.1, asked=True, failed=False),
        'stop': ShuttingDown('a failed'),
        'left': LeftBehind(a, 9),
    }
    failures = heard(*(known[w] for w in happened.split() if w in known))
    assert exit_code(failures) == expected
    if happened == 'start 0':
        assert failures.summary() == ()


def test_first_failure_has_details_and_others_a_line(process):
    first, second = process('first'), process('second')
    failures = heard(
        *(Started(first, 8), Started(second, 9)),
        Output(second, 'stdout', b'of no interest\n'),
        Output(first, 'stdout', b'one\n'),
        Output(first, 'stderr', b'\x1b[31mtwo\x1b[0m\npartial'),
        *(exited(first, signal=signal.SIGSEGV), exited(second, code=3)),
        Output(process('third'), 'stdout', b'something else\n'),
        log_files={'first': Path('/log/first.log')},
    )
    assert exit_code(failures) == 1
    place = 'after 1.2 s (from /ws/demo.yaml:14:5)'
    assert failures.summary() == (
        f'failed: first died by SIGSEGV (segmentation fault) {place}',
        '  the last lines of first:',
        *('  | one', '  | two', '  | partial'),
        '  all of its output: /log/first.log',
        f'then failed: second exited with code 3 {place}',
    )


def test_file_below_current_folder_has_a_relative_path(
    process, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    place = Position(str(tmp_path / 'launch/demo.yaml'), 3, 5)
    failures = heard(exited(process(position=place), code=3))
    assert '(from launch/demo.yaml:3:5)' in failures.summary()[0]


def test_summary_has_the_last_ten_lines(process):
    lines = [f'line {n}' for n in range(5000)]
    failures = heard(
        *(Output(process(), 'stdout', f'{t}\n'.encode()) for t in lines),
        exited(process(), code=3),
        Output(process('other'), 'stdout', b'something else\n'),
    )
    told = [t for t in failures.summary() if t.startswith('  | ')]
    assert told == [f'  | {t}' for t in lines[-10:]]


def test_huge_line_is_cut_in_the_summary(process):
    failures = heard(
        Output(process(), 'stdout', b'x' * 10_000_000),
        exited(process(), code=3),
    )
    assert sum(map(len, failures.summary())) < 10_000


def test_output_right_above_is_not_repeated(process):
    first, second = process('first'), process('second')
    told = [Output(first, 'stderr', b'one\n'), exited(first, code=3)]
    assert '  | one' not in heard(*told).summary()
    (report,) = heard(*told).reports()
    assert report.tail == ('one',)
    # others said something after it
    told.append(Output(second, 'stdout', b'two\n'))
    assert '  | one' in heard(*told).summary()


def test_reason_right_above_is_not_repeated(process):
    first = StartFailed(process('first'), 'no: such thing')
    second = StartFailed(process('second'), 'no: such thing')
    assert heard(first, second).summary() == (
        'failed: first could not be started (from /ws/demo.yaml:14:5)',
        'then failed: second could not be started (from /ws/demo.yaml:14:5)',
    )
    (report,) = heard(first).reports()
    assert report.text == 'first could not be started: no: such thing'
    others = [exited(process(f'p{n}'), code=0) for n in range(20)]
    (line,) = heard(first, *others).summary()
    assert line.startswith('failed: first could not be started: no: such ')


def test_output_hidden_or_far_above_is_repeated(process):
    quiet = process('quiet', output='own_log')
    told = [Output(quiet, 'stderr', b'one\n'), exited(quiet, code=3)]
    assert '  | one' in heard(*told).summary()
    first = process('first')
    told = [Output(first, 'stderr', b'one\n'), exited(first, code=3)]
    told += [exited(process(f'p{n}'), code=0) for n in range(20)]
    assert '  | one' in heard(*told).summary()


def test_component_loaded_later_is_no_failure(process):
    refused = LoadFailed(component(), 'no such plugin')
    said = Output(process(), 'stdout', b'something else\n')
    failures = heard(refused, said)
    assert exit_code(failures) == 1
    reason = 'a could not be loaded into /box: no such plugin'
    line = f'failed: {reason} (from /ws/demo.yaml:7:9)'
    assert failures.summary() == (line,)
    (report,) = failures.reports()
    assert report.member == component()
    failures = heard(refused, Loaded(component(), '/a', 1, 0.1))
    assert exit_code(failures) == 0


def test_node_activated_later_is_no_failure(process):
    node = process('lc-1')
    failed = TransitionFailed(node, '/lc', 'configure', 'it would not')
    said = Output(process('other'), 'stdout', b'something else\n')
    assert heard(failed, said).summary() == (
        "failed: lc-1: the transition 'configure' of /lc failed: "
        'it would not (from /ws/demo.yaml:14:5)',
    )
    active = StateChanged(node, '/lc', 'active', 'activating')
    assert exit_code(heard(failed, active)) == 0
    # the end of its process says more
    (report,) = heard(exited(node, code=3), failed).reports()
    assert 'exited with code 3' in report.text


def test_dropped_process_is_no_failure(process):
    a = process('a')
    failures = heard(exited(a, code=3), Dropped(a))
    assert exit_code(failures) == 0
    assert failures.summary() == ()


def test_lost_machine_is_one_failure(process):
    lost = [process('arm│a'), process('arm│b')]
    failures = heard(
        MachineGone('arm', 'it was started anew', ('arm│a', 'arm│b')),
        *(Exited(p, 7, Outcome(lost='arm'), 2.0, False, True) for p in lost),
    )
    assert exit_code(failures) == 1
    assert failures.summary() == ('failed: arm is gone: it was started anew',)
    # each of them has its place in a report
    assert [(r.member, r.text) for r in failures.reports()] == [
        (lost[0], 'arm│a was lost with arm'),
        (lost[1], 'arm│b was lost with arm'),
        (None, 'arm is gone: it was started anew'),
    ]


def test_no_core_dump_is_looked_for_on_another_machine(
    process, tmp_path, monkeypatch
):
    monkeypatch.setattr(
        'colcon_yamllaunch.engine.debugging.find_core_dump',
        lambda *_: pytest.fail('it is not here'),
    )
    state = planned_state(process('arm│a'))
    state.by_label['arm│a'].machine = 'arm'
    failures = Failures(state)
    crash = Outcome(signal=11, core_dumped=True)
    happen(failures, Exited(process('arm│a'), 7, crash, 2.0, False, True))
    assert exit_code(failures) == 1


def test_failed_helper_processes_are_failures_of_the_launch(process):
    failures = heard(
        exited(process('a'), code=3),
        PlanFailed(('a.launch.py:7: error: no', '  return no')),
        WorkerLost('died by SIGKILL (killed)'),
        RosLost('the ROS client died'),
    )
    assert exit_code(failures) == 1
    host = 'the worker for Python launch files died by SIGKILL (killed)'
    texts = 'a.launch.py:7: error: no', host, 'the ROS client died'
    assert failures.summary()[1:] == tuple(f'failed: {t}' for t in texts)
    assert [r.member for r in failures.reports()[1:]] == [None] * 3


def test_machine_that_is_back_is_no_failure(process):
    gone = MachineGone('arm', 'it was started anew')
    lost = Exited(process(), 8, Outcome(lost='arm'), 1.0, False, True)
    assert exit_code(heard(gone, lost)) == 1
    failures = heard(gone, lost, LinkBack('arm', 1.0), Started(process(), 9))
    assert exit_code(failures) == 0
    assert failures.reports() == ()
