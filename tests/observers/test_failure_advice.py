# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The way out that the last words of a process tell."""

import signal

from colcon_yamllaunch.engine.events import Exited
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.observers.failure_advice import Advisor
from colcon_yamllaunch.plan.member_settings import (
    MemberSettings,
    ResourceLimits,
    SettingPlace,
)
from colcon_yamllaunch.plan.plan import SetParameter
from colcon_yamllaunch.plan.position import Position
import pytest

MISSING = "ModuleNotFoundError: No module named 'mission.plan'"


@pytest.fixture
def machine(tmp_path):
    """Return a folder with a script and two interpreters, one in the PATH."""
    for name in ('venv/bin/python3', 'old/bin/python3', 'node.py', 'driver'):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text('')
        path.chmod(0o755)
    (tmp_path / 'node.py').write_text(f'#!{tmp_path}/old/bin/python3\n')
    return tmp_path


@pytest.fixture
def advice(machine, process):
    """Return a function that tells the advice for an end."""

    def advise(*tail, program='node.py', prefix=(), owner=None, **more):
        advisor = Advisor(
            {'PATH': f'{machine}/venv/bin'},
            lambda _module, _user: owner,
            **more.pop('advisor', {}),
        )
        argv = (*prefix, f'{machine}/{program}')
        ended = process('node.py-1', *argv, package=more.pop('package', None))
        outcome = Outcome(**(more or {'code': 1}))
        return advisor.advise(
            Exited(ended, 9, outcome, 1.0, False, True), tail
        )

    return advise


CRASH = {'signal': int(signal.SIGSEGV)}


def test_other_failures_have_no_advice(advice):
    assert advice('Traceback:', 'ValueError: 5') is None
    assert advice('EOFError: EOF when reading a line', code=0) is not None
    assert advice(f'nothing like {MISSING}') is None


@pytest.mark.parametrize(
    'line',
    [
        'EOFError: EOF when reading a line',
        "termios.error: (25, 'Inappropriate ioctl for device')",
    ],
)
def test_keyboard_error_advises_attach(advice, line):
    assert advice(line, 'bye').endswith('by --attach node.py-1')


def test_module_of_another_interpreter_advises_its_use(advice, machine):
    library = machine / 'venv/lib/python3.12/site-packages'
    (library / 'mission').mkdir(parents=True)
    text = advice(MISSING)
    used, other = f'{machine}/old/bin/python3', f'{machine}/venv/bin/python3'
    assert f"it ran with {used}, which has no module 'mission'" in text
    assert f'; {other} has it: ' in text
    assert text.endswith(f'{machine}/node.py be #!/usr/bin/env python3')
    # the file to edit is that behind a link
    (machine / 'installed.py').symlink_to(machine / 'node.py')
    text = advice(MISSING, program='installed.py')
    assert f'let the first line of {machine}/node.py be ' in text


def test_missing_module_advises_installation(advice):
    assert 'install it there, or source the setup.bash' in advice(MISSING)


def test_misspelt_module_suggests_the_name(advice, machine):
    library = machine / 'old/lib/python3/dist-packages'
    (library / 'missions').mkdir(parents=True)
    text = advice(MISSING)
    assert text.endswith("has no module 'mission'; did you mean 'missions'?")


def test_undeclared_package_advises_exec_depend(advice):
    text = advice(MISSING, owner='mission_planner')
    assert '<exec_depend>mission_planner</exec_depend>' in text


@pytest.mark.parametrize('program', ['driver', 'node.py'])
def test_crash_advises_a_debugger(advice, machine, program):
    text = advice(program=program, **CRASH)
    # a debugger cannot read a script
    is_script = program.endswith('.py')
    python = f' {machine}/old/bin/python3' if is_script else ''
    assert f"--launch-prefix 'gdb -ex run --args{python}'" in text
    assert text.endswith(f'--launch-prefix-filter {program}')
    assert '--attach node.py-1' in text
    assert advice(program=program, signal=int(signal.SIGKILL)) is None


def test_advice_is_about_the_program_behind_a_prefix(advice, machine):
    (machine / 'lib/cpp').mkdir(parents=True)
    (machine / 'driver').rename(machine / 'lib/cpp/driver')
    nice = {'prefix': ('nice', '-n', '1'), 'package': 'cpp'}
    text = advice(program='lib/cpp/driver', **nice, **CRASH)
    assert text.endswith('--launch-prefix-filter driver')


def test_crash_with_buffered_output_advises_tty(advice):
    buffering = {'holds_back': lambda _process: True}
    text = advice(program='driver', advisor=buffering, **CRASH)
    assert '--tty prevents; to see where: ' in text


def test_sanitizer_error_advises_no_line_buffering(advice):
    text = advice(
        '==7==ASan runtime does not come first in initial library list; you'
    )
    assert text == 'let it start with COLCON_LAUNCH_LINE_BUFFERED=0'


def test_refused_parameter_comes_before_the_crash(advice):
    rate = SetParameter('rate', '1', Position('/ws/a.yaml', 7, 9))
    line = "parameter 'rate' has invalid type: expected [double] got [integer]"
    text = advice(
        *('terminate called', line),
        program='driver',
        advisor={'parameters_of': lambda _process: [rate]},
        signal=int(signal.SIGABRT),
    )
    assert text.endswith('give it 1.0 instead of 1, at /ws/a.yaml:7:9')


@pytest.mark.parametrize(
    ('outcome', 'line', 'advice'),
    [
        (
            Outcome(signal=signal.SIGKILL, limit='over its 1 MiB limit'),
            '',
            "raise 'memory' at /ws/robot.yaml:3:5, or let it need less",
        ),
        (
            Outcome(code=1),
            'MemoryError',
            "its limit is 1 MiB: raise 'memory' at /ws/robot.yaml:3:5, or let "
            'it need less',
        ),
        (
            Outcome(signal=signal.SIGABRT),
            "terminate called after throwing an instance of 'std::bad_alloc'",
            "its limit is 1 MiB: raise 'memory' at /ws/robot.yaml:3:5, or let "
            'it need less',
        ),
        (
            Outcome(code=1, limit='at its limit of 5 tasks'),
            'fork failed',
            "raise 'tasks' at /ws/robot.yaml:4:5",
        ),
        (Outcome(code=1), 'ValueError', None),
        (Outcome(signal=signal.SIGKILL), '', None),
    ],
)
def test_an_exceeded_limit_is_named_with_its_place(
    process, outcome, line, advice
):
    settings = MemberSettings(
        Position('/ws/robot.yaml', 2, 5),
        limits=ResourceLimits(memory=1 << 20, tasks=5),
        places=(
            SettingPlace('memory', Position('/ws/robot.yaml', 3, 5)),
            SettingPlace('tasks', Position('/ws/robot.yaml', 4, 5)),
        ),
    )
    limited = process('node', 'node', settings=settings)
    ended = Exited(limited, 9, outcome, 1.0, False, True)
    advisor = Advisor({}, lambda _module, _user: None)
    assert advisor.advise(ended, [line]) == advice
