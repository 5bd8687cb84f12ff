# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""docs/logs.md says what the code does."""

import json
from pathlib import Path
import re

from colcon_yamllaunch.common.table import decimal_size
from colcon_yamllaunch.engine import events, limits
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.observers.log_files import Logs
from colcon_yamllaunch.observers.log_store import INDEX_NAME
from colcon_yamllaunch.plan import plan
from colcon_yamllaunch.verb.environment_variables import (
    ALL_LOGS_LIMIT,
    KEPT_LOG_FOLDERS,
)
import pytest

TEXT = (Path(__file__).parents[2] / 'docs/logs.md').read_text()
LINES = TEXT.partition('```json\n')[2].partition('```')[0].splitlines()
EXAMPLES = {record['event']: record for record in map(json.loads, LINES)}


def kinds():
    """Return all classes of events."""
    return {
        kind
        for kind in vars(events).values()
        if isinstance(kind, type) and issubclass(kind, events.Event)
    } - {events.Event}


@pytest.fixture
def records(process, tmp_path):
    """Return what is written about one event of each type."""
    talker = process('kitchen', name='talker-1')
    component = plan.Component(
        'talker', 'demo', 'demo::Talker', '/box', talker.position
    )
    crash = Outcome(signal=11, core_dumped=True)
    happened = [
        events.Planned((talker, component)),
        events.Dropped(talker),
        events.Started(talker, 4711),
        events.StartFailed(talker, 'reason'),
        events.Output(talker, 'stdout', b'text'),
        events.Exited(talker, 4711, crash, 3.25, False, True, 1.0),
        events.Waiting(talker, ('driver',)),
        events.Ready(talker, 1.25),
        events.NotReady(talker, ('a publisher of scan',), 'warn', 60.0),
        events.NotStarted(talker, ('driver',)),
        events.RestartLimit(talker, 5, 60.0, 'fail'),
        events.Respawned(talker, 1),
        events.Suspended(talker, 4711, 20),
        events.Suspended(talker, 4711, None),
        events.Silent(talker, 10.0),
        events.Requested(talker, 'restart'),
        events.Attached(talker),
        events.Detached(talker),
        events.IdleChanged(True),
        events.CannotRun('reason'),
        events.Signalled(talker, 4711, 2, True),
        events.ShuttingDown('interrupted'),
        events.StillRunning(('kitchen',), 0, 2),
        events.LeftBehind(talker, 4711),
        events.MessageShown('INFO', 'hello'),
        events.Warned('trouble'),
        events.Loaded(component, '/demo/talker', 1, 0.05),
        events.LoadFailed(component, 'reason'),
        events.Unloaded(component, 'requested'),
        events.StateChanged(talker, '/lc', 'inactive', 'configuring'),
        events.TransitionFailed(talker, '/lc', 'configure', 'reason'),
        events.RosLost('reason'),
        events.LinkLost('arm', 'reason', False),
        events.LinkBack('arm', 2.5),
        events.MachineGone('arm', 'reason', ('arm│driver',)),
        events.FilesChanged(('/ws/a.py',)),
        events.Built(('flow',), 1.0),
        events.Replanned(('a',), (), ('b',)),
        events.Restarted(talker, 0.5),
        events.ChangeReported('a.py changed'),
        events.ChangeChecked(False, ('one',), (), 0.5),
        events.PlanFailed(('error: oh', '  no')),
        events.WorkerLost('reason'),
        events.Ended(1),
        events.MemberChanged(talker, 'ended'),
        events.LinkChanged('arm', 'done'),
        events.UsageMeasured('arm', {'arm│driver': (0.5, 1000)}),
        events.StateReceived({}),
    ]
    assert {type(event) for event in happened} == kinds()
    logs = Logs(tmp_path / 'log', [talker], pytest.fail)
    for event in happened:
        logs.handle(event)
    logs.close()
    lines = (tmp_path / 'log/events.jsonl').read_text().splitlines()
    recorded = [event for event in happened if event.record()]
    unrecorded = {type(event).__name__ for event in happened} - {
        type(event).__name__ for event in recorded
    }
    assert unrecorded == {
        *('Output', 'StillRunning', 'MemberChanged', 'LinkChanged'),
        *('UsageMeasured', 'StateReceived', 'IdleChanged', 'CannotRun'),
    }
    assert len(lines) == len(recorded)
    return {r['event']: r for r in map(json.loads, lines)}


def row_of(name):
    """Return the row of a table about a value."""
    (row,) = re.findall(rf'^\| `{name}` \|.*$', TEXT, re.MULTILINE)
    return row


def test_there_is_an_example_of_each_event(records):
    assert EXAMPLES.keys() == records.keys()
    for name, record in records.items():
        example = EXAMPLES[name]
        assert list(example) == list(record)
        for key, value in record.items():
            assert type(example[key]) is type(value), (name, key)


def test_each_field_is_explained(records):
    for name, record in records.items():
        row = row_of(name)
        for key in record.keys() - {'time', 'event', 'label', 'name', 'pid'}:
            assert f'`{key}`' in row
    assert '| `time` |' in TEXT
    assert '| `label`, `name`, `pid` |' in TEXT


@pytest.mark.parametrize('mode', sorted(plan.SHOWN))
def test_the_output_modes_are_explained(mode):
    (row,) = (
        line
        for line in TEXT.splitlines()
        if line.startswith('|') and f'`{mode}`' in line.split('|')[1]
    )
    shown, common, own = (cell.strip() for cell in row.split('|')[2:5])
    streams = {'yes': 2, 'standard error only': 1, 'no': 0}[shown]
    assert streams == len(plan.SHOWN[mode])
    assert (common == 'yes') is (mode in plan.IN_COMMON_LOG)
    assert (own == 'yes') is (mode in plan.IN_OWN_LOG)


def test_the_limits_are_those_of_the_code():
    assert f'take at most {decimal_size(limits.DEFAULT_LOG_BYTES)};' in TEXT
    assert (
        f'each file may have {limits.MINIMUM_LOG_FILE_BYTES // 1024} KiB'
        in TEXT
    )
    assert limits.MINIMUM_LOG_SHARES * 2 == 16
    assert limits.ROTATED_LOG_DIVISOR == 8
    assert f'the latest {KEPT_LOG_FOLDERS} launches are kept' in TEXT
    assert f'together take at most {decimal_size(ALL_LOGS_LIMIT)}' in TEXT
    assert f'{100 // limits.FREE_DISK_DIVISOR} %, or half' in TEXT
    assert f'it may have {decimal_size(limits.MINIMUM_LOG_BYTES)}' in TEXT
    assert f'`{INDEX_NAME}` beside them' in TEXT
