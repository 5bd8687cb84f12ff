# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""`colcon sweep` on this machine, as its users see it."""

import csv
import os
from pathlib import Path
import re
import shutil
import signal
import subprocess
import time

from colcon_yamllaunch.sweep.isolation import reason_for_no_network
import pytest
from support.terminal import Terminal
from support.user import BLOCKING, Launch, User
from support.waiting import wait_until

SIM = """\
launch:
  - arg: {name: seed}
  - arg: {name: world, default: lab}
  - executable: {cmd: sh sim.sh $(var seed) $(var world), name: sim}
"""
#: Fails with the seed 3 on the street; the domain and its network are told.
SCRIPT = """\
echo "domain $ROS_DOMAIN_ID of $1"
echo "reached after $1.5 s"
[ "$1-$2" = 3-street ] && { echo 'it fell' >&2; exit 1; }
echo 'Goal reached'
"""
#: Ends when the file with its name in `go` is there, or never.
PATIENT = """\
trap 'exit 0' INT
touch begun-$1
until [ -e go-$1 ] || [ -e go-all ]; do sleep 0.05; done
echo 'Goal reached'
"""


@pytest.fixture
def sim(user: User) -> User:
    """Return a user with a launch that is worth a sweep."""
    user.write('sim.yaml', SIM)
    user.write('sim.sh', SCRIPT)
    return user


@pytest.fixture
def patient(user: User) -> User:
    """Return a user with a launch that takes as long as the test likes."""
    user.write('sim.yaml', SIM)
    user.write('sim.sh', PATIENT)
    return user


@pytest.fixture(autouse=True)
def own_temporary_folder(user: User) -> None:
    """Have what tells which domains are taken go with the test."""
    folder = user.root.parent / 'tmp'
    folder.mkdir()
    user.environment['TMPDIR'] = str(folder)


def sweep(user: User, *words: str, code: int = 0) -> str:
    """Run `colcon sweep` to its end, and return its output."""
    launch = user.start('colcon', 'sweep', *words)
    assert launch.end() == code, launch.output
    assert 'Traceback' not in launch.output
    return launch.output


def test_blocked_signals_are_unblocked_in_a_sweep(sim: User) -> None:
    words = ('sim.yaml', 'seed:=1,2', '--results', 'r')
    launch = sim.start(*BLOCKING, 'colcon', 'sweep', *words)
    assert launch.end() == 0
    assert '2 runs: 2 succeeded' in launch.output


def rows(folder: Path) -> list[dict[str, str]]:
    with (folder / 'results.csv').open(encoding='utf-8') as file:
        return list(csv.DictReader(file))


def left(user: User) -> list[str]:
    """Return the command lines of what runs in the user's folder."""
    found = []
    for link in Path('/proc').glob('[0-9]*/cwd'):
        try:
            if link.readlink() == user.root:
                found.append((link.parent / 'cmdline').read_text())
        except OSError:
            continue
    return found


def test_sweep_writes_results_logs_and_reports(sim: User) -> None:
    output = sweep(
        sim,
        *('sim.yaml', 'seed:=1..3', 'world:=lab,street'),
        *('--until', 'Goal reached', '--timeout', '100'),
        *('--metric', r'time=reached after ([\d.]+) s', '--results', 'r'),
        code=1,
    )
    assert '6 runs: 5 succeeded, 1 failed' in output
    assert 'failed: run 6, seed:=3 world:=street: ' in output
    assert 'results: r/report.html, results.csv, junit.xml' in output
    folder = sim.root / 'r'
    assert [(r['seed'], r['world'], r['outcome']) for r in rows(folder)] == [
        *(('1', 'lab', 'succeeded'), ('1', 'street', 'succeeded')),
        *(('2', 'lab', 'succeeded'), ('2', 'street', 'succeeded')),
        *(('3', 'lab', 'succeeded'), ('3', 'street', 'failed')),
    ]
    assert [r['time'] for r in rows(folder)] == [
        *('1.5', '1.5', '2.5', '2.5', '3.5', '3.5')
    ]
    log = (folder / 'runs' / '0006' / 'launch.log').read_text()
    assert 'it fell' in log
    assert (folder / 'runs' / '0006' / 'sim-1' / 'stderr.log').exists()
    report = (folder / 'report.html').read_text()
    assert 'href="runs/0006/launch.log"' in report
    assert 'seed:=3 world:=street' in (folder / 'junit.xml').read_text()


