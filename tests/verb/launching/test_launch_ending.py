# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A launch that ends by itself, as in CI."""

from pathlib import Path
import signal
import time
from xml.etree import ElementTree

import pytest
from support.user import BLOCKING, User

TALKER = """\
launch:
  - executable: {cmd: sh talk.sh, name: talker}
  - executable: {cmd: sleep 1000, name: sleeper}
  - timer:
      period: 1000
      children:
        - executable: {cmd: echo late, name: late}
"""
TALK = """\
echo starting
printf 'the \\033[1mvalue\\033[0m is 8\\n'
sleep 1000
"""


@pytest.fixture
def talker(user: User) -> User:
    """Return a user with a launch that talks and goes on."""
    user.write('talk.sh', TALK)
    user.write('a.yaml', TALKER)
    return user


def cases(report: Path) -> dict[str, list[str]]:
    """Return the outcomes of each case of a JUnit report by its name."""
    root = ElementTree.parse(report).getroot()
    return {
        case.get('name') or '': [outcome.tag for outcome in case]
        for case in root.iter('testcase')
    }


def test_until_a_line_is_seen(talker: User) -> None:
    output = talker.launch('a.yaml', '--until', r'value is \d$')
    assert r"stopping: 'value is \d$' was seen" in output


def test_until_all_lines_are_seen_in_vain(talker: User) -> None:
    words = ['--until', 'starting', '--until', 'x:=3', '--timeout', '2.5']
    output = talker.launch('a.yaml', *words, code=1)
    assert output.rstrip().endswith(
        "failed: 'x:=3' was not seen in 2.5 s (--until)"
    )
    assert "'starting' was not" not in output


def test_output_that_is_only_logged_counts(talker: User) -> None:
    text = TALKER.replace('talk.sh,', 'talk.sh, output: own_log,')
    talker.write('a.yaml', text)
    output = talker.launch('--until', 'value is 8', 'a.yaml')
    assert 'value is 8\n' not in output


def test_the_last_line_counts_before_the_exit_code(user: User) -> None:
    user.write('a.yaml', 'launch: [executable: {cmd: sh end.sh}]')
    user.write('end.sh', 'echo all is well; exit 3')
    for _ in range(5):
        user.launch('a.yaml', '--until', 'well')


def test_a_crash_after_success_is_a_failure(user: User) -> None:
    user.write('a.yaml', 'launch: [executable: {cmd: sh end.sh}]')
    user.write('end.sh', "trap '' INT; echo all is well; kill -SEGV $$")
    output = user.launch('a.yaml', '--until', 'well', code=1)
    assert 'SIGSEGV' in output


def test_a_failure_ends_the_wait(talker: User) -> None:
    talker.write('talk.sh', 'exit 3')
    output = talker.launch('a.yaml', '--until', 'ready', code=1)
    assert 'failed: talker-1 exited with code 3' in output
    assert "failed: 'ready' was not seen before the launch ended" in output


def test_a_launch_that_ends_too_soon(user: User) -> None:
    user.write('a.yaml', 'launch: [executable: {cmd: echo hello}]')
    output = user.launch('a.yaml', '--until', 'ready', code=1)
    assert "failed: 'ready' was not seen before the launch ended" in output


def test_a_time_out_alone_is_about_the_end(talker: User) -> None:
    output = talker.launch('a.yaml', '--timeout', '1', code=1)
    assert 'failed: the launch did not end in 1 s (--timeout)' in output
    talker.write('b.yaml', 'launch: [executable: {cmd: echo hello}]')
    talker.launch('b.yaml', '--timeout', '100')


def test_for_a_time(talker: User) -> None:
    started = time.monotonic()
    output = talker.launch('a.yaml', '--for', '2')
    assert time.monotonic() - started >= 2
    assert 'stopping: it ran for 2 s' in output


def test_for_a_time_unless_something_fails(talker: User) -> None:
    talker.write('talk.sh', 'exit 3')
    text = TALKER.replace('talk.sh,', 'talk.sh, respawn: true,')
    talker.write('a.yaml', text)
    output = talker.launch('a.yaml', '--for', '1000', code=1)
    assert 'stopping: talker-1 failed' in output


def test_a_time_after_all_was_seen(talker: User) -> None:
    words = ['--until', 'starting', '--timeout', '100', '--for', '1']
    output = talker.launch('a.yaml', *words)
    assert 'stopping: it ran for 1 s' in output


def test_timeout_includes_the_build(user: User) -> None:
    user.package('one')
    cmake = user.root / 'src/one/CMakeLists.txt'
    text = 'execute_process(COMMAND sleep 1000)\n'
    cmake.write_text(cmake.read_text() + text)
    output = user.launch('one', 'one', '--timeout', '6', code=1)
    assert '--timeout: the launch did not begin within 6 s' in output
    assert 'hello' not in output


def test_report_that_cannot_be_written(talker: User) -> None:
    output = talker.launch('a.yaml', '--junit', 'a.yaml/b', code=1)
    assert "error: --junit: '" in output
    assert "/a.yaml/b' cannot be written: " in output
    assert 'started' not in output


