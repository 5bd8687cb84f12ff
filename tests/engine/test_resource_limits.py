# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Limits of processes: what can be set here, and how."""

import errno
import os
from pathlib import Path
import signal
import subprocess
import sys

from colcon_yamllaunch.common.process_scan import cgroup_of
from colcon_yamllaunch.engine import cgroup, limit_groups
from colcon_yamllaunch.engine.cgroup import LaunchCgroup
from colcon_yamllaunch.engine.launch_scan import new_identity
from colcon_yamllaunch.engine.limit_groups import (
    adapted,
    exceeded,
    group_support,
    GroupSupport,
    limit_files,
)
from colcon_yamllaunch.engine.limited_spawn import (
    available_cpus,
    LimitedSpawn,
    Restrictions,
    tried,
)
from colcon_yamllaunch.engine.own_files import ParameterFiles
from colcon_yamllaunch.engine.resource_limits import problems_of
from colcon_yamllaunch.engine.spawn import spawn_process, StartError
from colcon_yamllaunch.plan.member_settings import (
    MemberSettings,
    ResourceLimits,
    Scheduling,
    SettingPlace,
)
from colcon_yamllaunch.plan.plan import ParameterFile, Process
from colcon_yamllaunch.plan.position import Position
import pytest
from support.hostile import needs_other_user, OTHER_USER

AT = Position('robot.yaml', 3, 5)
MIB = 1 << 20
CPU = min(os.sched_getaffinity(0))
#: Prints its priority, processors, score, group and limit of memory.
SHOWS = (
    'import os, resource\n'
    'print(os.nice(0), *os.sched_getaffinity(0), '
    'open("/proc/self/oom_score_adj").read().strip(), '
    'os.getpgid(0) == os.getpid(), '
    'resource.getrlimit(resource.RLIMIT_DATA)[0])'
)
needs_limit_groups = pytest.mark.skipif(
    'memory' not in group_support(os.environ).controllers,
    reason='no control group with limits can be made here',
)


def process(limits=None, user='', places=(), label='camera'):
    settings = MemberSettings(AT, limits=limits, user=user, places=places)
    return Process(label, ('true',), '/', AT, name=label, settings=settings)


def explained(problem):
    return StartError(f'{problem[0]}: {os.strerror(problem[1])}')


def output_of(restrictions, *argv):
    """Return what a program prints that starts with restrictions."""
    reader, writer = os.pipe()
    null = os.open(os.devnull, os.O_RDONLY)
    pid = None
    try:
        pid = spawn_process(
            argv,
            {'PATH': os.defpath},
            '/',
            (null, writer, 2),
            LimitedSpawn(restrictions, explained),
        )
    finally:
        os.close(writer)
        os.close(null)
        with open(reader) as file:
            text = file.read()
    os.waitpid(pid, 0)
    return text


def test_limits_become_files_of_enabled_controllers():
    limits = ResourceLimits(
        200 * MIB, 100 * MIB, cpu=1.5, cpus=(0, 2), io=50, tasks=10
    )
    assert limit_files(limits, ('memory', 'cpu', 'cpuset', 'io', 'pids')) == {
        'memory.max': '209715200',
        'memory.oom.group': '1',
        'memory.high': '104857600',
        'cpu.max': '150000 100000',
        'cpuset.cpus': '0,2',
        'io.weight': '50',
        'pids.max': '10',
    }
    assert limit_files(limits, ('pids',)) == {'pids.max': '10'}
    assert limit_files(ResourceLimits(nice=5), ('memory',)) == {}


def test_weight_and_swap_are_those_that_the_group_has(tmp_path):
    files = {'io.weight': '50', 'memory.max': '10'}
    assert adapted(str(tmp_path), files) == files
    for name in ('io.bfq.weight', 'memory.swap.max'):
        (tmp_path / name).touch()
    assert adapted(str(tmp_path), files) == {
        'io.bfq.weight': '50',
        'memory.max': '10',
        'memory.swap.max': '0',
    }


def test_killed_process_names_its_limit_and_peak(tmp_path):
    limits = ResourceLimits(memory=2 << 30)
    folder = str(tmp_path)
    assert exceeded(folder, limits, killed=True) == ''
    events = tmp_path / 'memory.events'
    events.write_text('low 0\nmax 5\noom 1\noom_kill 1\n')
    assert exceeded(folder, limits, killed=False) == ''
    assert exceeded(folder, limits, killed=True) == 'over its 2 GiB limit'
    (tmp_path / 'memory.peak').write_text(f'{2150 * MIB}\n')
    assert exceeded(folder, limits, killed=True) == (
        'over its 2 GiB limit, peak 2.1 GiB'
    )
    events.write_text('oom 0\noom_kill 1\n')
    assert exceeded(folder, limits, killed=True) == (
        'the system ran out of memory, peak 2.1 GiB'
    )


