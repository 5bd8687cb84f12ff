# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Output of real processes: complete, in time, and harmless."""

import os
import resource
import signal
import subprocess

import pytest


def test_print_shows_at_once(launch, python):
    one = launch(python('a', 'print("now"); import time; time.sleep(99)'))
    one.shows('[a]      now')


def test_a_quiet_process_has_its_log_files_while_it_runs(
    launch, sleep, wait_until
):
    one = launch(sleep('a')).shows('a: started')
    wait_until(lambda: (one.log_folder / 'a/stdout_stderr.log').exists())
    assert (one.log_folder / 'a/stdout.log').exists()


@pytest.fixture(scope='module')
def written(launch_type, tmp_path_factory):
    """Return a launch that has ended, and what `binary` wrote in it."""
    folder = tmp_path_factory.mktemp('written')
    data = os.urandom(500_000)
    (folder / 'data').write_bytes(data)
    scripts = {
        'part': 'printf partial; printf error >&2',
        'bytes': r"printf 'a\377b\n'",
        'bar': r"printf ' 10%%\r 20%%\r\n'",
        'binary': f'cat {folder}/data',
    }
    entries = [
        {'label': label, 'argv': ['sh', '-c', script]}
        for label, script in scripts.items()
    ]
    one = launch_type(folder / 'launch', entries)
    assert one.ends() == 0
    return one, data


def test_partial_last_lines_are_shown(written):
    one, _ = written
    assert '[part]   partial\n' in one.screen
    assert '[part]   error\n' in one.screen
    assert one.log('part/stdout.log') == b'partial'


def test_invalid_bytes_are_replaced_on_the_screen_only(written):
    one, _ = written
    assert '[bytes]  a\ufffdb\n' in one.screen
    assert one.log('bytes/stdout.log') == b'a\xffb\n'


def test_a_progress_display_is_shown_line_by_line(written):
    one, _ = written
    assert '[bar]     10%\n[bar]     20%\n' in one.screen
    assert one.log('bar/stdout.log') == b' 10%\r 20%\r\n'


def test_binary_output_is_kept_exactly(written):
    one, data = written
    assert one.log('binary/stdout.log') == data
    assert one.log('binary/stdout_stderr.log') == data


@pytest.mark.full
def test_a_line_of_ten_megabytes_goes_through(launch, sh):
    one = launch(sh('a', "head -c 10000000 /dev/zero | tr '\\0' x; echo"))
    assert one.ends() == 0
    assert '[a]      ' + 'x' * 10_000_000 + '\n' in one.screen
    assert one.log('a/stdout.log') == b'x' * 10_000_000 + b'\n'


def test_a_terminal_is_emulated_where_it_is_asked_for(launch, python):
    script = (
        'import os, sys\n'
        'print([os.isatty(n) for n in (0, 1, 2)])\n'
        'print(os.get_terminal_size(1).columns)\n'
        'os.write(2, b"partial")\n'
    )
    one = launch(
        python('tty', script, emulate_tty=True),
        python('pipe', 'import os; print(os.isatty(1))'),
    )
    assert one.ends() == 0
    assert '[tty]    [True, True, True]\n' in one.screen
    assert '[tty]    80\n' in one.screen
    assert '[tty]    partial\n' in one.screen
    assert '[pipe]   False\n' in one.screen
    assert one.log('tty/stdout.log') == b'[True, True, True]\n80\n'


def test_a_terminal_loses_nothing_at_its_end(launch, sh):
    one = launch(sh('tty', 'seq 1 50000', emulate_tty=True, output='own_log'))
    assert one.ends() == 0
    expected = ''.join(f'{n}\n' for n in range(1, 50001)).encode()
    assert one.log('tty/stdout.log') == expected


