# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Output and logs of `colcon launch`, from a user's side."""

from pathlib import Path

from colcon_yamllaunch.common.errors import UserError
import pytest
from support.command_lines import launch_options
from support.user import User

SCRIPT = """\
launch:
  - log: {message: careful, level: WARNING}
  - executable:
      name: shell
      cmd: >-
        sh -c "test -t 1 && echo terminal; echo [$NO_COLOR];
        printf '\\\\033[32mgreen\\\\033[0m\\\\n'; exit $(var code)"
"""


@pytest.fixture
def launch_file(user: User) -> str:
    """Write a launch file, without a workspace."""
    user.environment.pop('NO_COLOR', None)
    text = 'launch:\n  - arg: {name: code, default: "0"}\n'
    user.write('demo.yaml', text + SCRIPT.partition('\n')[2])
    return 'demo.yaml'


def logs_of(user: User) -> list[Path]:
    """Return the log folders, the oldest first."""
    folders = (user.root.parent / '.ros/log').glob('launch_*')
    return sorted(folders, key=lambda p: p.stat().st_mtime_ns)


def test_each_process_may_get_a_terminal(user: User, launch_file: str) -> None:
    assert 'terminal' not in user.launch(launch_file)
    assert '[shell-1] terminal\n' in user.launch(launch_file, '--tty')


def test_colours_may_be_refused(user: User, launch_file: str) -> None:
    user.environment['RCUTILS_COLORIZED_OUTPUT'] = '1'
    assert '[shell-1] \x1b[32mgreen' in user.launch(launch_file)
    output = user.launch('--no-color', launch_file)
    assert '[shell-1] [1]\n[shell-1] green\n' in output
    assert '\x1b' not in output


def test_a_format_is_that_of_ros(user: User, launch_file: str) -> None:
    user.environment['OVERRIDE_LAUNCH_SCREEN_FORMAT'] = '{name}|{message}'
    user.environment['OVERRIDE_LAUNCH_LOG_FORMAT'] = '{message'
    output = user.launch(launch_file)
    assert 'launch.user|careful\n' in output
    assert '[shell-1] green\n' in output
    assert output.count('OVERRIDE_LAUNCH_LOG_FORMAT is ignored') == 1


def test_logs_may_have_a_limit(user: User) -> None:
    user.write(
        'flood.yaml',
        'launch: [{executable: {cmd: seq 1 500000, output: own_log}}]\n',
    )
    output = user.launch('flood.yaml', '--log-limit', '2MB')
    assert output.count('the limit of 2 MB') == 1
    (folder,) = logs_of(user)
    files = [p for p in folder.rglob('*') if p.is_file()]
    assert sum(p.stat().st_size for p in files) <= 2_000_000
    assert (folder / 'seq-1/stdout.log.1').exists()
    assert 'limit' not in user.launch('flood.yaml', '--log-limit=none')
    newest = logs_of(user)[-1] / 'seq-1/stdout.log'
    assert newest.read_bytes().count(b'\n') == 500_000


@pytest.mark.parametrize(
    ('text', 'size'),
    [
        ('1MB', 10**6),
        ('1.5GB', 15 * 10**8),
        ('2 gb', 2 * 10**9),
        ('500000kB', 5 * 10**8),
        ('3000000', 3 * 10**6),
        ('2MiB', 2 << 20),
        ('2M', 2 << 20),
        ('1T', 1 << 40),
        ('none', None),
    ],
)
def test_sizes_are_written_as_for_coreutils(
    text: str, size: int | None
) -> None:
    options = launch_options('--log-limit', text, 'a.yaml')
    assert options.log_limit == size


@pytest.mark.parametrize(
    'text', ['', '0', '999kB', '-5MB', '5XB', 'MB', '1e9', 'all', '1,5GB']
)
def test_other_sizes_are_refused(text: str) -> None:
    with pytest.raises(UserError, match='--log-limit'):
        launch_options(f'--log-limit={text}', 'a.yaml')


def test_a_first_failure_is_named_with_its_log(
    user: User, launch_file: str
) -> None:
    output = user.launch(launch_file, 'code:=3', code=1)
    (folder,) = logs_of(user)
    assert 'failed: shell-1 exited with code 3 after ' in output
    assert f'output: {folder}/shell-1/stdout_stderr.log' in output


def test_old_log_folders_are_deleted(user: User, launch_file: str) -> None:
    user.environment['COLCON_LAUNCH_LOG_FOLDERS'] = '2'
    foreign = user.root.parent / '.ros/log/2026-01-01-00-00-00-host-1'
    foreign.mkdir(parents=True)
    first = set()
    for count in range(1, 6):
        user.launch(launch_file)
        assert len(logs_of(user)) == min(count, 3)
        first = first or set(logs_of(user))
    assert not first & set(logs_of(user))
    assert foreign.is_dir()


def test_a_running_launch_keeps_its_folder(
    user: User, launch_file: str
) -> None:
    user.environment['COLCON_LAUNCH_LOG_FOLDERS'] = '0'
    user.write('sleep.yaml', 'launch: [{executable: {cmd: sleep 99}}]\n')
    running = user.start('colcon', 'launch', 'sleep.yaml')
    running.wait_for('started, pid')
    (kept,) = logs_of(user)
    for _ in range(2):
        user.launch(launch_file)
        assert kept in logs_of(user)
    assert len(logs_of(user)) == 2
    assert running.interrupt() == 0


def test_every_colcon_command_lists_the_variable(user: User) -> None:
    listing = user.start('colcon', '--help')
    assert listing.end() == 0
    assert 'COLCON_LAUNCH_LOG_FOLDERS' in listing.output


def test_a_log_folder_that_cannot_be_written_does_not_stop_a_launch(
    user: User,
) -> None:
    user.package('hello')
    user.write('log', 'in the way')
    output = user.launch('hello', 'hello.yaml')
    assert output.count('cannot be written to; the logs are in ') == 1
    assert 'hello from hello' in output
    (folder,) = logs_of(user)
    assert (folder / 'hello.sh-1/stdout.log').read_text()
