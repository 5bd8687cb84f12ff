# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Paths of the workspace here become those of the workspace there."""

import json

from colcon_yamllaunch.plan.plan import (
    Component,
    ParameterFile,
    Plan,
    Process,
    SetParameter,
    Timer,
)
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.remote.remote_paths import (
    is_of_system,
    paths_in,
    RemotePaths,
    sent_variables,
)
from hypothesis import given
from hypothesis import strategies as st
import pytest

AT = Position('a.yaml', 1, 1)
PATHS = RemotePaths({'/home/me/ws': '/srv/ws', '/home/me/ws/log': '/logs'})


@pytest.mark.parametrize(
    ('here', 'there'),
    [
        ('/home/me/ws', '/srv/ws'),
        ('/home/me/ws/', '/srv/ws/'),
        ('/home/me/ws/install/a', '/srv/ws/install/a'),
        ('file:=/home/me/ws/a.yaml', 'file:=/srv/ws/a.yaml'),
        ('--file=/home/me/ws/a', '--file=/srv/ws/a'),
        ('file:///home/me/ws/a', 'file:///srv/ws/a'),
        ('-I/home/me/ws/a', '-I/home/me/ws/a'),
        ('/home/me/ws/a:/home/me/ws:/usr', '/srv/ws/a:/srv/ws:/usr'),
        ('["/home/me/ws/a", "/home/me/ws"]', '["/srv/ws/a", "/srv/ws"]'),
        ('cd /home/me/ws; ls /home/me/ws.', 'cd /srv/ws; ls /srv/ws.'),
        ('<mesh filename="/home/me/ws/m"/>', '<mesh filename="/srv/ws/m"/>'),
        # what lies in a folder of its own
        ('/home/me/ws/log/a', '/logs/a'),
        # and what is something else
        ('/home/me/ws2/a', '/home/me/ws2/a'),
        ('/home/me/ws.old/a', '/home/me/ws.old/a'),
        ('/home/me/ws-2', '/home/me/ws-2'),
        ('/mnt/home/me/ws/a', '/mnt/home/me/ws/a'),
        ('~/home/me/ws/a', '~/home/me/ws/a'),
        ('/home/me', '/home/me'),
    ],
)
def test_paths_in_a_text_are_replaced(here, there):
    assert PATHS.text(here) == there


def test_a_path_is_replaced_once():
    paths = RemotePaths({'/a': '/a/a'})
    assert paths.text('/a/b:/a') == '/a/a/b:/a/a'


def test_folders_that_are_the_same_there_stay():
    paths = RemotePaths({'/ws': '/ws'})
    assert paths.is_same
    assert paths.text('/ws/a') == '/ws/a'
    # also within those that are not
    paths = RemotePaths({'/ws': '/srv', '/ws/log': '/ws/log'})
    assert paths.text('/ws/log/a /ws/b') == '/ws/log/a /srv/b'


def test_a_folder_is_known_by_both_its_names(tmp_path):
    real = tmp_path / 'real'
    real.mkdir()
    link = tmp_path / 'link'
    link.symlink_to(real)
    paths = RemotePaths({str(link): '/srv'})
    assert paths.text(f'{link}/a {real}/b') == '/srv/a /srv/b'


def test_paths_in_json_are_replaced():
    paths = RemotePaths({'/home/jürgen/ws': '/srv/wö'})
    text = json.dumps(['/home/jürgen/ws/a'])
    assert json.loads(paths.text(text)) == ['/srv/wö/a']


def test_nothing_is_replaced_without_folders():
    assert RemotePaths({}).text('/a') == '/a'
    assert RemotePaths({'/': '/srv'}).text('/a') == '/a'


@given(st.text('/abws.:= ', max_size=40))
def test_only_whole_paths_are_replaced(text):
    paths = RemotePaths({'/ws': '/THERE'})
    found = paths.text(text)
    assert found.replace('/THERE', '/ws') == text
    assert paths.text(found) == found or '/ws' in found


def test_all_paths_of_a_plan_are_replaced():
    ws = '/home/me/ws'
    parameter = SetParameter('map', f'"{ws}/m"', AT)
    file = ParameterFile(f'path: {ws}/p\n', (parameter,))
    process = Process(
        'a',
        (f'{ws}/install/a/lib/a/a', '--params-file', file),
        f'{ws}/src',
        AT,
        environment=(('GONE', None), ('PATHS', f'{ws}/a:/usr:{ws}/b')),
        parameters=(parameter,),
    )
    component = Component(
        'c', 'p', 'p::C', '/box', AT, (), parameters=(parameter,)
    )
    plan = Plan((Timer(1.0, (process,)), component))
    mapped = PATHS.plan(plan)
    assert ws not in repr(mapped)
    (there,) = mapped.processes()
    assert there.argv[0] == '/srv/ws/install/a/lib/a/a'
    assert there.argv[2].content == 'path: /srv/ws/p\n'
    assert there.cwd == '/srv/ws/src'
    assert there.environment == (
        ('GONE', None),
        ('PATHS', '/srv/ws/a:/usr:/srv/ws/b'),
    )
    # where it is written is where it is written
    assert there.position == AT


@pytest.mark.parametrize(
    ('text', 'paths'),
    [
        ('/a/b', ['/a/b']),
        ('file:=/data/../map.yaml', ['/map.yaml']),
        ('/a:/b:relative:/c', ['/a', '/b', '/c']),
        ('file:///a/b', ['/a/b']),
        ('["/a", "/b"]', ['/a', '/b']),
        ('relative/path', []),
        ('/', []),
        ('', []),
    ],
)
def test_paths_are_found_in_words(text, paths):
    assert list(paths_in(text)) == paths


def test_device_belongs_to_the_system():
    assert is_of_system('/dev/video0')
    assert is_of_system('/dev')
    assert not is_of_system('/development')
    assert not is_of_system('/opt/maps')


def test_only_some_variables_are_sent():
    variables = {
        'ROS_DOMAIN_ID': '7',
        'ROS_DISTRO': 'jazzy',
        'ROS_LOG_DIR': '/logs',
        'RMW_IMPLEMENTATION': 'rmw_zenoh_cpp',
        'CYCLONEDDS_URI': 'file:///a',
        'FASTRTPS_DEFAULT_PROFILES_FILE': '/a',
        'TERM': 'xterm',
        'PATH': '/bin',
        'SECRET': 'x',
        'MINE': 'y',
    }
    assert list(sent_variables(variables, ['MINE'])) == [
        'ROS_DOMAIN_ID',
        'RMW_IMPLEMENTATION',
        'CYCLONEDDS_URI',
        'FASTRTPS_DEFAULT_PROFILES_FILE',
        'TERM',
        'MINE',
    ]
    assert sent_variables({'ROS_DISTRO': 'a'}, ['ROS_DISTRO'])
