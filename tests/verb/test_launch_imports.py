# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A launch that builds nothing imports nothing that takes long."""

import pkgutil
import re
import time

import colcon_yamllaunch
from support.user import DEADLINE
from support.user import User

#: What makes `colcon build` slow to start, and what only mistakes, builds and
#: other sorts of launch files need.
HEAVY = {
    'catkin_pkg',
    'difflib',
    'em',
    'hashlib',
    'pyparsing',
    'setuptools',
    'xml.etree.ElementTree',
}
#: What colcon uses to find out what it was told.
IDENTIFYING = {'catkin_pkg.package', 'distlib', 'pyparsing', 'setuptools'}
#: What colcon writes the setup scripts of a package with.
BUILDING = 'em'
#: The part of the modules of this package that a launch may do with; reports,
#: inspections, requests to running launches and completion have the others.
SHARE = 0.75


def imported(user: User) -> set[str]:
    """Launch, and return what was imported for that."""
    user.environment['PYTHONPROFILEIMPORTTIME'] = '1'
    output = user.launch('one', 'one')
    del user.environment['PYTHONPROFILEIMPORTTIME']
    return set(re.findall(r'^import time: .*\| +(\S+)$', output, re.M))


def imported_without_changes(user: User) -> set[str]:
    """
    Launch until files are trusted by their times, and do what imported does.

    An edit of a file that is quite new may leave the same time.
    """
    deadline = time.monotonic() + DEADLINE
    while True:
        found = imported(user)
        if found.isdisjoint(HEAVY) or time.monotonic() > deadline:
            return found


def test_launch_without_changes_imports_nothing_heavy(user: User) -> None:
    user.package('one')
    user.launch('one', 'one')
    found = imported_without_changes(user)
    assert found.isdisjoint(HEAVY), found & HEAVY
    path = colcon_yamllaunch.__path__
    names = pkgutil.walk_packages(path, 'colcon_yamllaunch.')
    modules = {name for _, name, _ in names}
    assert 0 < len(found & modules) <= SHARE * len(modules)


def test_change_asks_colcon(user: User) -> None:
    folder = user.package('one')
    user.launch('one', 'one')
    (folder / 'config' / 'more.txt').write_text('more\n')
    assert BUILDING in imported(user)


def test_known_package_is_built_without_identifying_it(user: User) -> None:
    folder = user.package('one')
    user.launch('one', 'one')
    imported_without_changes(user)
    (folder / 'config' / 'more.txt').write_text('more\n')
    found = imported(user)
    assert BUILDING in found
    assert found.isdisjoint(IDENTIFYING), found & IDENTIFYING