@pytest.mark.parametrize(
    'number',
    [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.full)],
)
def test_what_was_written_before_a_stop_is_logged(launch, python, number):
    script = (
        'import os, signal, time\n'
        'def stop(*_):\n'
        '    os.write(1, b"last words\\n" * 4000)\n'
        '    os._exit(0)\n'
        'signal.signal(signal.SIGINT, stop)\n'
        'print("ready", flush=True)\n'
        'while True: time.sleep(1)\n'
    )
    one = launch(python('a', script)).shows('ready')
    assert one.sends(number).ends() == 0
    assert one.log('a/stdout.log') == b'ready\n' + b'last words\n' * 4000


def test_what_was_written_before_we_killed_is_logged(launch, python, tmp_path):
    script = (
        'import os, signal\n'
        'for number in (signal.SIGINT, signal.SIGTERM):\n'
        '    signal.signal(number, signal.SIG_IGN)\n'
        'written = os.open("written", os.O_WRONLY | os.O_CREAT)\n'
        'os.write(2, b"ready\\n")\n'
        'count = 0\n'
        'while True:\n'
        '    count += 1\n'
        '    os.write(1, b"%d\\n" % count)\n'
        '    os.pwrite(written, b"%9d" % count, 0)\n'
    )
    one = launch(
        python(
            'a',
            script,
            cwd=str(tmp_path),
            output='log',
            sigterm_timeout=0.1,
            sigkill_timeout=0.1,
        )
    )
    assert one.shows('ready').sends(signal.SIGINT).ends() == 0
    assert one.events('exited')[0]['signal'] == 'SIGKILL'
    logged = one.log('a/stdout.log').split()
    assert logged == [b'%d' % n for n in range(1, len(logged) + 1)]
    assert len(logged) >= int((tmp_path / 'written').read_bytes())


@pytest.mark.hostile
def test_what_the_launcher_read_outlives_it(launch, sh, wait_until):
    script = "head -c 36000 /dev/zero | tr '\\0' x; sleep 99"
    one = launch(sh('a', script), sh('b', 'echo b; sleep 99'))
    logs = [one.log_folder / f'a/{n}.log' for n in ('stdout', 'stdout_stderr')]
    wait_until(lambda: all(p.exists() for p in logs))
    wait_until(lambda: all(p.stat().st_size == 36_000 for p in logs))
    one.sends(signal.SIGKILL).popen.wait()
    assert one.log('a/stdout.log') == b'x' * 36_000
    assert 'xxx' not in one.screen
    wait_until(lambda: not one.processes())


def test_what_was_written_before_a_kill_is_logged(launch, sh):
    one = launch(sh('a', 'seq 1 9000; kill -KILL $$'))
    assert one.ends() == 1
    assert one.log('a/stdout.log').endswith(b'\n9000\n')


def test_a_child_that_keeps_the_pipe_open_does_not_hold_up_the_end(launch, sh):
    one = launch(
        sh(
            'a',
            "trap '' INT; (trap 'exit 0' TERM; while :; do "
            'echo child; sleep 0.1; done) & echo parent; exit 0',
            sigterm_timeout=0.2,
        )
    )
    assert one.ends() == 0
    assert '[a]      parent' in one.screen
    assert 'a: finished' in one.screen
    assert b'child' in one.log('a/stdout.log')
    assert one.processes() == []


def test_output_modes(launch, sh):
    script = 'echo out; echo err >&2'
    modes = ('screen', 'log', 'both', 'own_log', 'full')
    one = launch(*(sh(m, script, output=m) for m in modes))
    assert one.ends() == 0
    lines = one.screen.splitlines()
    shown = {
        mode: sorted(
            line.split()[1] for line in lines if line.startswith(f'[{mode}]')
        )
        for mode in modes
    }
    assert shown == {
        'screen': ['err', 'out'],
        'log': ['err'],
        'both': ['err', 'out'],
        'own_log': [],
        'full': ['err', 'out'],
    }
    assert not (one.log_folder / 'screen').exists()
    for mode in modes[1:]:
        assert one.log(f'{mode}/stdout.log') == b'out\n'
        assert one.log(f'{mode}/stderr.log') == b'err\n'


