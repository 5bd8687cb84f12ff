# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Which packages of the workspace a part of a plan needs."""

from pathlib import Path

from colcon_yamllaunch.plan.plan import (
    Component,
    ParameterFile,
    Plan,
    Process,
    SetParameter,
)
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.remote.plan_references import packages_of
from colcon_yamllaunch.workspace.packages.package import Package
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator
import pytest

AT = Position('a.yaml', 1, 1)
NAMES = ('a', 'b', 'c')


def process(*words, **fields):
    return Process('p', words, '/', AT, **fields)


@pytest.fixture
def needed(tmp_path):
    root = tmp_path / 'ws'
    install = root / 'install'
    packages = []
    for name in NAMES:
        folder = root / 'src' / name
        folder.mkdir(parents=True)
        packages.append(Package(name, folder, 'cmake'))
    locator = PackageLocator(packages, install, False, {})

    def find(*parts):
        return packages_of(Plan(parts), locator, root, install)

    find.root = root
    return find


def test_it_is_named_as_the_package_of_a_program_or_component(needed):
    component = Component('c', 'b', 'b::C', '/box', AT)
    assert needed(process('x', package='a'), component) == {'a', 'b'}
    # one of an underlay is no business of the workspace
    assert needed(process('x', package='rviz2')) == frozenset()


@pytest.mark.parametrize(
    'text',
    [
        '{}/install/a/lib/a/x',
        'file:=/usr/x:{}/install/a/share/a/y',
        'file://{}/install/a/share/a/y',
        '["/usr", "{}/install/a/share"]',
        '{}/src/a/launch/x.yaml',
    ],
)
def test_it_is_named_by_a_path(needed, text: str):
    text = text.format(needed.root)
    parameter = SetParameter('name', text, AT)
    component = Component('c', '', 'C', '/box', AT, parameters=(parameter,))
    parts = [
        process('x', text),
        process('x', ParameterFile(f'x: {text}\n')),
        process('x', environment=(('GONE', None), ('PATHS', text))),
        process('x', parameters=(parameter,)),
        component,
    ]
    for part in parts:
        assert needed(part) == {'a'}


def test_other_paths_name_nothing(needed):
    root = needed.root
    words = (f'{root}', f'{root}/install/none/x', f'{root}2/install/a', 'a')
    assert needed(process(*words)) == frozenset()


def test_a_workspace_by_its_other_name(needed, tmp_path: Path):
    real = needed.root.resolve()
    assert needed(process('x', f'{real}/install/a/x')) == {'a'}