def test_the_same_command_goes_on_and_repeats(sim: User) -> None:
    words = ['sim.yaml', 'seed:=2..3', 'world:=street']
    output = sweep(sim, *words, code=1)
    found = re.search(r'results: (\S+)report.html', output)
    assert found is not None
    # below the log folder of the workspace, or of ROS without one
    folder = sim.root / found[1]
    assert folder.parent.name == 'sweeps'
    again = sweep(sim, *words, code=1)
    assert 'all 2 runs are done already' in again
    assert 'versions' not in again
    sim.write('sim.sh', 'echo "Goal reached"')
    repeated = sweep(sim, *words, '--again', 'failed')
    assert '2 runs: 2 succeeded' in repeated
    assert 'the code has changed since other runs of this sweep' in repeated
    assert 'these results are of 2 versions of the code' in repeated
    assert len({row['fingerprint'] for row in rows(folder)}) == 2
    assert '2 versions' in (folder / 'report.html').read_text()
    logs = [folder / 'runs' / f'000{n}' / 'launch.log' for n in (1, 2)]
    assert 'reached after' in logs[0].read_text()
    assert 'reached after' not in logs[1].read_text()
    repeated = sweep(sim, *words, '--again=all')
    assert '2 runs: 2 succeeded' in repeated
    assert 'version' not in repeated
    assert 'reached after' not in logs[0].read_text()


def test_edit_during_a_sweep_affects_later_runs(
    patient: User,
) -> None:
    words = ['sim.yaml', 'seed:=1..3', '--jobs', '1', '--results', 'r']
    started = patient.start('colcon', 'sweep', *words)
    # whichever was planned first
    wait_until(lambda: list(patient.root.glob('begun-*')))
    (first,) = patient.root.glob('begun-*')
    # not the script, which the shell is reading
    patient.write('sim.yaml', f'{SIM}# edited\n')
    # what was found out holds for a second
    time.sleep(1.1)
    patient.write('go-all', '')
    assert started.end() == 0
    versions = {r['seed']: r['fingerprint'] for r in rows(patient.root / 'r')}
    old = versions.pop(first.name.removeprefix('begun-'))
    (new,) = set(versions.values())
    assert old != new
    assert 'are of 2 versions of the code' in started.output


def test_a_required_share(sim: User) -> None:
    words = ['sim.yaml', 'seed:=1..3', 'world:=lab,street', '--results', 'r']
    output = sweep(sim, *words, '--require', '80%')
    assert 'that is 83.33%, and 80% are required: enough' in output
    output = sweep(sim, *words, '--require', '95%', code=1)
    assert '95% are required: too few' in output


def test_concurrent_runs_are_isolated(patient: User) -> None:
    """Each has a domain of its own, and a network where that can be."""
    text = PATIENT.replace(
        'touch',
        'echo "$ROS_DOMAIN_ID $(readlink /proc/self/ns/net)" > '
        'where-$1; touch',
    )
    patient.write('sim.sh', text)
    words = ['sweep', 'sim.yaml', 'seed:=1..3', '--jobs', '3']
    for option in ([], ['--share-network']):
        started = patient.start('colcon', *words, *option, '--results', 'r')
        for number in '123':
            wait_until((patient.root / f'begun-{number}').exists)
        places = [
            (patient.root / f'where-{number}').read_text().split()
            for number in '123'
        ]
        assert len({domain for domain, _ in places}) == 3
        ours = os.readlink('/proc/self/ns/net')
        networks = {network for _, network in places}
        assert len(networks) == (1 if option or ours in networks else 3)
        assert not option or networks == {ours}
        patient.write('go-all', '')
        assert started.end() == 0
        for path in patient.root.glob('*-*'):
            path.unlink()
        words = [*words, '--again', 'all']