@pytest.fixture
def pipe():
    """Give a pipe, of which the test may close an end."""
    reader, writer = os.pipe()
    ends = {'reader': reader, 'writer': writer}
    yield ends
    for descriptor in ends.values():
        os.close(descriptor)


@pytest.mark.full
def test_a_slow_reader_slows_the_flood_but_not_the_others(
    launch, sh, pipe, wait_until
):
    one = launch(
        sh('flood', 'yes', output='screen'),
        sh('quiet', 'for n in 1 2 3 4 5; do echo tick; sleep 0.1; done'),
        popen={'stdout': pipe['writer']},
    )
    os.close(pipe.pop('writer'))

    def ticks():
        path = one.log_folder / 'quiet/stdout.log'
        return path.exists() and path.read_bytes().count(b'tick') == 5

    # nobody reads the screen, yet the other process goes on
    wait_until(ticks)
    memory = _memory_kib(one.popen.pid)
    assert memory < 100_000
    one.sends(signal.SIGINT)
    _read_to_end(pipe['reader'])
    assert one.ends() == 0


@pytest.mark.full
@pytest.mark.hostile
def test_many_long_lines_together_take_little_memory(launch, sh, wait_until):
    size = 4_000_000
    script = f"head -c {size} /dev/zero | tr '\\0' x; sleep 99"
    one = launch(*(sh(f'p{n}', script) for n in range(40)))
    logs = [one.log_folder / f'p{n}/stdout.log' for n in range(40)]
    wait_until(
        lambda: all(p.exists() and p.stat().st_size == size for p in logs)
    )
    # the launcher has 20 MiB without a process
    assert _memory_kib(one.popen.pid, 'VmHWM') < 100_000
    assert one.sends(signal.SIGINT).ends() == 0


@pytest.mark.full
def test_a_screen_that_nobody_reads_does_not_hold_up_a_stop(
    launch, sh, pipe, wait_until
):
    one = launch(
        sh('flood', 'yes', output='screen'),
        popen={'stdout': pipe['writer']},
    )
    wait_until(one.processes)
    one.sends(signal.SIGTERM)
    assert one.ends() == 0
    assert one.processes() == []


def test_the_end_of_the_reader_stops_the_launch(launch, sh, pipe):
    one = launch(
        sh('a', 'while echo x; do sleep 0.05; done'),
        popen={'stdout': pipe['writer'], 'stderr': subprocess.PIPE},
    )
    os.close(pipe.pop('writer'))
    assert os.read(pipe['reader'], 10)
    os.close(pipe.pop('reader'))
    assert one.popen.communicate(timeout=60)[1] == b''
    assert one.ends() == 0
    assert one.processes() == []


def test_the_end_of_the_reader_is_noticed_when_all_is_quiet(
    launch, sleep, pipe
):
    one = launch(sleep('a'), popen={'stdout': pipe['writer']})
    os.close(pipe.pop('writer'))
    shown = b''
    while b'a: started' not in shown:
        shown += os.read(pipe['reader'], 1000)
    os.close(pipe.pop('reader'))
    assert one.ends() == 0
    assert one.processes() == []


@pytest.mark.hostile
def test_output_that_cannot_be_written_is_an_error(launch, sh, tmp_path):
    with (
        open('/dev/full', 'wb', buffering=0) as full,
        open(tmp_path / 'errors', 'wb') as errors,
    ):
        one = launch(
            sh('a', 'echo hello'), popen={'stdout': full, 'stderr': errors}
        )
        assert one.ends() == 1
    assert (tmp_path / 'errors').read_text() == (
        'error: the output cannot be written: No space left on device\n'
    )
    # and the logs know it, too
    assert one.log('a/stdout.log') == b'hello\n'
    assert one.events('ended')[0]['exit_code'] == 1


