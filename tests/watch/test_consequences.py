# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The table of `docs/watching.md`, row for row."""

from dataclasses import replace
from pathlib import PurePosixPath

from colcon_yamllaunch.watch.consequences import (
    after_rewrite,
    consequences,
    Steps,
    steps,
    why_lines,
)
from colcon_yamllaunch.watch.dependencies import (
    Dependencies,
    PackageDependencies,
    ProcessDependencies,
)
from colcon_yamllaunch.watch.watched_files import Change
from hypothesis import given, strategies
import pytest
from support.random_cases import RANDOM

ARM, MATHS, MSGS = '/ws/src/arm', '/ws/src/maths', '/ws/src/msgs'
HEADER = '/home/me/include/fast.h'
LAUNCH = f'{ARM}/launch/demo.yaml'
XACRO = '/home/me/arm.urdf'

ALL = frozenset(('arm', 'maths', 'msgs'))
ALL_YAML = f'{ARM}/config/all.yaml'
KNOWLEDGE = Dependencies(
    (
        ProcessDependencies(
            *('double', f'{ARM}/scripts/double.py', ALL),
            frozenset((ALL_YAML,)),
            may_run_python=True,
        ),
        ProcessDependencies(
            *('triple', '/ws/install/arm/lib/arm/triple', ALL),
            frozenset((ALL_YAML, '/home/me/x.rviz')),
            may_run_python=True,
        ),
        ProcessDependencies(
            'motor', '/ws/build/arm/motor', frozenset(('arm', 'msgs'))
        ),
        ProcessDependencies('bag', '/home/me/bag.sh', may_run_python=True),
        ProcessDependencies(
            'camera',
            files=frozenset((f'{ARM}/config/camera.json',)),
            is_component=True,
        ),
    ),
    (
        PackageDependencies(
            *('arm', ARM),
            frozenset(
                (
                    *('scripts/double.py', 'config/all.yaml', 'arm/pose.py'),
                    *('launch/demo.yaml', 'launch/old.py', 'arm/gone.py'),
                    *('config/camera.json', 'urdf/mesh.stl'),
                )
            ),
            frozenset(('arm/pose.py', 'arm/gone.py')),
            frozenset(('arm',)),
            frozenset((HEADER,)),
        ),
        PackageDependencies(
            'maths', MATHS, *[frozenset(('maths/add.py',))] * 2
        ),
        PackageDependencies('msgs', MSGS, inputs=frozenset((HEADER,))),
        PackageDependencies('tool', f'{ARM}/tool'),
    ),
    plan_files=frozenset((LAUNCH, XACRO)),
)

RESTARTS = Steps(restart=('double', 'triple'))
BUILDS = Steps(frozenset(('arm',)))
BUILDS_FIRST = replace(BUILDS, after_build=('double', 'triple'))
BUILDS_AND_REPLANS = replace(BUILDS, replan=True)


def of(*paths: str, kind: str = 'changed', **known: bool) -> Steps:
    changes = [Change(kind, path, path) for path in paths]
    knowledge = replace(KNOWLEDGE, **known)
    return steps(consequences(changes, knowledge), knowledge)


