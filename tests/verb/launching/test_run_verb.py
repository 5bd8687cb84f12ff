# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""`colcon run`, from a user's side."""

from collections.abc import Callable, Iterator
import json
from pathlib import Path
import re
import signal
import subprocess
import sys

import pytest
from support.terminal import Terminal
from support.user import built, DEADLINE, User

CMAKE = """\
cmake_minimum_required(VERSION 3.16)
project(tools NONE)
file(GLOB programs CONFIGURE_DEPENDS scripts/*)
install(PROGRAMS ${programs} DESTINATION lib/tools)
"""
SHOW = """\
#!/usr/bin/env python3
import json, os, sys
print(json.dumps({
    'arguments': sys.argv[1:],
    'variables': dict(os.environ),
    'cwd': os.getcwd(),
    'descriptors': sorted(map(int, os.listdir('/proc/self/fd'))),
    'pid': os.getpid(),
}))
"""
ANSWER = """\
#!/bin/sh
trap : CONT
test -t 0 && test -t 1 && echo 'a terminal'
while read -r line; do
    echo "got <$line>"
    case "$line" in bye) exit 7;; esac
done
"""

Type = Callable[..., Terminal]


@pytest.fixture
def terminal_of(user: User) -> Iterator[Type]:
    """Run commands in terminals that are gone when the test is over."""
    terminals: list[Terminal] = []

    def start(*argv: str) -> Terminal:
        terminals.append(Terminal(list(argv), user.root, user.environment))
        return terminals[-1]

    yield start
    for one in terminals:
        one.close()


@pytest.fixture
def tools(user: User) -> User:
    """Write a package of programs."""
    user.write('src/tools/CMakeLists.txt', CMAKE)
    user.write('src/tools/scripts/show.py', SHOW, 0o755)
    user.write('src/tools/scripts/answer', ANSWER, 0o755)
    return user


def run(
    user: User,
    *words: str,
    code: int = 0,
    given: str = '',
    cwd: Path | None = None,
) -> subprocess.CompletedProcess[str]:
    """Run `colcon run` to its end."""
    done = subprocess.run(
        ['colcon', 'run', *words],
        cwd=cwd or user.root,
        env=user.environment,
        input=given,
        capture_output=True,
        text=True,
        timeout=DEADLINE,
        check=False,
    )
    assert done.returncode == code, done.stdout + done.stderr
    assert 'Traceback' not in done.stderr
    return done


def error(user: User, *words: str, cwd: Path | None = None) -> str:
    """Return what `colcon run` complains about."""
    done = run(user, *words, code=1, cwd=cwd)
    assert done.stdout == ''
    found = re.search('colcon run: error: (.*)', done.stderr, re.DOTALL)
    assert found, done.stderr
    return found[1].rstrip('\n')


def test_program_is_built_and_gets_its_words_as_they_are(tools: User) -> None:
    words = ['--ros-args', '-p', 'a:=[1.0,2.0]', '', '--', '--help', '*', '$A']
    words += ['-height', '--log', '--workspace', '/nowhere', 'a b', '"', '\\']
    done = run(tools, 'tools', 'show.py', *words)
    assert built(done.stderr) == ['tools']
    assert json.loads(done.stdout)['arguments'] == words
    again = run(tools, 'tools', 'show.py', *words)
    assert again.stderr == ''
    assert json.loads(again.stdout)['arguments'] == words


def test_program_has_the_environment_of_the_user_and_the_workspace(
    tools: User,
) -> None:
    folder = tools.root / 'src/tools/scripts'
    tools.environment['MINE'] = 'kept'
    shown = json.loads(run(tools, 'tools', 'show.py', cwd=folder).stdout)
    variables = shown['variables']
    assert variables['COLCON_PREFIX_PATH'] == str(tools.root / 'install')
    assert variables['MINE'] == 'kept'
    assert not {'COLCON', 'COLCON_LOG_PATH'} & set(variables)
    assert shown['cwd'] == str(folder)
    # the last one is that of the folder which it lists
    assert shown['descriptors'] == [0, 1, 2, 3]
    names = {path.name for path in tools.root.iterdir()}
    assert names == {'build', 'install', 'log', 'src'}


def test_program_takes_the_place_of_colcon(tools: User) -> None:
    run(tools, 'tools', 'show.py')
    launch = tools.start('colcon', 'run', 'tools', 'show.py')
    assert launch.end() == 0, launch.output
    assert json.loads(launch.output)['pid'] == launch.process.pid


