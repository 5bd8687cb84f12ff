# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Real launches whose launcher is killed: the guard takes its place."""

import os
import re
import resource
import signal

import pytest

pytestmark = pytest.mark.hostile

#: Says what it does while it stops its motors.
MOTORS = (
    'import os, signal, sys, time\n'
    'def stop(number, frame):\n'
    '    for n in range(9):\n'
    '        print("stopping motor", n, flush=True); time.sleep(0.02)\n'
    '    sys.stderr.write("stopped\\n")\n'
    '    open("stopped", "w").close()\n'
    '    sys.exit()\n'
    'signal.signal(signal.SIGINT, stop)\n'
    'print("ready", flush=True)\n'
    'while True: time.sleep(1)\n'
)


def test_a_program_that_prints_while_it_stops_gets_to_its_end(
    launch, python, wait_until, is_running
):
    one = launch(
        python('motors', MOTORS, cwd='.'),
        python('terminal', MOTORS, cwd='.', emulate_tty=True),
    )
    one.shows('[motors]   ready').shows('[terminal] ready')
    (guard,) = wait_until(one.guards)
    one.sends(signal.SIGKILL)
    one.popen.wait()
    wait_until(lambda: not is_running(guard))
    assert (one.folder / 'stopped').exists()
    lines = b''.join(b'stopping motor %d\n' % n for n in range(9))
    for label in ('motors', 'terminal'):
        assert one.log(f'{label}/stdout.log') == b'ready\n' + lines
        assert one.log(f'{label}/stderr.log') == b'stopped\n'
        both = one.log(f'{label}/stdout_stderr.log')
        assert both == b'ready\n' + lines + b'stopped\n'
        common = one.log('launch.log').decode()
        for line in ('stopping motor 8', 'stopped'):
            assert re.search(rf'^\d+\.\d+ \[{label}\] {line}$', common, re.M)
    assert b'[launch] the launcher was killed' in one.log('launch.log')


def test_another_guard_has_the_outputs_too(
    launch, python, wait_until, is_running
):
    one = launch(python('motors', MOTORS, cwd='.')).shows('ready')
    (first,) = wait_until(one.guards)
    os.kill(first, signal.SIGKILL)
    (second,) = wait_until(lambda: set(one.guards()) - {first})
    # until it has taken what it was told
    wait_until(lambda: len(os.listdir(f'/proc/{second}/fd')) >= 5)
    one.sends(signal.SIGKILL)
    one.popen.wait()
    wait_until(lambda: not is_running(second))
    assert one.log('motors/stderr.log') == b'stopped\n'


def test_a_guard_with_few_open_files_has_all_outputs(
    launch, python, sleep, wait_until, is_running
):
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    one = launch(
        *(sleep(f'p{n}') for n in range(40)),
        python('motors', MOTORS, cwd='.'),
        popen={
            'preexec_fn': lambda: resource.setrlimit(
                resource.RLIMIT_NOFILE, (32, hard)
            )
        },
    )
    one.shows('ready')
    (guard,) = wait_until(one.guards)
    wait_until(lambda: len(os.listdir(f'/proc/{guard}/fd')) >= 85)
    one.sends(signal.SIGKILL)
    one.popen.wait()
    wait_until(lambda: not is_running(guard))
    assert one.log('motors/stderr.log') == b'stopped\n'


def test_who_writes_for_an_ended_process_gets_no_answer_but_an_error(
    launch, sh, sleep, wait_until, is_running
):
    # it has closed its output, so nobody reads that from then on
    one = launch(sh('a', 'exec >&- 2>&-; exec sleep 99'), sleep('b')).shows(
        'b: started'
    )
    (guard,) = wait_until(one.guards)
    # the socket, two outputs of b, /dev/null twice
    wait_until(lambda: len(os.listdir(f'/proc/{guard}/fd')) == 5)
    assert one.sends(signal.SIGINT).ends() == 0


def test_a_folder_of_others_is_left_alone_whatever_it_is_called(
    launch, wait_until, is_running, tmp_path
):
    precious = tmp_path / 'precious'
    precious.mkdir()
    (precious / 'file').touch()
    place = tmp_path / f'x\nfolder {precious}\nz'
    place.mkdir(parents=True)
    one = launch(
        {
            'label': 'a',
            'argv': ['sh', '-c', 'echo "path $0"; sleep 99', {'content': ''}],
            'cwd': '/',
        },
        environment={'TMPDIR': str(place)},
    ).shows('path ')
    (folder,) = place.glob('colcon_launch_*')
    (folder / 'foreign.txt').touch()
    (guard,) = wait_until(one.guards)
    one.sends(signal.SIGKILL)
    one.popen.wait()
    wait_until(lambda: not is_running(guard))
    assert (precious / 'file').exists()
    # what the launcher has not made stays, and nothing else
    assert os.listdir(folder) == ['foreign.txt']
