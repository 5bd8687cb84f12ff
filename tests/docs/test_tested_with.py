# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the README says that the project is tested with."""

import configparser
import importlib.metadata
from pathlib import Path
import re

import pytest
import yaml

ROOT = Path(__file__).parents[2]
README = (ROOT / 'README.md').read_text(encoding='utf-8')
#: The ROS 2 distribution of a major version of rclpy.
DISTRIBUTIONS = {'7': 'Jazzy', '9': 'Kilted'}
WHEELS = 'wheels from PyPI'


def rows(text: str, first: str) -> list[list[str]]:
    """Return the rows of the table whose head begins with `first`."""
    table = re.search(rf'^\| {first} \|.*\n\|.*\n((?:\|.*\n)+)', text, re.M)
    assert table is not None, first
    lines = table[1].splitlines()
    return [[c.strip() for c in line.split('|')[1:-1]] for line in lines]


def versions(row: list[str]) -> list[str]:
    return row[1].split(', ')


@pytest.fixture
def jobs() -> dict[str, dict[str, list[str]]]:
    """Return the matrix of each job of CI that has one."""
    workflow = ROOT / '.github/workflows/ci.yaml'
    content = yaml.safe_load(workflow.read_text(encoding='utf-8'))
    return {
        name: job['strategy']['matrix']
        for name, job in content['jobs'].items()
        if 'strategy' in job
    }


@pytest.fixture
def metadata() -> configparser.ConfigParser:
    configuration = configparser.ConfigParser()
    configuration.read(ROOT / 'setup.cfg', encoding='utf-8')
    return configuration


def test_wheels_are_tested_with_each_python_of_ci(
    jobs: dict[str, dict[str, list[str]]],
) -> None:
    wheels, *_ = rows(README, 'ROS 2')
    assert wheels[0].endswith(WHEELS)
    assert versions(wheels) == jobs['test']['python']


def test_each_python_has_a_classifier(
    metadata: configparser.ConfigParser,
) -> None:
    wheels, *_ = rows(README, 'ROS 2')
    classifiers = metadata['metadata']['classifiers']
    named = re.findall(r'Python :: (3\.\d+)$', classifiers, re.M)
    assert named == versions(wheels)
    assert metadata['options']['python_requires'] == f'>={named[0]}'


def test_make_accepts_each_python() -> None:
    wheels, *_ = rows(README, 'ROS 2')
    makefile = (ROOT / 'Makefile').read_text(encoding='utf-8')
    limits = re.search(r'\(3, (\d+)\) <= .* <= \(3, (\d+)\)', makefile)
    assert limits is not None
    first, last = int(limits[1]), int(limits[2])
    assert versions(wheels) == [f'3.{n}' for n in range(first, last + 1)]


def test_each_distribution_of_ci_is_named(
    jobs: dict[str, dict[str, list[str]]],
) -> None:
    named = re.findall(r'^\| (\w+), from apt \|.*`ros:(\w+)`', README, re.M)
    assert [image for _, image in named] == jobs['ros']['distro']
    assert all(name.lower() == image for name, image in named)


def test_wheels_are_of_the_named_distribution() -> None:
    installed = importlib.metadata.version('ros-rclpy')
    distribution = DISTRIBUTIONS[installed.split('.')[0]]
    for row in rows(README, 'ROS 2'):
        if row[0].endswith(WHEELS):
            assert row[0] == f'{distribution}, {WHEELS}'


def test_system_of_the_benchmarks_is_named() -> None:
    page = (ROOT / 'docs/benchmarks.md').read_text(encoding='utf-8')
    machine = dict(rows(page, 'machine'))
    *_, row = rows(README, 'ROS 2')
    assert 'benchmarks.md' in row[3]
    assert machine['system'].replace('GNU/Linux ', '').startswith(row[2])
    assert machine['Python'].startswith(f'{row[1]}.')