@pytest.mark.parametrize(
    ('path', 'kind', 'expected'),
    [
        # a script that is linked
        (f'{ARM}/scripts/double.py', 'changed', Steps(restart=('double',))),
        # one that no package has
        ('/home/me/bag.sh', 'changed', Steps(restart=('bag',))),
        # a module that is linked, of the package and of one that it needs
        (f'{ARM}/arm/pose.py', 'changed', RESTARTS),
        (f'{MATHS}/maths/add.py', 'changed', RESTARTS),
        # what a package is built from
        (f'{ARM}/src/motor.cpp', 'changed', BUILDS),
        (f'{ARM}/include/arm/motor.hpp', 'changed', BUILDS),
        (f'{ARM}/CMakeLists.txt', 'changed', BUILDS),
        (f'{ARM}/package.xml', 'changed', BUILDS),
        (f'{MSGS}/msg/Pose.msg', 'changed', Steps(frozenset(('msgs',)))),
        # of two packages one in the other, it is the inner one
        (f'{ARM}/tool/src/main.cpp', 'changed', Steps(frozenset(('tool',)))),
        # what builds have read elsewhere
        (HEADER, 'changed', Steps(frozenset(('arm', 'msgs')))),
        # what the plan names
        (f'{ARM}/config/all.yaml', 'changed', RESTARTS),
        ('/home/me/x.rviz', 'changed', Steps(restart=('triple',))),
        (f'{ARM}/config/camera.json', 'changed', Steps(restart=('camera',))),
        # what the plan was made from
        (LAUNCH, 'changed', Steps(replan=True)),
        (XACRO, 'changed', Steps(replan=True)),
        # what nothing uses
        (f'{ARM}/launch/old.py', 'changed', Steps()),
        (f'{ARM}/urdf/mesh.stl', 'changed', Steps()),
        ('/home/me/notes.txt', 'changed', Steps()),
        ('/ws/src/army/src/motor.cpp', 'changed', Steps()),
        # it will be installed, and what crashed for want of it goes on
        (f'{ARM}/arm/more.py', 'new', BUILDS_FIRST),
        (f'{ARM}/arm/gone.py', 'deleted', BUILDS_FIRST),
        (f'{ARM}/test/more.py', 'new', BUILDS),
        (f'{ARM}/src/new.cpp', 'new', BUILDS),
        (f'{ARM}/urdf/mesh.stl', 'deleted', BUILDS),
        # a fresh launch would not start
        (f'{ARM}/scripts/double.py', 'deleted', BUILDS_AND_REPLANS),
        ('/home/me/bag.sh', 'deleted', Steps(replan=True)),
        (f'{ARM}/scripts/double.py', 'mode', Steps(restart=('double',))),
        (f'{ARM}/arm/pose.py', 'mode', Steps()),
        # one that is not there is not in the plan
        ('/home/me/x.rviz', 'new', Steps(replan=True, restart=('triple',))),
        (LAUNCH, 'deleted', BUILDS_AND_REPLANS),
    ],
)
def test_change_has_documented_steps(
    path: str, kind: str, expected: Steps
) -> None:
    assert of(path, kind=kind) == expected


def test_changes_of_one_batch_are_handled_together() -> None:
    found = of(
        f'{MSGS}/msg/Pose.msg',
        '/home/me/x.rviz',
        f'{ARM}/src/motor.cpp',
        f'{ARM}/scripts/double.py',
        LAUNCH,
    )
    assert found == Steps(
        frozenset(('arm', 'msgs')), True, ('double', 'triple')
    )


def test_restart_after_build_replaces_restart_at_once() -> None:
    paths = {f'{ARM}/arm/more.py': 'new', '/home/me/x.rviz': 'changed'}
    changes = [Change(kind, path, path) for path, kind in paths.items()]
    found = steps(consequences(changes, KNOWLEDGE), KNOWLEDGE)
    assert found.restart == ()
    assert found.after_build == ('double', 'triple')


@pytest.mark.parametrize('known', ['reads_more', 'is_plan_broken'])
def test_any_change_replans_if_the_plan_may_depend_on_it(known: str) -> None:
    mesh, module = f'{ARM}/urdf/mesh.stl', f'{ARM}/arm/pose.py'
    assert of(mesh, **{known: True}) == Steps(replan=True)
    assert of(module, **{known: True}) == Steps(
        replan=True, restart=('double', 'triple')
    )
    # after a build it is looked at anyway
    source = f'{ARM}/src/motor.cpp'
    assert not of(source, **{known: True}).replan


def test_file_with_two_names_is_one_change() -> None:
    real = '/home/me/x.rviz'
    changes = [
        Change('changed', '/ws/install/arm/share/arm/x.rviz', real),
        Change('changed', f'{ARM}/x.rviz', real),
    ]
    found = consequences(changes, KNOWLEDGE)
    assert [(one.action, one.names) for one in found] == [
        ('restart', ('triple',)),
        ('build', ('arm',)),
    ]
    # by the name that tells more
    assert {one.change.path for one in found} == {f'{ARM}/x.rviz'}