def test_a_report_says_what_came_of_each_process(talker: User) -> None:
    words = ['--until', 'value', '--junit', 'reports/launch.xml']
    talker.launch('a.yaml', *words)
    assert cases(talker.root / 'reports/launch.xml') == {
        'talker-1': [],
        'sleeper-2': [],
        'late-3': ['skipped'],
        '--until value': [],
    }


def test_a_report_of_failures(talker: User) -> None:
    talker.write('talk.sh', "printf 'bad\\007 luck\\n' >&2; exit 3")
    talker.launch('a.yaml', '--until', 'x', '--junit', 'r.xml', code=1)
    report = talker.root / 'r.xml'
    assert cases(report) == {
        'talker-1': ['failure'],
        'sleeper-2': [],
        'late-3': ['skipped'],
        '--until x': ['failure'],
    }
    failure = ElementTree.parse(report).find('.//failure')
    assert failure is not None
    assert failure.text is not None
    assert 'luck' in failure.text
    assert 'a.yaml:2:5' in failure.text
    assert 'talker-1/stdout_stderr.log' in failure.text


def test_a_report_after_ctrl_c(talker: User) -> None:
    words = ['a.yaml', '--until', 'x', '--junit', 'r.xml']
    launch = talker.start('colcon', 'launch', *words)
    launch.wait_for('starting')
    assert launch.interrupt() == 1, launch.output
    assert cases(talker.root / 'r.xml')['--until x'] == ['failure']


def test_a_report_after_a_time_out_and_a_failed_start(user: User) -> None:
    user.write(
        'a.yaml',
        'launch:\n'
        '  - executable: {cmd: sleep 1000, name: fine}\n'
        '  - executable: {cmd: ./bad.sh, name: bad}\n',
    )
    user.write('bad.sh', '#!/missing/interpreter\n', 0o755)
    words = ['--timeout', '1', '--junit', 'r.xml']
    user.launch('a.yaml', *words, code=1)
    assert cases(user.root / 'r.xml') == {
        'fine-1': [],
        'bad-2': ['failure'],
        '--timeout 1': ['failure'],
    }


@pytest.mark.parametrize('name', ['broken.yaml', 'missing.yaml'])
def test_a_report_of_a_launch_that_cannot_begin(user: User, name: str) -> None:
    user.write('broken.yaml', 'launch: [executables: {cmd: true}]')
    user.launch(name, '--junit', 'r.xml', code=1)
    assert cases(user.root / 'r.xml') == {'launch': ['error']}


def test_failures_are_annotated_on_github(talker: User) -> None:
    talker.write('talk.sh', "echo '100%: bad, luck'; exit 3")
    talker.environment |= {
        'GITHUB_ACTIONS': 'true',
        'GITHUB_WORKSPACE': str(talker.root.parent),
    }
    output = talker.launch('a.yaml', '--until', 'x', code=1)
    found = [s for s in output.splitlines() if s.startswith('::')]
    assert len(found) == 2
    assert found[0].startswith(
        '::error file=ws/a.yaml,line=2,col=5,endColumn=6::talker-1 exited '
        'with code 3 after '
    )
    assert found[0].endswith('%0A100%25: bad, luck')
    assert found[1].startswith("::error::'x' was not seen")


def test_an_installed_launch_file_is_annotated_in_its_source(
    user: User,
) -> None:
    user.package('one', "launch: [executable: {cmd: sh -c 'exit 3'}]\n")
    user.environment |= {
        'GITHUB_ACTIONS': 'true',
        'GITHUB_WORKSPACE': str(user.root),
    }
    output = user.launch('one', 'one', code=1)
    assert '::error file=src/one/launch/one.yaml,line=1,col=10,' in output


def test_mistakes_in_a_launch_file_are_annotated(user: User) -> None:
    user.write('a.yaml', 'launch: [executables: {cmd: true}]')
    user.environment |= {'GITHUB_ACTIONS': 'true'}
    output = user.launch('a.yaml', code=1)
    assert '\n::error file=a.yaml,line=1,col=10,' in output


def test_elsewhere_nothing_is_annotated(talker: User) -> None:
    talker.environment.pop('GITHUB_ACTIONS', None)
    talker.write('talk.sh', 'exit 3')
    assert '::error' not in talker.launch('a.yaml', '--for', '9', code=1)


def test_sigterm_before_all_was_seen(talker: User) -> None:
    launch = talker.start('colcon', 'launch', 'a.yaml', '--until', 'x')
    launch.wait_for('starting')
    launch.process.send_signal(signal.SIGTERM)
    assert launch.end() == 1
    assert "'x' was not seen before" in launch.output


def test_blocked_signals_are_unblocked_in_the_launcher(user: User) -> None:
    user.write('a.yaml', 'launch: [executable: {cmd: sh end.sh}]')
    user.write('end.sh', 'grep SigBlk /proc/self/status; exit 3')
    launch = user.start(*BLOCKING, 'colcon', 'launch', 'a.yaml')
    assert launch.end() == 1
    assert 'exited with code 3' in launch.output
    assert 'SigBlk:\t0000000000000000' in launch.output


def test_blocked_sigint_still_stops_the_launch(talker: User) -> None:
    launch = talker.start(*BLOCKING, 'colcon', 'launch', 'a.yaml')
    launch.wait_for('starting')
    assert launch.interrupt() == 0
    assert 'stopping: interrupted' in launch.output
    assert 'cannot be stopped' not in launch.output
