# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A launch imports only what the features that it uses need."""

import importlib.util
from pathlib import Path
import re
import time

import pytest
from support.user import DEADLINE, User

PACKAGE = 'colcon_yamllaunch'
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
#: The sub-packages of features that a plain launch does not use.
UNUSED = (
    'deployment',
    'language.python_files',
    'language.reports',
    'remote',
    'service',
    'python_launch',
    'sweep',
    'terminal.full_screen',
    'watch',
    'workspace.create',
)
#: Modules of such features in sub-packages that it does use.
UNUSED_MODULES = (
    'control.client_connection',
    'engine.composition',
    'engine.debugging',
    'engine.lifecycles',
    'engine.limited_spawn',
    'engine.line_pattern',
    'engine.readiness',
    'engine.resource_limits',
    'engine.restarts',
    'engine.ros_client',
    'engine.ros_link',
    'engine.ros_requests',
    'language.actions.component_actions',
    'language.actions.parameter_files',
    'language.policies.check',
    'language.syntax.xml_reader',
    'language.syntax.errors',
    'observers.failure_advice',
    'observers.junit',
    'observers.start_table',
    'terminal.terminal_session',
    'verb.completing',
    'verb.controlling',
    'verb.create_main',
    'verb.inspect_launch',
    'verb.machines',
    'verb.background_launch',
    'verb.run_main',
    'verb.services',
    'verb.sweep_main',
    'verb.watch_launch',
    'workspace.colcon.package_scan',
    'workspace.freshness.build_inputs',
    'workspace.packages.build_files',
    'workspace.packages.python_modules',
)
#: The sub-packages that a launch without a workspace does not use, either.
OF_WORKSPACES = (
    'workspace.colcon',
    'workspace.freshness',
)


def imported(user: User, *words: str, cwd: Path | None = None) -> set[str]:
    """Launch, and return what was imported for that."""
    user.environment['PYTHONPROFILEIMPORTTIME'] = '1'
    output = user.launch(*words, cwd=cwd)
    del user.environment['PYTHONPROFILEIMPORTTIME']
    return set(re.findall(r'^import time: .*\| +(\S+)$', output, re.M))


def imported_without_changes(user: User) -> set[str]:
    """
    Launch until files are trusted by their times, and do what imported does.

    An edit of a file that is quite new may leave the same time.
    """
    deadline = time.monotonic() + DEADLINE
    while True:
        found = imported(user, 'one', 'one')
        if found.isdisjoint(HEAVY) or time.monotonic() > deadline:
            return found


def of_features(found: set[str], names: tuple[str, ...]) -> set[str]:
    """Return the imported modules of some sub-packages and modules."""
    whole = {f'{PACKAGE}.{name}' for name in names}
    inside = tuple(f'{name}.' for name in whole)
    return {m for m in found if m in whole or m.startswith(inside)}


@pytest.mark.parametrize('name', [*UNUSED, *UNUSED_MODULES, *OF_WORKSPACES])
def test_name_of_unused_feature_exists(name: str) -> None:
    assert importlib.util.find_spec(f'{PACKAGE}.{name}') is not None


def test_launch_without_changes_imports_no_unused_feature(user: User) -> None:
    user.package('one')
    user.launch('one', 'one')
    found = imported_without_changes(user)
    assert f'{PACKAGE}.run' in found
    assert found.isdisjoint(HEAVY), found & HEAVY
    assert not of_features(found, UNUSED + UNUSED_MODULES)


def test_launch_without_workspace_imports_no_builds(
    user: User, tmp_path: Path
) -> None:
    folder = tmp_path / 'elsewhere'
    folder.mkdir()
    (folder / 'alone.yaml').write_text('launch: [executable: {cmd: "true"}]\n')
    found = imported(user, 'alone.yaml', cwd=folder)
    assert f'{PACKAGE}.run' in found
    assert not of_features(found, UNUSED + UNUSED_MODULES + OF_WORKSPACES)


def test_change_asks_colcon(user: User) -> None:
    folder = user.package('one')
    user.launch('one', 'one')
    (folder / 'config' / 'more.txt').write_text('more\n')
    assert BUILDING in imported(user, 'one', 'one')


def test_known_package_is_built_without_identifying_it(user: User) -> None:
    folder = user.package('one')
    user.launch('one', 'one')
    imported_without_changes(user)
    (folder / 'config' / 'more.txt').write_text('more\n')
    found = imported(user, 'one', 'one')
    assert BUILDING in found
    assert found.isdisjoint(IDENTIFYING), found & IDENTIFYING