def test_why_line_names_change_action_and_reason() -> None:
    names = ('arm/pose.py', 'src/\x1bnew.cpp', 'launch/demo.yaml')
    paths = [f'{ARM}/{name}' for name in (*names, 'urdf/mesh.stl')]
    changes = [
        Change('new' if path.endswith('.cpp') else 'changed', path, path)
        for path in paths
    ]
    lines = list(why_lines(consequences(changes, KNOWLEDGE), '/ws'))
    assert lines == [
        'src/arm/arm/pose.py changed: restart double, triple, as it '
        'is a Python module of arm',
        'src/arm/src/�new.cpp is new: build arm, as arm is built from it',
        'src/arm/launch/demo.yaml changed: evaluate the launch file, '
        'as the launch file reads it',
        'src/arm/urdf/mesh.stl changed: nothing to do, as nothing in '
        'the launch uses it',
    ]


DOUBLE = Steps(restart=('double',))
AFTER_BUILD = Steps(after_build=('triple',))


@pytest.mark.parametrize(
    ('path', 'failed', 'has_prepared', 'expected'),
    [
        # who runs for long has read it as it is
        (f'{ARM}/scripts/double.py', (), False, Steps()),
        (f'{ARM}/config/all.yaml', ('bag', 'motor'), False, Steps()),
        # who has just failed may have read another one
        (ALL_YAML, ('bag', 'double'), False, DOUBLE),
        (f'{ARM}/scripts/double.py', ('double', 'triple'), False, DOUBLE),
        (f'{ARM}/arm/pose.py', ('triple',), False, AFTER_BUILD),
        # and so may a build and an evaluation
        (f'{ARM}/src/a.cpp', (), False, Steps()),
        (f'{ARM}/src/a.cpp', (), True, BUILDS),
        (LAUNCH, (), False, Steps()),
        (LAUNCH, (), True, BUILDS_AND_REPLANS),
        # a link to it could not be installed
        (f'{ARM}/urdf/mesh.stl', (), True, BUILDS),
        ('/home/me/notes.txt', ('bag',), True, Steps()),
    ],
)
def test_rewritten_file_restarts_what_failed(
    path: str, failed: tuple[str, ...], has_prepared: bool, expected: Steps
) -> None:
    change = Change('again', path, path)
    found = after_rewrite(
        [change], KNOWLEDGE, failed=failed, has_prepared=has_prepared
    )
    assert steps(found, KNOWLEDGE) == expected
    assert {one.change for one in found} <= {change}
    for line in why_lines(found):
        assert 'changed, and changed back' in line


PATHS = strategies.sampled_from(
    [
        *(LAUNCH, XACRO, HEADER, '/home/me/x.rviz', '/home/me/bag.sh'),
        *('/home/me/notes.txt', f'{ARM}/arm/new.py', f'{ARM}/src/a.cpp'),
        *(
            str(PurePosixPath(package.path, name))
            for package in KNOWLEDGE.packages
            for name in package.live
        ),
    ]
)
CHANGES = strategies.lists(
    strategies.builds(
        lambda kind, path: Change(kind, path, path),
        strategies.sampled_from(['new', 'changed', 'deleted', 'mode']),
        PATHS,
    ),
    max_size=8,
)
KNOWN = strategies.builds(
    lambda more, broken: replace(
        KNOWLEDGE, reads_more=more, is_plan_broken=broken
    ),
    strategies.booleans(),
    strategies.booleans(),
)


@RANDOM
@given(CHANGES, CHANGES, KNOWN)
def test_batch_has_the_consequences_of_its_changes(
    some: list[Change], others: list[Change], knowledge: Dependencies
) -> None:
    def done(changes: list[Change]) -> Steps:
        return steps(consequences(changes, knowledge), knowledge)

    first, second, both = done(some), done(others), done([*some, *others])
    assert both.build == first.build | second.build
    assert both.replan == (first.replan or second.replan)
    restarted = {*both.restart, *both.after_build}
    assert restarted == {
        *(*first.restart, *first.after_build),
        *(*second.restart, *second.after_build),
    }
    # in the order of the launch, and each but once
    order = [process.label for process in knowledge.processes]
    assert list(both.restart) == [n for n in order if n in both.restart]
    assert not {*both.restart} & {*both.after_build}
    assert done([*others, *some]) == both