def test_process_at_its_limit_of_tasks_is_noticed(tmp_path):
    (tmp_path / 'pids.events').write_text('max 3\n')
    limits = ResourceLimits(tasks=20)
    found = exceeded(str(tmp_path), limits, killed=False)
    assert found == 'at its limit of 20 tasks'


@pytest.mark.parametrize(
    ('has_systemd', 'user', 'controllers', 'hint'),
    [
        (False, 1000, (), 'docker run --privileged --cgroupns=private'),
        (True, 1000, (), 'Delegate=cpu cpuset io memory pids'),
        (True, 1000, ('cpu',), 'systemd-run --user --scope -p Delegate=yes'),
        (True, 0, (), 'systemd-run --scope -p Delegate=yes'),
    ],
)
def test_hint_gets_the_system_to_delegate_a_controller(
    monkeypatch, tmp_path, has_systemd, user, controllers, hint
):
    systemd = tmp_path if has_systemd else tmp_path / 'none'
    monkeypatch.setattr(limit_groups, '_SYSTEMD', str(systemd))
    monkeypatch.setattr(limit_groups, '_mounted_in_version_1', set)
    monkeypatch.setattr(limit_groups, '_controllers', lambda _: controllers)
    monkeypatch.setattr(os, 'geteuid', lambda: user)
    assert hint in GroupSupport().hint('cpu')


def test_switched_off_groups_are_named():
    support = group_support({cgroup.CGROUP_VARIABLE: '0'})
    assert support.problem('cpu') == (
        'COLCON_LAUNCH_CGROUP=0 switches control groups off'
    )
    assert support.hint('cpu') == 'unset this variable'


def test_missing_controller_is_named():
    support = GroupSupport('/group', frozenset({'memory'}))
    assert support.problem('memory') is None
    assert "lacks the controller 'cpu'" in support.problem('cpu')


def test_limits_without_group_are_problems_with_their_places():
    limits = ResourceLimits(MIB, cpu=0.5, tasks=5, cpus=(1000,))
    places = (
        SettingPlace('cpu', Position('robot.yaml', 9, 1)),
        SettingPlace('cpus', Position('robot.yaml', 7, 1)),
        SettingPlace('tasks', Position('robot.yaml', 8, 1)),
    )
    one = process(limits, places=places)
    other = process(limits, places=places, label='other')
    found = problems_of([one, other], {cgroup.CGROUP_VARIABLE: '0'})
    # memory can be limited without one
    assert [(p.key, p.position.line) for p in found] == [
        ('cpus', 7),
        ('tasks', 8),
        ('cpu', 9),
    ]
    assert found[0].problem == 'the launch has no processor 1000'
    assert str(CPU) in found[0].hint
    assert {p.label for p in found} == {'camera'}


def test_unknown_user_is_a_problem_with_a_suggestion():
    (found,) = problems_of([process(user='nobdy')], {})
    assert found.problem == "there is no user 'nobdy'"
    assert found.hint == "did you mean 'nobody'?"


def test_deadline_with_cpus_is_a_problem():
    deadline = Scheduling('deadline', runtime=0.01, deadline=0.02, period=0.03)
    limits = ResourceLimits(scheduling=deadline, cpus=(CPU,))
    (found,) = problems_of([process(limits)], {})
    assert 'exclude one another' in found.problem


@pytest.mark.skipif(os.geteuid() == 0, reason='root may do all of that')
def test_ordinary_user_is_refused_before_the_start():
    fifo = Scheduling('fifo', priority=50)
    limits = ResourceLimits(nice=-5, oom=-900, scheduling=fifo)
    assert dict(tried(Restrictions(limits, 'root'))) == {
        'nice': errno.EACCES,
        'oom': errno.EACCES,
        'scheduling': errno.EPERM,
        'user': errno.EPERM,
    }
    found = {p.key: p for p in problems_of([process(limits, 'root')], {})}
    assert ' - nice -5' in found['nice'].hint
    assert 'CAP_SYS_NICE' in found['nice'].hint
    assert ' - rtprio 50' in found['scheduling'].hint
    assert 'CAP_SYS_RESOURCE' in found['oom'].hint
    assert found['user'].problem.startswith('only root may start')


def test_trying_limits_changes_nothing_of_this_process():
    before = os.sched_getaffinity(0), os.nice(0)
    limits = ResourceLimits(nice=19, oom=1000, cpus=(CPU,))
    assert tried(Restrictions(limits)) == []
    assert available_cpus() >= before[0]
    assert (os.sched_getaffinity(0), os.nice(0)) == before


def test_program_starts_with_its_limits():
    limits = ResourceLimits(300 * MIB, nice=7, oom=400, cpus=(CPU,))
    shown = output_of(Restrictions(limits), sys.executable, '-c', SHOWS)
    assert shown == f'7 {CPU} 400 True -1\n'
    own = Restrictions(limits, is_memory_own=True)
    shown = output_of(own, sys.executable, '-c', SHOWS)
    assert shown == f'7 {CPU} 400 True {300 * MIB}\n'