def test_input_is_the_program_s_own_also_after_a_build(tools: User) -> None:
    reader = 'execute_process(COMMAND cat OUTPUT_VARIABLE text)\n'
    tools.write('src/tools/CMakeLists.txt', CMAKE + reader)
    done = run(tools, 'tools', 'answer', given='one\nbye\n', code=7)
    assert done.stdout == 'got <one>\ngot <bye>\n'


def test_terminal_is_the_program_s_own(tools: User, terminal_of: Type) -> None:
    terminal = terminal_of('colcon', 'run', 'tools', 'answer')
    terminal.shows('a terminal')
    terminal.types('hello\n')
    terminal.shows('got <hello>')
    terminal.types('bye\n')
    assert terminal.ends() == 7, terminal.screen


def test_ctrl_c_ends_the_program_as_without_colcon(
    tools: User, terminal_of: Type
) -> None:
    shell = 'colcon run tools answer; echo "code $?"'
    terminal = terminal_of('bash', '-c', f'trap : INT; {shell}')
    terminal.shows('a terminal')
    terminal.types('\x03')
    terminal.shows('code 130')
    assert terminal.ends() == 0


def test_signal_ends_the_program(tools: User) -> None:
    tools.write('src/tools/scripts/wait', '#!/bin/sh\nkill -TERM $$\n', 0o755)
    waiting = tools.start('colcon', 'run', 'tools', 'wait')
    assert waiting.end() == -signal.SIGTERM, waiting.output


def test_prefix(tools: User) -> None:
    done = run(tools, '--prefix', 'env --', 'tools', 'show.py', 'x')
    assert json.loads(done.stdout)['arguments'] == ['x']
    prefix = 'sh -c \'printf "<%s>" "$@"\' first'
    done = run(tools, '--prefix', prefix, 'tools', 'show.py', 'a b', '')
    path = tools.root / 'install/tools/lib/tools/show.py'
    assert done.stdout == f'<{path}><a b><>'
    assert error(tools, '--prefix', 'gbd -ex run', 'tools', 'show.py') == (
        "there is no program 'gbd' in the folders of PATH\n"
        '  help: install it, or give its path'
    )


def test_without_executable_they_are_listed(tools: User) -> None:
    assert error(tools, 'tools') == (
        'no executable of tools is given\n'
        '  help: it has:\n    answer\n    show.py'
    )


def test_unknown_executable_and_the_nearest_comes_first(tools: User) -> None:
    assert 'it has show.py, answer' in error(tools, 'tools', 'shwo')
    assert "did you mean 'show.py'?" in error(tools, 'tools', 'show')
    assert 'it has' in error(tools, 'tools', '../../share')


def test_executables_in_subfolders(tools: User) -> None:
    text = CMAKE
    for folder in ('a', 'b'):
        text += (
            'install(PROGRAMS scripts/show.py '
            f'DESTINATION lib/tools/{folder} RENAME twin)\n'
        )
    tools.write('src/tools/CMakeLists.txt', text)
    assert error(tools, 'tools', 'twin') == (
        "'twin' may be one of several executables of tools\n"
        '  help: name one by its path:\n    a/twin\n    b/twin'
    )
    done = run(tools, 'tools', 'a/twin', 'x')
    assert json.loads(done.stdout)['arguments'] == ['x']


def test_script_without_its_executable_bit(tools: User) -> None:
    tools.write('src/tools/CMakeLists.txt', CMAKE.replace('PROGRAMS', 'FILES'))
    (tools.root / 'src/tools/scripts/show.py').chmod(0o644)
    assert "run 'chmod +x scripts/show.py'" in error(tools, 'tools', 'show.py')


def test_script_that_is_not_installed(tools: User) -> None:
    tools.write('src/tools/more/new.py', SHOW, 0o755)
    plain = 'install(PROGRAMS scripts/show.py DESTINATION lib/tools)'
    # what the source tells is said first
    for text in (plain, CMAKE):
        tools.write('src/tools/CMakeLists.txt', text)
        cure = 'install(PROGRAMS more/new.py'
        assert cure in error(tools, 'tools', 'new.py')
        assert (tools.root / 'install').exists() is (text == CMAKE)


