# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Launches that are as unruly as can be, for some time.

`SOAK_MINUTES` says for how long; `make soak` takes minutes, other runs of the
tests some seconds.
"""

import os
from pathlib import Path
import re
import signal
import time

from colcon_yamllaunch.engine.cgroup import process_folder
import pytest

pytestmark = pytest.mark.full

SECONDS = 60 * float(os.environ.get('SOAK_MINUTES', '0.08'))
SAMPLE_INTERVAL = 0.25
#: Files that the launcher may have open: three logs and two pipes for each
#: process, the pipes of those that were left running, and its own.
MAXIMUM_FILES = 200
#: MiB that the launcher may take. It begins with 20.
MAXIMUM_MEMORY = 64
DAEMONS = 8
LINES = ''.join(f'{n}\n' for n in range(1, 20001)).encode()

QUICK = {'sigterm_timeout': 0.5, 'sigkill_timeout': 0.5}
AGAIN = {'respawn': True, 'respawn_delay': 0.05, **QUICK}


@pytest.fixture
def unruly(launch, sh):
    """Return a launch of processes that flood, fork, flee and die."""
    flood = 'seq 1 20000 & seq 1 20000 >&2; wait'
    fork = 'for i in 1 2 3; do sleep 0.2 & done; setsid sleep 0.4 & exit 0'
    daemon = 'setsid sleep 9999 & exit 0'
    bare = "env -i setsid sh -c 'echo $$; exec sleep 9999' & exit 0"
    stubborn = 'trap "" INT TERM; while sleep 1; do :; done'
    wiped = 'echo 1; rm -rf "$TEST_LAUNCH/log/wiped"; seq 2 2000'
    endless = "head -c 3000000 /dev/zero | tr '\\0' x"
    parameters = sh('parameters', 'cat "$0"', **AGAIN)
    parameters['argv'].append({'content': 'x: 1\n'})
    late = sh('late', 'sleep 9999 & exec sleep 9999', **QUICK)
    few = AGAIN | {'respawn_max_retries': DAEMONS}
    return launch(
        sh('flood', flood, output='own_log', **AGAIN | {'respawn_delay': 0.3}),
        sh('terminal', flood, emulate_tty=True, output='own_log', **AGAIN),
        sh('storm', 'exit 3', **AGAIN | {'respawn_delay': 0.0}),
        sh('killed', 'echo dying; kill -KILL $$', **AGAIN),
        sh('forking', fork, **AGAIN),
        # each is ended before the next run
        sh('daemons', daemon, **few | {'sigterm_timeout': 0.0}),
        sh('bare', bare, **few),
        sh('stubborn', stubborn, **QUICK),
        sh('held', 'kill -STOP $$; sleep 9999', **QUICK),
        {'label': 'missing', 'argv': ['/no/such/program']},
        {'label': 'rebuilt', 'argv': ['/no/such/program'], **AGAIN},
        # its logs are deleted while it writes them
        sh('wiped', wiped, **AGAIN),
        # more would reach the limit of the logs within minutes
        sh(
            'endless',
            endless,
            output='own_log',
            **AGAIN | {'respawn_delay': 3.0},
        ),
        parameters,
        {'kind': 'timer', 'period': 1.0, 'entries': [late]},
    )


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGKILL])
def test_an_unruly_launch_stays_bounded_and_leaves_nothing(
    unruly, number, wait_until, is_running
):
    guard = wait_until(unruly.guards)[0]
    groups = [process_folder(p) for p in wait_until(unruly.processes)]
    end = time.monotonic() + SECONDS
    while time.monotonic() < end:
        time.sleep(SAMPLE_INTERVAL)
        assert unruly.popen.poll() is None, unruly.screen[-2000:]
        files = os.listdir(f'/proc/{unruly.popen.pid}/fd')
        assert len(files) < MAXIMUM_FILES
        assert _memory(unruly.popen.pid) < MAXIMUM_MEMORY
        assert _memory(guard) < MAXIMUM_MEMORY
    wait_until(lambda: _starts(unruly, 'daemons') > DAEMONS)
    # what was written after its deletion is in the log
    wait_until(lambda: _content(unruly, 'wiped').endswith(b'\n2000\n'))
    unruly.sends(number)
    if number == signal.SIGINT:
        assert unruly.ends() == 1
        assert len(unruly.events('respawned')) > 10 * SECONDS
        _check_logs(unruly)
    unruly.popen.wait()
    wait_until(lambda: not unruly.processes())
    wait_until(lambda: _memory(guard) == 0)
    bare = list(map(int, unruly.log('bare/stdout.log').split()))
    assert bare
    assert not any(map(is_running, bare))
    left = {path.name for path in unruly.folder.iterdir()}
    assert left == {'plan.json', 'screen', 'log'}
    # there may be none
    assert not any(Path(g).parent.exists() for g in groups if g is not None)


def _check_logs(one):
    """Look for what runs that came to their end have written."""
    for label in ('flood', 'terminal'):
        runs = [e for e in one.events('exited') if e['label'] == label]
        complete = [e for e in runs if e['exit_code'] == 0]
        assert complete
        for stream in ('stdout', 'stderr'):
            written = _whole(one.log_folder / label / f'{stream}.log')
            assert written.startswith(LINES * len(complete))
            rest = written[len(LINES) * len(complete) :]
            assert LINES.startswith(rest)
    deaths = [e for e in one.events('exited') if e['label'] == 'killed']
    assert len(deaths) - one.log('killed/stdout.log').count(b'dying\n') <= 1
    failed = one.events('start_failed')
    assert sum(e['label'] == 'rebuilt' for e in failed) > 5
    assert _starts(one, 'daemons') == DAEMONS + 1


def _starts(one, label):
    return sum(e['label'] == label for e in one.events('started'))


def _content(one, label):
    try:
        return one.log(f'{label}/stdout.log')
    except FileNotFoundError:
        return b''


def _whole(log):
    """Return what was written to a log, with the parts that were rotated."""
    parts = sorted(log.parent.glob(f'{log.name}.*'), key=_number, reverse=True)
    return b''.join(part.read_bytes() for part in [*parts, log])


def _number(part):
    return int(part.suffix[1:])


def _memory(pid):
    """Return the MiB that a process takes, 0 when it ended."""
    try:
        status = Path(f'/proc/{pid}/status').read_text(encoding='ascii')
    except (FileNotFoundError, ProcessLookupError):
        return 0
    resident = re.search(r'VmRSS:\s*(\d+)', status)
    return int(resident[1]) / 1024 if resident else 0