def test_everything_reaches_a_slow_reader_in_the_end(launch, sh, pipe):
    one = launch(
        sh('a', 'seq 1 100000', output='screen'),
        popen={'stdout': pipe['writer']},
    )
    os.close(pipe.pop('writer'))

    assert _read_to_end(pipe['reader']).count(b'[a] ') == 100_000
    assert one.ends() == 0


def test_a_log_that_cannot_grow_does_not_hold_up_the_output(launch, sh, pipe):
    # the system reports the limit much as it does a full disk
    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))

    one = launch(
        sh('a', 'seq 1 20000'),
        popen={'stdout': pipe['writer'], 'preexec_fn': limit},
    )
    os.close(pipe.pop('writer'))
    shown = _read_to_end(pipe['reader'])
    assert one.ends() == 0
    assert shown.count(b'[a] ') == 20_000
    assert shown.count(b'cannot be written') == 1
    assert (
        one.log('a/stdout.log')
        == (''.join(f'{n}\n' for n in range(1, 2000)).encode()[:4096])
    )


def test_logs_keep_to_their_limit_and_have_the_newest(launch, sh):
    one = launch(sh('a', 'seq 1 300000', output='own_log'), log_limit=10**6)
    assert one.ends() == 0
    assert one.screen.count('limit of 1 MB') == 1
    files = [p for p in one.log_folder.rglob('*') if p.is_file()]
    assert sum(p.stat().st_size for p in files) <= 10**6
    newest = sorted(
        (one.log_folder / 'a').glob('stdout.log*'),
        key=lambda p: int(p.suffix[1:]) if p.suffix != '.log' else 0,
        reverse=True,
    )
    kept = b''.join(p.read_bytes() for p in newest).split()
    assert len(kept) > 20_000
    first = 300_001 - len(kept)
    assert kept == [b'%d' % n for n in range(first, 300_001)]


def test_logs_below_their_limit_are_complete(launch, sh):
    one = launch(
        sh('a', 'seq 1 150000', output='own_log'), log_limit=4 * 10**6
    )
    assert one.ends() == 0
    assert 'limit' not in one.screen
    parts = sorted((one.log_folder / 'a').glob('stdout.log.*'))
    parts.sort(key=lambda p: -int(p.suffix[1:]))
    kept = b''.join(
        p.read_bytes() for p in (*parts, one.log_folder / 'a/stdout.log')
    )
    assert parts
    assert kept.split() == [b'%d' % n for n in range(1, 150_001)]


def test_formats_are_those_of_the_environment(launch, sh):
    one = launch(
        {'kind': 'message', 'level': 'WARNING', 'text': 'careful'},
        sh('a', 'echo hello'),
        environment={
            'OVERRIDE_LAUNCH_SCREEN_FORMAT': '{levelname}|{name}|{message}',
            'OVERRIDE_LAUNCH_LOG_FORMAT': '{name}>{message}',
        },
    )
    assert one.ends() == 0
    assert 'WARNING|launch.user|careful\n' in one.screen
    assert 'INFO|launch|a: started, pid ' in one.screen
    assert '[a]      hello\n' in one.screen
    lines = one.log('launch.log').decode().splitlines()
    assert 'launch.user>careful' in lines
    assert any(line.startswith('launch>a: started') for line in lines)
    assert any(line.endswith(' [a] hello') for line in lines)


def test_a_malformed_format_is_said_once_and_the_launch_goes_on(launch, sh):
    one = launch(
        sh('a', 'echo hello'),
        environment={'OVERRIDE_LAUNCH_LOG_FORMAT': '{nonsense}'},
    )
    assert one.ends() == 0
    assert one.screen.count('OVERRIDE_LAUNCH_LOG_FORMAT is ignored') == 1
    assert '[launch] a: started' in one.log('launch.log').decode()


def _memory_kib(pid, kind='VmRSS'):
    with open(f'/proc/{pid}/status') as file:
        return int(file.read().partition(f'{kind}:')[2].split()[0])


def _read_to_end(descriptor):
    return b''.join(iter(lambda: os.read(descriptor, 65536), b''))
