# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What colcon is asked, with real colcon and real CMake."""

import contextlib
import json
import os
import shutil
import signal
import time

import pytest

COLCON = 'colcon = Colcon(Path({root!r}), {arguments!r})\n'


def code(workspace, text, arguments=()):
    return COLCON.format(root=str(workspace.root), arguments=arguments) + text


def refusal(workspace, text, arguments=()):
    """Return the error that a line of code raises."""
    text = (
        f'try:\n    colcon = Colcon(Path("."), {arguments!r})\n    {text}\n'
        'except UserError as e:\n    show(str(e))\n'
    )
    (error,), output = workspace.run(text)
    assert 'usage' not in output
    return error


def test_packages(workspace):
    workspace.cmake('flow')
    workspace.ament_cmake(
        'node',
        '<build_depend>flow</build_depend><exec_depend>rclpy</exec_depend>'
        '<test_depend>testlib</test_depend>',
    )
    show = (
        'show([[p.name, p.path, p.type, sorted(p.build_depends), '
        'sorted(p.run_depends)] for p in colcon.packages()])'
    )
    (packages,), _ = workspace.run(code(workspace, show))
    source = workspace.root / 'src'
    assert packages == [
        ['flow', str(source / 'flow'), 'cmake', [], []],
        [
            'node',
            str(source / 'node'),
            'ros.ament_cmake',
            ['ament_cmake', 'flow'],
            ['rclpy'],
        ],
    ]
    assert not (workspace.root / 'build').exists()
    assert not (workspace.root / 'install').exists()


def test_build_is_exact_and_litters_nothing(workspace):
    workspace.cmake('base')
    workspace.cmake('lib', needs=('base',))
    workspace.cmake('other')
    workspace.manifest('app', depends='<test_depend>other</test_depend>')
    workspace.write(
        'src/app/CMakeLists.txt',
        'cmake_minimum_required(VERSION 3.16)\nproject(app NONE)\n'
        'find_package(ament_cmake REQUIRED)\nament_package()\n',
    )
    below = workspace.root / 'some' / 'where'
    below.mkdir(parents=True)
    text = (
        'before = dict(os.environ)\n'
        'for names in [["base"], ["app", "lib"]]:\n'
        '    r = colcon.build(names, before | {"X": "1"})\n'
        '    show([r.returncode, sorted(r.built)])\n'
        'show([os.getcwd(), os.environ == before])\n'
    )
    results, output = workspace.run(code(workspace, text), cwd=below)
    assert results == [
        [0, ['base']],
        [0, ['app', 'lib']],
        [str(below), True],
    ]
    assert 'Starting >>> lib' in output
    installed = {p.name for p in (workspace.root / 'install').iterdir()}
    assert {'app', 'base', 'lib'} <= installed
    assert 'other' not in installed
    # the log folder belongs to the running command, see the driver
    assert [path.name for path in below.iterdir()] == ['log']


def test_plain_cmake_gets_links(workspace):
    source = workspace.cmake('flow')
    text = 'show(colcon.build(["flow"], os.environ).returncode)\n'
    workspace.run(code(workspace, text))
    path = workspace.root / 'install/flow/share/flow/launch/flow.yaml'
    assert path.is_symlink()
    assert path.resolve() == source / 'launch/flow.yaml'


def test_failed_build(workspace):
    workspace.cmake('good')
    workspace.cmake('bad', install='message(FATAL_ERROR "no way")\n')
    arguments = ('--executor', 'sequential', '--continue-on-error')
    text = (
        'r = colcon.build(["good", "bad"], os.environ)\n'
        'show([r.returncode, sorted(r.built)])'
    )
    (result,), output = workspace.run(code(workspace, text, arguments))
    assert result == [1, ['good']]
    assert 'no way' in output


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        (('--typo',), '--typo'),
        (('--executor', 'magic'), 'magic'),
        (('--help',), '--help'),
        (('--parallel-workers', 'x'), '--parallel-workers'),
    ],
)
def test_refused_arguments_are_one_error(workspace, arguments, message):
    assert message in refusal(workspace, 'pass', arguments)


def test_unknown_package_makes_nothing(workspace):
    workspace.cmake('flow')
    error = refusal(workspace, 'colcon.build(["flaw"], os.environ)')
    assert "'flaw'" in error
    assert not (workspace.root / 'build').exists()
    assert not (workspace.root / 'install').exists()


