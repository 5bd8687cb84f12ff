# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Full and read-only disks, folders that are gone, no /proc."""

from pathlib import Path
import re
import shlex
import signal
import time

import pytest
from support.hostile import REMOUNT, with_mounts
from support.user import DEADLINE, User

pytestmark = pytest.mark.hostile

#: Every command of the script, with its exit code.
BEGIN = """\
cd "$1"
do_() { echo "+ $*"; "$@" 2>&1 && echo '= 0' || echo "= $?"; }
"""


def run(user: User, mounts: str, script: str) -> list[tuple[str, str, str]]:
    """Return the commands of a script with their output and exit code."""
    argv = ['bash', '-c', BEGIN + script, 'bash', str(user.root)]
    started = user.start(*with_mounts(mounts, argv), cwd=user.root.parent)
    started.end()
    assert 'Traceback' not in started.output
    assert 'internal error' not in started.output
    steps = re.findall(r'^\+ (.*)\n((?:.*\n)*?)= (\d+)$', started.output, re.M)
    assert steps, started.output
    return steps


def test_an_up_to_date_package_starts_on_a_full_and_a_read_only_disk(
    user: User,
) -> None:
    user.package('hello')
    (user.root / 'src').rename(user.root.parent / 'kept')
    steps = run(
        user,
        f'mount -t tmpfs -o size=8m,mode=755 none {user.root}\n'
        f'cp -a {user.root.parent}/kept {user.root}/src',
        f"""
        do_ colcon launch hello hello.yaml
        dd if=/dev/zero of=fill bs=4k status=none 2>/dev/null
        do_ colcon launch hello hello.yaml
        do_ colcon run hello hello.sh
        rm build/hello/colcon_launch.json
        dd if=/dev/zero of=more bs=4k status=none 2>/dev/null
        do_ colcon launch hello hello.yaml
        rm fill more
        do_ colcon launch hello hello.yaml
        {shlex.join(REMOUNT)} remount,ro .
        do_ colcon launch hello hello.yaml
        do_ colcon run hello hello.sh
        """,
    )
    codes = [code for _, _, code in steps]
    assert codes == ['0', '0', '0', '1', '0', '0', '0'], steps
    for index in (1, 5):
        output = steps[index][1]
        assert 'hello from hello' in output
        assert output.count('warning') == 1
        assert 'log cannot be written to' in output
    assert steps[2][1] == steps[6][1] == 'hello from hello\n'
    refusal = f'cannot build in {user.root}/build: No space left on device'
    assert refusal in steps[3][1]


def test_where_there_is_no_folder_and_no_proc(user: User) -> None:
    user.package('hello')
    steps = run(
        user,
        'true',
        """
        mkdir gone; cd gone; rmdir ../gone
        do_ colcon launch hello hello.yaml
        do_ colcon run hello hello.sh
        do_ colcon create other
        cd ..
        mount -t tmpfs none /proc
        do_ colcon launch hello hello.yaml
        do_ colcon launch --status
        """,
    )
    assert [code for _, _, code in steps] == ['1'] * 5
    for _, output, _ in steps:
        assert re.fullmatch(r'[^\n]+\n(  help: [^\n]+\n)?', output), output
        assert 'error: ' in output
    assert [('/proc' in output) for _, output, _ in steps] == [False] * 3 + [
        True
    ] * 2


def test_a_record_that_is_removed_during_the_build(user: User) -> None:
    folder = user.package('hello')
    record = user.root / 'build/hello/colcon_launch.json'
    lists = folder / 'CMakeLists.txt'
    lists.write_text(f'{lists.read_text()}file(REMOVE {record})\n')
    output = user.launch('hello', 'hello.yaml', code=1)
    (error,) = re.findall('^colcon launch: .*', output, re.M)
    assert f'error: {record} was removed while hello was built' in error
    lists.write_text(lists.read_text().replace(f'file(REMOVE {record})', ''))
    assert 'hello from hello' in user.launch('hello', 'hello.yaml')
    assert Path(record).is_file()


@pytest.mark.parametrize(
    ('name', 'code'), [('SIGINT', 130), ('SIGTERM', 143), ('SIGQUIT', 131)]
)
def test_a_command_that_never_ends_goes_with_the_launch(
    user: User, name: str, code: int
) -> None:
    begun = user.root / 'begun'
    script = f'echo $$ > {begun}; exec sleep 99'
    user.write(
        'wait.yaml',
        f'launch:\n- log_info: {{message: $(command "sh -c \'{script}\'")}}\n',
    )
    started = user.start('colcon', 'launch', 'wait.yaml')
    deadline = time.monotonic() + DEADLINE
    while not begun.exists() or not begun.read_text():
        assert time.monotonic() < deadline
        time.sleep(0.01)
    started.process.send_signal(signal.Signals[name])
    assert started.end() == code, started.output
    assert 'Traceback' not in started.output
    # whoever adopted it has to take note of its end
    command = Path('/proc', begun.read_text().strip())
    while command.exists():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def test_links_that_cannot_be_followed_are_passed_over(user: User) -> None:
    folder = user.package('one')
    # as a link into a folder of others does, it cannot even be looked at
    target = 'x' * 300
    for link in (
        *(user.root / 'bad', user.root / 'src/bad', user.root / 'a.yaml'),
        *(folder / 'bad', folder / 'launch/bad', folder / 'config/a.yaml'),
    ):
        link.symlink_to(target)
    assert 'hello from one' in user.launch('one', 'one')
    assert 'no problems' in user.launch('one', 'one', '--check')
    (folder / 'launch/bad.launch.yaml').symlink_to(target)
    words: tuple[str, ...]
    for words in (('one', 'bad'), ('--check',)):
        output = user.launch(*words, code=1)
        assert "bad.launch.yaml': File name too long" in output
    for word in ('a.yaml', 'bad/a.yaml'):
        output = user.launch(word, code=1)
        assert f"there is no launch file '{word}'\n" in output


def test_launch_by_path_works_in_proc(user: User) -> None:
    file = user.write('a.yaml', 'launch: [executable: {cmd: echo $(env X)}]')
    user.environment['X'] = 'as elsewhere # pkg'
    command = f'cd /proc/self && exec colcon launch {file}'
    launch = user.start('bash', '-c', command)
    assert launch.end() == 0, launch.output
    assert 'as elsewhere' in launch.output