def test_module_of_another_python_is_named_before_the_start(
    tools: User,
) -> None:
    other = tools.root / 'venv'
    (other / 'lib/python3.11/site-packages/mission').mkdir(parents=True)
    (other / 'bin').mkdir()
    (other / 'bin/python3').symlink_to(sys.executable)
    tools.environment['PATH'] += f':{other}/bin'
    script = tools.root / 'src/tools/scripts/show.py'
    text = f'#!{sys.executable}\nimport json\nimport mission.parts as m\n'
    tools.write('src/tools/scripts/show.py', text, 0o755)
    launch = tools.start('colcon', 'run', 'tools', 'show.py')
    assert launch.end() == 1
    assert (
        'src/tools/scripts/show.py:3:1: warning: it runs with '
        f"{sys.executable}, which has no module 'mission'\n"
        '  3 | import mission.parts as m\n'
        '    | ^^^^^^^^^^^^^^^^^^^^^^^^^\n'
        f'  help: {other}/bin/python3 has it: let the first line of {script} '
        'be #!/usr/bin/env python3\n'
        'Traceback'
    ) in launch.output
    tools.write('lib/mission.py', 'parts = 1\n')
    tools.environment['PYTHONPATH'] = str(tools.root / 'lib')
    tools.write('src/tools/scripts/show.py', text.replace('.parts', ''), 0o755)
    assert run(tools, 'tools', 'show.py').stderr == ''


def test_script_that_windows_wrote(tools: User) -> None:
    path = tools.root / 'src/tools/scripts/show.py'
    path.write_bytes(path.read_bytes().replace(b'\n', b'\r\n'))
    message = error(tools, 'tools', 'show.py')
    cure = message.rpartition('convert it: ')[2]
    subprocess.run(['sh', '-c', cure], check=True)
    assert json.loads(run(tools, 'tools', 'show.py').stdout)['arguments'] == []


def test_unknown_package_builds_nothing(tools: User) -> None:
    assert "did you mean 'tools'?" in error(tools, 'tolls', 'show.py')
    assert not (tools.root / 'build').exists()


def test_failed_build_runs_nothing(tools: User) -> None:
    run(tools, 'tools', 'show.py')
    tools.write('src/tools/CMakeLists.txt', CMAKE + 'message(FATAL_ERROR a)\n')
    done = run(tools, 'tools', 'show.py', code=1)
    assert 'Failed   <<< tools' in done.stderr
    assert done.stdout == ''


def test_no_build(tools: User) -> None:
    words = ['--no-build', 'tools', 'show.py']
    assert 'leave out --no-build' in error(tools, *words)
    run(tools, 'tools', 'show.py')
    tools.write('src/tools/CMakeLists.txt', 'message(FATAL_ERROR a)\n')
    assert json.loads(run(tools, *words).stdout)['arguments'] == []


def test_only_what_the_package_needs_is_built(tools: User) -> None:
    for name in ('needed', 'other'):
        tools.package(name)
    tools.manifest('needed')
    tools.manifest('tools', '<exec_depend>needed</exec_depend>')
    done = run(tools, 'tools', 'show.py')
    assert built(done.stderr) == ['needed', 'tools']
    done = run(tools, '--build-all', 'tools', 'show.py')
    assert built(done.stderr) == ['other']
    tools.write('src/other/new.cpp', '')
    tools.write('src/tools/new.cpp', '')
    done = run(tools, '--paths', 'src/tools', '--', 'tools', 'show.py')
    assert built(done.stderr) == ['tools']


def test_workspace_option(tools: User, tmp_path: Path) -> None:
    elsewhere = tmp_path / 'elsewhere'
    elsewhere.mkdir()
    words = ['--workspace', str(tools.root), 'tools', 'show.py']
    done = run(tools, *words, '--workspace', 'x', cwd=elsewhere)
    assert json.loads(done.stdout)['arguments'] == ['--workspace', 'x']
    assert list(elsewhere.iterdir()) == []
    assert (tools.root / 'log/latest_run').is_dir()


def test_package_of_an_underlay_needs_no_workspace(
    tools: User, tmp_path: Path
) -> None:
    run(tools, 'tools', 'show.py')
    elsewhere = tmp_path / 'elsewhere'
    elsewhere.mkdir()
    install = str(tools.root / 'install')
    assert 'with --workspace' in error(
        tools, 'tools', 'show.py', cwd=elsewhere
    )
    tools.environment['COLCON_PREFIX_PATH'] = install
    done = run(tools, 'tools', 'show.py', 'x', cwd=elsewhere)
    assert json.loads(done.stdout)['arguments'] == ['x']
    assert list(elsewhere.iterdir()) == []


def test_help(tools: User) -> None:
    for words in (['--help'], ['tools', '-h']):
        assert '--prefix' in run(tools, *words).stdout
    text = run(tools, 'tools', 'show.py', '-h').stdout
    assert json.loads(text)['arguments'] == ['-h']