def test_circle_elsewhere_does_not_hinder_a_build(workspace):
    workspace.cmake('flow')
    workspace.cmake('a', needs=('b',))
    workspace.cmake('b', needs=('a',))
    text = 'show(colcon.build(["flow"], os.environ).returncode)'
    (returncode,), _ = workspace.run(code(workspace, text))
    assert returncode == 0


@pytest.mark.parametrize(
    ('paths', 'names'),
    [
        (['src/a'], ['a']),
        (['src/*'], ['a', 'b']),
        # what a shell makes of src/*
        (['src/a', 'src/b', 'src/docs', 'src/README.md'], ['a', 'b']),
        (['../outside/far', 'src/b'], ['b', 'far']),
    ],
)
def test_select(workspace, paths, names):
    workspace.cmake('a')
    workspace.cmake('b')
    workspace.write('src/docs/index.md')
    workspace.write('src/README.md')
    far = workspace.cmake('far')
    outside = workspace.root.parent / 'outside'
    outside.mkdir()
    far.rename(outside / 'far')
    text = (
        f'names = colcon.select({paths!r})\n'
        'show(names)\n'
        'show(colcon.build(names, os.environ).returncode)\n'
    )
    assert workspace.run(code(workspace, text))[0] == [names, 0]


def test_select_is_relative_to_the_caller(workspace):
    workspace.cmake('a')
    text = 'show(colcon.select(["a"]))'
    results, _ = workspace.run(
        code(workspace, text), cwd=workspace.root / 'src'
    )
    assert results == [['a']]


@pytest.mark.parametrize('path', ['nowhere', 'src', 'docs/*', 'no*'])
def test_select_without_package(workspace, path):
    workspace.cmake('a')
    workspace.write('docs/x/y.md')
    error = refusal(workspace, f'show(colcon.select([{path!r}]))')
    assert f"'{path}'" in error
    assert '--paths' in error


@pytest.mark.parametrize('executor', ['parallel', 'sequential'])
def test_interrupt_stops_the_build(workspace, executor):
    workspace.cmake('slow', install='execute_process(COMMAND sleep 600)\n')
    text = (
        'r = colcon.build(["slow"], os.environ)\n'
        'show([r.returncode, sorted(r.built)])\n'
    )
    arguments = ('--executor', executor)
    with workspace.start(code(workspace, text, arguments)) as process:
        try:
            cache = workspace.root / 'build/slow/CMakeFiles'
            wait_for(cache.exists)
            os.killpg(process.pid, signal.SIGINT)
            output, _ = process.communicate(timeout=60)
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
    result = output.rpartition('RESULT ')[2]
    assert json.loads(result) == [130, []], output


def wait_for(condition, deadline=60.0):
    end = time.monotonic() + deadline
    while not condition():
        assert time.monotonic() < end, 'waited in vain'
        time.sleep(0.02)


def test_install_folder_that_cannot_be_made(workspace):
    workspace.cmake('flow')
    workspace.write('taken')
    arguments = ('--install-base', 'taken/install')
    build = 'colcon.build(["flow"], os.environ)'
    error = refusal(workspace, build, arguments)
    assert 'taken' in error


REMEMBERED = """\
from colcon_yamllaunch.workspace.colcon.colcon_cache import CachedColcon

colcon = {kind}(Path({root!r}))
names = [p.name for p in colcon.packages()]
show(colcon.build(names, dict(os.environ)).returncode)
"""


def test_package_is_built_alike_from_the_cache(workspace):
    workspace.cmake('plain')
    workspace.cmake('top', needs=('plain', 'elsewhere'))
    folder = workspace.cmake('ros', needs=('plain',))
    depends = (
        '<build_depend>plain</build_depend><exec_depend>top</exec_depend>'
        '<exec_depend>rclpy</exec_depend><test_depend>testlib</test_depend>'
    )
    workspace.manifest('ros', 'cmake', depends)
    assert (folder / 'package.xml').is_file()
    made = []
    for kind in ('Colcon', 'CachedColcon'):
        text = REMEMBERED.format(kind=kind, root=str(workspace.root))
        assert workspace.run(text)[0] == [0]
        install = workspace.root / 'install'
        made.append(
            {
                str(path.relative_to(install)): path.read_bytes()
                for path in install.rglob('*')
                if path.is_file()
            }
        )
        shutil.rmtree(install)
        shutil.rmtree(workspace.root / 'build')
    assert 'ros/share/colcon-core/packages/ros' in made[0]
    assert made[0] == made[1]