def let_one_end(user: User) -> None:
    """Wait for two runs, let one of them end, and wait for the next."""
    wait_until(lambda: len(list(user.root.glob('begun-*'))) == 2)
    # whichever was planned first
    first = next(user.root.glob('begun-*')).name
    user.write(first.replace('begun', 'go'), '')
    wait_until(lambda: len(list(user.root.glob('begun-*'))) == 3)


def test_jobs_limit_concurrent_runs(patient: User) -> None:
    words = ['sim.yaml', 'seed:=1..5', '--jobs', '2', '--results', 'r']
    started = patient.start('colcon', 'sweep', *words)
    let_one_end(patient)
    time.sleep(0.5)
    assert len(list(patient.root.glob('begun-*'))) == 3
    patient.write('go-all', '')
    assert started.end() == 0


def begun(user: User, *words: str) -> Launch:
    """Start a sweep, and wait until one run is done and others go on."""
    words = ('sim.yaml', 'seed:=1..4', '--jobs', '2', '--results', 'r', *words)
    launch = user.start('colcon', 'sweep', *words)
    let_one_end(user)
    # its place is free for the next run before its result is known
    journal = user.root / 'r' / 'journal.jsonl'
    wait_until(lambda: '"run"' in journal.read_text())
    return launch


def test_ctrl_c_keeps_what_is_done(patient: User) -> None:
    launch = begun(patient)
    assert launch.interrupt() == 128 + signal.SIGINT
    assert 'stopping 2 runs (Ctrl-C again to kill)' in launch.output
    assert '4 runs: 1 succeeded, 3 not run yet' in launch.output
    assert 'the same command goes on from here' in launch.output
    assert len(rows(patient.root / 'r')) == 1
    assert not left(patient)
    patient.write('go-all', '')
    words = ['sim.yaml', 'seed:=1..4', '--jobs', '2', '--results', 'r']
    output = sweep(patient, *words)
    assert '1 of 4 runs are done; going on' in output
    assert '4 runs: 4 succeeded' in output


def test_ctrl_c_twice_kills(patient: User) -> None:
    patient.write('sim.sh', PATIENT.replace("'exit 0'", "''"))
    # so that nothing else ends what takes no notice of SIGINT
    patient.write(
        'sim.yaml', SIM.replace('sim}', 'sim, sigterm_timeout: 900}')
    )
    launch = begun(patient)
    launch.process.send_signal(signal.SIGINT)
    launch.wait_for('stopping')
    assert launch.interrupt() == 128 + signal.SIGINT
    assert 'killing what still runs' in launch.output
    assert not left(patient)


def test_killed_sweep_leaves_no_process_and_resumes(patient: User) -> None:
    launch = begun(patient)
    launch.process.kill()
    launch.end()
    wait_until(lambda: not left(patient))
    patient.write('go-all', '')
    words = ['sim.yaml', 'seed:=1..4', '--jobs', '2', '--results', 'r']
    output = sweep(patient, *words)
    assert '1 of 4 runs are done; going on' in output
    assert '4 runs: 4 succeeded' in output


def test_consecutive_runs_of_a_worker_are_isolated(sim: User) -> None:
    """A process does one run after the other, each in new surroundings."""
    if reason_for_no_network():
        pytest.skip('runs share /dev/shm here')
    sim.write('sim.sh', 'ls /dev/shm; echo $PPID > by-$1; touch /dev/shm/$1')
    sweep(sim, 'sim.yaml', 'seed:=1..6', '--jobs', '1', '--results', 'r')
    workers = {path.read_text() for path in sim.root.glob('by-*')}
    assert len(workers) < 6
    for number in range(1, 7):
        run = sim.root / 'r' / 'runs' / f'000{number}'
        assert not (run / 'sim-1' / 'stdout.log').read_text()


def test_killed_worker_is_an_error_of_its_run(patient: User) -> None:
    for seed in '1234':
        patient.write(f'go-{seed}', '')
    # there are two workers, and the one that has this run had others
    words = ['sim.yaml', 'seed:=1..5', '--jobs', '1', '--results', 'r']
    launch = patient.start('colcon', 'sweep', *words)
    wait_until((patient.root / 'begun-5').exists)
    kill_children(launch)
    patient.write('go-all', '')
    assert launch.end() == 1
    reason = 'the process that launched it was killed'
    assert f'run 5, seed:=5: {reason}' in launch.output
    wait_until(lambda: not left(patient))


