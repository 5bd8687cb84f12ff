# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A machine of namespaces is one: its processes, its network, its end."""

import subprocess

from support.namespaces import NamespaceMachine


def test_it_has_processes_of_its_own(namespace: NamespaceMachine) -> None:
    done = namespace.run('sh', '-c', 'cd ~; pwd; echo /proc/[0-9]*')
    home, processes = done.stdout.splitlines()
    assert home == str(namespace.home)
    assert processes.startswith('/proc/1 ')
    assert len(processes.split()) < 6


def test_all_of_it_ends_at_once(namespace: NamespaceMachine) -> None:
    with subprocess.Popen(
        [namespace.enter, 'sh', '-c', 'sleep 1000 & echo up; read line'],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    ) as entered:
        assert entered.stdout is not None
        assert entered.stdout.readline() == b'up\n'
        # the shell may just be about to become it
        while 'sleep 1000' not in namespace.left():
            assert entered.poll() is None
        namespace.reboot()
        assert entered.wait() != 0
    assert namespace.left() == []
    assert namespace.run('echo', 'again').stdout == 'again\n'
    namespace.power_off()
    assert 'does not run' in namespace.run('true').stderr


def test_a_killed_command_leaves_what_it_started(
    namespace: NamespaceMachine,
) -> None:
    with subprocess.Popen(
        [namespace.enter, 'sh', '-c', 'echo up; sleep 1000'],
        stdout=subprocess.PIPE,
    ) as entered:
        assert entered.stdout is not None
        assert entered.stdout.readline() == b'up\n'
        entered.kill()
    assert namespace.left() != []
