# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A launch that builds nothing imports nothing that takes long."""

import re
import time

from support.user import User

#: What makes `colcon build` slow to start, and what only mistakes, builds and
#: other sorts of launch files need.
HEAVY = {
    'catkin_pkg',
    'colcon_yamllaunch.language.plan.plan_text',
    'colcon_yamllaunch.language.syntax.xml_reader',
    'colcon_yamllaunch.runtime.control.client',
    'colcon_yamllaunch.runtime.record.junit',
    'colcon_yamllaunch.verb.launching.annotations',
    'colcon_yamllaunch.verb.sessions.attaching',
    'colcon_yamllaunch.verb.launching.inspect_launch',
    'colcon_yamllaunch.workspace.colcon.colcon_adapter',
    'difflib',
    'hashlib',
    'pyparsing',
    'setuptools',
    'xml.etree.ElementTree',
}


def test_launch_without_changes_imports_nothing_heavy(user: User) -> None:
    user.package('one')
    user.launch('one', 'one')
    # until then, an edit might leave the same time
    time.sleep(2.1)
    user.launch('one', 'one')
    user.environment['PYTHONPROFILEIMPORTTIME'] = '1'
    output = user.launch('one', 'one')
    imported = set(re.findall(r'^import time: .*\| +(\S+)$', output, re.M))
    assert 'colcon_yamllaunch.runtime.course.engine' in imported
    assert imported.isdisjoint(HEAVY), imported & HEAVY


#: What colcon uses to find out what it was told.
IDENTIFYING = {'catkin_pkg.package', 'distlib', 'pyparsing', 'setuptools'}


def test_change_asks_colcon(user: User) -> None:
    folder = user.package('one')
    user.launch('one', 'one')
    (folder / 'config' / 'more.txt').write_text('more\n')
    user.environment['PYTHONPROFILEIMPORTTIME'] = '1'
    output = user.launch('one', 'one')
    imported = set(re.findall(r'^import time: .*\| +(\S+)$', output, re.M))
    assert 'colcon_yamllaunch.workspace.colcon.colcon_adapter' in imported


def test_known_package_is_built_without_identifying_it(user: User) -> None:
    folder = user.package('one')
    user.launch('one', 'one')
    time.sleep(2.1)
    user.launch('one', 'one')
    (folder / 'config' / 'more.txt').write_text('more\n')
    user.environment['PYTHONPROFILEIMPORTTIME'] = '1'
    output = user.launch('one', 'one')
    imported = set(re.findall(r'^import time: .*\| +(\S+)$', output, re.M))
    assert 'colcon_yamllaunch.workspace.colcon.colcon_adapter' in imported
    assert imported.isdisjoint(IDENTIFYING), imported & IDENTIFYING