def kill_children(launch: Launch) -> None:
    """Kill all workers of a sweep."""
    pid = launch.process.pid
    children = Path(f'/proc/{pid}/task/{pid}/children').read_text()
    for child in children.split():
        os.kill(int(child), signal.SIGKILL)


def test_terminal_shows_one_line_and_ctrl_c_stops(patient: User) -> None:
    words = ['sim.yaml', 'seed:=1..4', '--jobs', '2', '--results', 'r']
    environment = {**patient.environment, 'TERM': 'xterm'}
    terminal = Terminal(
        ['colcon', 'sweep', *words], patient.root, environment, 100
    )
    try:
        terminal.shows('\r\x1b[K0 of 4 done · 2 running')
        # the keys of the terminal are for the sweep alone
        terminal.types('\x03').shows('stopping 2 runs')
        terminal.shows('the same command goes on')
        assert terminal.ends() == 130
    finally:
        terminal.close()


def test_packages_are_built_once_when_needed(user: User) -> None:
    """One that only some runs need is built when they come."""
    user.package('one')
    user.package('two')
    user.write(
        'src/one/launch/sim.yaml',
        """\
launch:
  - arg: {name: which, default: one}
  - include: {file: "$(find-pkg-share $(var which))/launch/\
$(var which).yaml"}
""",
    )
    words = ['one', 'sim.yaml', 'which:=one,two', '--repeat', '2']
    output = sweep(user, *words)
    assert output.count('Starting >>> one') == 1
    assert output.count('Starting >>> two') == 1
    assert '4 runs: 4 succeeded' in output
    (folder,) = (user.root / 'log' / 'sweeps').iterdir()
    log = (folder / 'runs' / '0004' / 'launch.log').read_text()
    assert 'hello from two' in log
    # that runs use other packages makes no other version
    assert 'versions' not in output
    assert 'Starting' not in sweep(user, *words, '--again', 'all')


def test_a_run_that_cannot_be_planned(user: User) -> None:
    user.write(
        'a.yaml',
        """\
launch:
  - arg: {name: file}
  - include: {file: $(dirname)/$(var file)}
""",
    )
    user.write('b.yaml', 'launch:\n  - executable: {cmd: echo hello}\n')
    output = sweep(
        user, 'a.yaml', 'file:=b.yaml,c.yaml', '--results', 'r', code=1
    )
    assert '2 runs: 1 succeeded, 1 had an error' in output
    (row,) = [r for r in rows(user.root / 'r') if r['outcome'] == 'error']
    assert 'c.yaml' in row['reason']
    said = (user.root / 'r' / 'runs' / '0002' / 'messages.log').read_text()
    assert 'a.yaml:3' in said


def test_a_table_of_runs(sim: User) -> None:
    sim.write('runs.csv', 'seed,world\n3,lab\n3,street\n')
    words = ['sim.yaml', '--table', 'runs.csv', '--results', 'r']
    sweep(sim, *words, code=1)
    assert [r['outcome'] for r in rows(sim.root / 'r')] == [
        *('succeeded', 'failed')
    ]


def test_jobs_are_limited_to_domains_without_networks(user: User) -> None:
    user.write('a.yaml', 'launch:\n  - executable: {cmd: echo hello}\n')
    # root of a user namespace may say how many networks there may be in it
    script = (
        'echo 0 > /proc/sys/user/max_net_namespaces && '
        'exec colcon sweep a.yaml --jobs 150'
    )
    namespace = ['unshare', '--user', '--map-root-user']
    if shutil.which('unshare') is None or subprocess.call(
        [*namespace, 'true'], stderr=subprocess.DEVNULL
    ):
        pytest.skip('unshare cannot make a user namespace here')
    launch = user.start(*namespace, 'sh', '-c', script)
    assert launch.end() == 0, launch.output
    assert re.search(
        r'--jobs is limited to 11[89], as none can have a network of its own '
        r'here \(the limits of the system, /proc/sys/user, allow no more\), '
        'and each needs a ROS_DOMAIN_ID of its own',
        launch.output,
    )