def test_program_may_have_less_memory_than_this_process():
    limits = ResourceLimits(memory=8 * MIB)
    shown = output_of(
        Restrictions(limits, is_memory_own=True), 'sh', '-c', 'ulimit -d'
    )
    assert shown == f'{8 * 1024}\n'


def test_program_has_no_signal_blocked_or_ignored():
    before = signal.signal(signal.SIGUSR1, signal.SIG_IGN)
    try:
        shown = output_of(
            Restrictions(ResourceLimits(nice=1)),
            'grep',
            '-E',
            'SigBlk|SigIgn',
            '/proc/self/status',
        )
    finally:
        signal.signal(signal.SIGUSR1, before)
    masks = [int(line.split()[1], 16) for line in shown.splitlines()]
    # two are those of the C library, which nobody can set (signal(7))
    assert [mask & ~(0b11 << 31) for mask in masks] == [0, 0]


def test_program_that_does_not_start_is_explained():
    limits = Restrictions(ResourceLimits(nice=1))
    with pytest.raises(StartError, match='there is no file'):
        output_of(limits, '/nowhere/program')
    with pytest.raises(StartError, match='is a folder'):
        output_of(limits, '/tmp')


def test_limit_that_cannot_be_set_is_explained():
    group = Restrictions(folder='/nowhere')
    with pytest.raises(StartError, match='group: No such file'):
        output_of(group, 'true')


@needs_other_user
def test_program_runs_as_another_user():
    shown = output_of(
        Restrictions(user='nobody'),
        'sh',
        '-c',
        'id -u; echo shown > /dev/stdout; '
        'sed -n "s/CapEff:.//p; s/Groups:.//p" /proc/self/status',
    )
    user, word, group, rights = shown.split()
    assert (int(user), word, int(rights, 16)) == (OTHER_USER, 'shown', 0)
    assert int(group)


@needs_other_user
def test_user_gives_the_variables_of_a_login():
    spawn = LimitedSpawn(Restrictions(user='nobody'), explained)
    environment = {'HOME': '/root', 'USER': 'me', 'LANG': 'C'}
    spawn.complete(environment, (('USER', 'me'),))
    assert environment == {
        'HOME': spawn.user.pw_dir,
        'USER': 'me',
        'LOGNAME': 'nobody',
        'LANG': 'C',
    }


@needs_other_user
def test_program_that_the_user_may_not_execute_is_explained(tmp_path):
    program = tmp_path / 'program'
    program.write_text('#!/bin/sh\n')
    program.chmod(0o700)
    with pytest.raises(StartError, match='nobody may not execute'):
        output_of(Restrictions(user='nobody'), str(program))


@needs_other_user
def test_folder_of_another_user_is_no_log_folder(tmp_path):
    spawn = LimitedSpawn(Restrictions(user='nobody'), explained)
    pid = spawn(
        '/bin/sh',
        ['sh', '-c', 'test -z "$ROS_LOG_DIR"'],
        {'ROS_LOG_DIR': str(tmp_path)},
        file_actions=(),
        setsigdef=(),
    )
    assert os.waitpid(pid, 0)[1] == 0


@needs_other_user
def test_user_reads_only_its_own_parameter_file(monkeypatch):
    places = []
    monkeypatch.setenv('TMPDIR', '/tmp')
    files = ParameterFiles(places.append)
    argv = (ParameterFile('a: 1\n'), ParameterFile('b: 1\n'))
    one = Process('one', argv[:1], '/', AT, name='one')
    other = Process('other', argv[1:], '/', AT, name='other')
    try:
        ours, theirs = files.command_line(0, one), files.command_line(1, other)
        files.give(theirs, OTHER_USER)
        drop = ('setpriv', f'--reuid={OTHER_USER}', '--clear-groups')
        reads = [
            subprocess.run(
                [*drop, 'cat', path],
                capture_output=True,
                text=True,
                check=False,
            ).stdout
            for path in (*ours, *theirs)
        ]
        assert reads == ['', 'b: 1\n']
    finally:
        files.remove()
    assert not Path(places[0].path).exists()


@needs_limit_groups
def test_group_has_limits_and_leaves_nothing_behind():
    support = group_support(os.environ)
    control = Path(support.base, 'cgroup.subtree_control')
    before, home = control.read_text(), cgroup_of('self')
    group = LaunchCgroup(new_identity())
    try:
        group.use(support.base, {'memory'})
        folder = group.prepare(3, {'memory.max': '16777216'})
        child = subprocess.Popen(['sleep', '99'], start_new_session=True)
        Path(folder, 'cgroup.procs').write_text(str(child.pid))
        assert Path(folder, 'memory.max').read_text() == '16777216\n'
        assert Path(folder, 'memory.current').exists()
    finally:
        group.remove()
    child.wait()
    assert control.read_text() == before
    assert cgroup_of('self') == home
    assert not Path(folder).parent.exists()
