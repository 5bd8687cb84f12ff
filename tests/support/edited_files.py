# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
A workspace with files of all kinds, each with a word that some process says.

`base` has a header and an interface, `flow` is compiled with them and has
scripts, files with parameters and launch files, `brain` is a Python package
below a symbolic link and imports `pylib`. Each process prints at its start
what it was made from: a word of each file that it comes from.
"""

from pathlib import Path
import re

from support.manifest import manifest

#: The word of a file.
WORD = re.compile(r'\bv\d+\b')
FIRST = 'v0'

BASE_CMAKE = """\
cmake_minimum_required(VERSION 3.16)
project(base NONE)
# as the generators of interfaces do
add_custom_command(OUTPUT word_msg.h DEPENDS msg/Word.msg
  COMMAND ${CMAKE_COMMAND} -E copy ${CMAKE_CURRENT_SOURCE_DIR}/msg/Word.msg
    word_msg.h)
add_custom_target(generate ALL DEPENDS word_msg.h)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/word_msg.h DESTINATION include/base)
install(DIRECTORY include/ DESTINATION include)
install(FILES baseConfig.cmake DESTINATION share/base/cmake)
"""
BASE_CONFIG = 'set(base_INCLUDE ${CMAKE_CURRENT_LIST_DIR}/../../../include)\n'
FLOW_CMAKE = """\
cmake_minimum_required(VERSION 3.16)
project(flow C)
find_package(base REQUIRED)
include_directories(${base_INCLUDE} ${PROJECT_SOURCE_DIR}/../../elsewhere)
add_compile_definitions(BUILT="v0")
add_library(word SHARED src/word.c)
add_executable(loop src/loop.c)
target_link_libraries(loop word)
add_executable(other src/other.c)
set_target_properties(loop PROPERTIES INSTALL_RPATH $ORIGIN/..)
install(TARGETS word DESTINATION lib)
install(TARGETS loop other DESTINATION lib/flow)
install(PROGRAMS scripts/talk.py DESTINATION lib/flow)
install(FILES scripts/helper.py DESTINATION lib/flow)
install(DIRECTORY launch config DESTINATION share/flow)
"""
PROGRAM = """\
#include <stdio.h>
#include <unistd.h>
#include <base/base.h>
#define string static const char *
#include <base/word_msg.h>
;
{declared}
int main(void) {{ (void)WORD; printf("{name} says %s\\n", {words});
  fflush(stdout); for (;;) pause(); }}
"""
LOOP = PROGRAM.format(
    name='loop',
    declared='#include <fast.h>\nconst char * word(void);',
    words='"v0" , word(), FAST',
).replace('%s', '%s %s %s')
OTHER = PROGRAM.format(
    name='other', declared='', words='"v0" , BUILT, BASE, WORD'
).replace('%s', '%s %s %s %s')
#: It takes its time to end, so that there are edits meanwhile.
TALK = """\
#!/usr/bin/env python3
import signal, sys, time
import helper
def end(*_):
    time.sleep(0.2)
    sys.exit(0)
signal.signal(signal.SIGINT, end)
texts = [open(p).read() for p in sys.argv if p.endswith(('.yaml', '.rviz'))]
words = [w for t in texts for w in t.split()]
words = [w for w in words if w[0] == 'v' and w[1:].isdigit()]
print('talk says', 'v0', helper.WORD, *words, flush=True)
while True: time.sleep(1000)
"""
THINK = """\
import os, signal, sys, time
import pylib.words

def main():
    signal.signal(signal.SIGINT, lambda *_: os._exit(0))
    print('mind says', 'v0', pylib.words.WORD, sys.argv[1],
        os.environ['SAID'], flush=True)
    while True: time.sleep(1000)
"""
SETUP = """\
from setuptools import setup
setup(
    name='{name}', version='0.1.0', packages=['{name}'],
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/{name}']),
        ('share/{name}', ['package.xml']),
    ],
    entry_points={{'console_scripts': {scripts}}},
)
"""
SETUP_CFG = """\
[develop]
script_dir=$base/lib/{name}
[install]
install_scripts=$base/lib/{name}
"""
DEMO = """\
launch:
- node:
    pkg: flow
    exec: talk.py
    name: talk
    args: >
      $(find-pkg-share flow)/config/view.rviz
      $(find-pkg-share flow)/config/linked.yaml
    param: [{from: $(find-pkg-share flow)/config/talk.yaml}]
- node: {pkg: flow, exec: loop, name: loop}
- node: {pkg: flow, exec: other, name: other}
- node:
    pkg: brain
    exec: mind
    name: mind
    args: v0
    env: [{name: SAID, value: v0}]
- include: {file: $(find-pkg-share flow)/launch/more.yaml}
"""
FLOW_MANIFEST = manifest(
    'flow', 'cmake', '<depend>base</depend><exec_depend>brain</exec_depend>'
)
PARAMETERS = 'talk:\n  ros__parameters:\n    word: v0\n'
FURTHER_CMAKE = """\
cmake_minimum_required(VERSION 3.16)
project({name} NONE)
install(PROGRAMS run.py DESTINATION lib/{name})
"""
FURTHER = """\
#!/usr/bin/env python3
import signal
print('{name} says v0', flush=True)
signal.signal(signal.SIGINT, signal.SIG_DFL)
signal.pause()
"""

ROBOT_CMAKE = """\
cmake_minimum_required(VERSION 3.16)
project(robot NONE)
install(PROGRAMS camera.py DESTINATION lib/robot)
install(DIRECTORY launch config DESTINATION share/robot)
"""
CAMERA = """\
#!/usr/bin/env python3
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.lifecycle import LifecycleNode

class Camera(LifecycleNode):
    def on_activate(self, state):
        word = self.declare_parameter('word', '').value
        print('camera says', 'v0', word, flush=True)
        return super().on_activate(state)

try:
    rclpy.init()
    rclpy.spin(Camera('camera'))
except (KeyboardInterrupt, ExternalShutdownException):
    pass
"""
ROBOT = """\
launch:
- lifecycle_node:
    pkg: robot
    exec: camera.py
    name: camera
    namespace: ''
    autostart: true
    param: [{from: $(find-pkg-share robot)/config/camera.yaml}]
- node_container:
    pkg: rclcpp_components
    exec: component_container
    name: box
    namespace: ''
    composable_node:
    - pkg: composition
      plugin: composition::Parameters
      name: parameters
      param: [{from: $(find-pkg-share robot)/config/box.yaml}]
"""
VALUES = '{name}:\n  ros__parameters:\n    word: v0\n'

#: A launch file in Python, with a module beside it.
THIRD = """\
import pathlib, sys
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import seconds
from launch import LaunchDescription
from launch.actions import ExecuteProcess

def generate_launch_description():
    first = 'v0'.replace('v', '200000')
    second = seconds.WORD.replace('v', '300000')
    return LaunchDescription([
        ExecuteProcess(cmd=['sleep', first]),
        ExecuteProcess(cmd=['sleep', second]),
    ])
"""

#: Whose words each process says, in this order.
SAYS = {
    'talk': (
        *('flow/scripts/talk.py', 'flow/scripts/helper.py'),
        *('flow/config/view.rviz', 'flow/config/linked.yaml'),
        'flow/config/talk.yaml',
    ),
    'loop': ('flow/src/loop.c', 'flow/src/word.c', '../elsewhere/fast.h'),
    'other': (
        *('flow/src/other.c', 'flow/CMakeLists.txt'),
        *('base/include/base/base.h', 'base/msg/Word.msg'),
    ),
    'mind': (
        'brain/brain/think.py',
        'pylib/pylib/words.py',
        'flow/launch/demo.yaml',
        'flow/launch/demo.yaml',
    ),
}
#: What stands before the number of a word where processes sleep for it.
SLEEPS = {
    'flow/launch/third.launch.py': '200000',
    'flow/launch/seconds.py': '300000',
}
#: The same of nodes of ROS.
SAYS_IN_ROS = {
    'camera': ('robot/camera.py', 'robot/config/camera.yaml'),
    'box': ('robot/config/box.yaml',),
}


def third_files() -> dict[str, str]:
    """Return what includes a launch file in Python."""
    third = '$(find-pkg-share flow)/launch/third.launch.py'
    return {
        'flow/launch/third.launch.py': THIRD,
        'flow/launch/seconds.py': "WORD = 'v0'\n",
        'flow/launch/demo.yaml': f'{DEMO}- include: {{file: {third}}}\n',
    }


def robot_files() -> dict[str, str]:
    """Return the files of a package with a lifecycle node and a component."""
    return {
        'robot/package.xml': manifest(
            'robot',
            'cmake',
            '<exec_depend>rclcpp_components</exec_depend>'
            '<exec_depend>composition</exec_depend>',
        ),
        'robot/CMakeLists.txt': ROBOT_CMAKE,
        'robot/camera.py': CAMERA,
        'robot/config/camera.yaml': VALUES.format(name='camera'),
        'robot/config/box.yaml': VALUES.format(name='parameters'),
        'robot/launch/robot.yaml': ROBOT,
        'flow/launch/demo.yaml': DEMO
        + '- include: {file: $(find-pkg-share robot)/launch/robot.yaml}\n',
        'flow/package.xml': FLOW_MANIFEST.replace(
            '<depend>', '<exec_depend>robot</exec_depend><depend>'
        ),
    }


def whole_files() -> dict[str, str]:
    """Return the text of each file, by its package and name in that."""
    return {
        'base/package.xml': manifest('base', 'cmake'),
        'base/CMakeLists.txt': BASE_CMAKE,
        'base/baseConfig.cmake': BASE_CONFIG,
        'base/include/base/base.h': '#define BASE "v0"\n',
        'base/msg/Word.msg': 'string WORD = "v0"\n',
        # of no package
        '../elsewhere/fast.h': '#define FAST "v0"\n',
        'flow/package.xml': FLOW_MANIFEST,
        'flow/CMakeLists.txt': FLOW_CMAKE,
        'flow/src/word.c': 'const char * word(void) { return "v0"; }\n',
        'flow/src/loop.c': LOOP,
        'flow/src/other.c': OTHER,
        'flow/scripts/talk.py': TALK,
        'flow/scripts/helper.py': "WORD = 'v0'\n",
        'flow/config/talk.yaml': PARAMETERS,
        'flow/config/view.rviz': 'Displays: v0\n',
        'flow/config/linked.yaml': 'linked: v0\n',
        'flow/launch/demo.yaml': DEMO,
        'flow/launch/more.yaml': more([], []),
        **_python_package('pylib', [], {'words.py': "WORD = 'v0'\n"}),
        **_python_package(
            'brain',
            ['mind = brain.think:main'],
            {'think.py': THINK},
            '<exec_depend>pylib</exec_depend>',
        ),
    }


def more(sleeps: list[int], packages: list[str]) -> str:
    """Return the launch file that is included."""
    return 'launch:\n' + ''.join(
        [
            *(
                f'- executable: {{cmd: sleep {n}, name: further}}\n'
                for n in (1000, *sleeps)
            ),
            *(
                f'- node: {{pkg: {name}, exec: run.py, name: {name}}}\n'
                for name in packages
            ),
        ]
    )


def further_package(name: str) -> dict[str, str]:
    """Return the files of a package that comes and goes."""
    return {
        f'{name}/package.xml': manifest(name, 'cmake'),
        f'{name}/CMakeLists.txt': FURTHER_CMAKE.format(name=name),
        f'{name}/run.py': FURTHER.format(name=name),
    }


def lay_out(root: Path) -> None:
    """
    Make what is no plain file of a workspace: its symbolic links.

    :param root: The workspace, behind all links
    """
    (root / 'elsewhere/brain').mkdir(parents=True)
    (root / 'src').mkdir()
    (root / 'src/brain').symlink_to('../elsewhere/brain')
    linked = root / 'src/flow/config/linked.yaml'
    linked.parent.mkdir(parents=True)
    linked.symlink_to(root / 'linked.yaml')


def _python_package(
    name: str, scripts: list[str], modules: dict[str, str], depends: str = ''
) -> dict[str, str]:
    return {
        f'{name}/package.xml': manifest(name, 'ament_python', depends),
        f'{name}/setup.py': SETUP.format(name=name, scripts=scripts),
        f'{name}/setup.cfg': SETUP_CFG.format(name=name),
        f'{name}/resource/{name}': '',
        f'{name}/{name}/__init__.py': '',
        **{f'{name}/{name}/{k}': text for k, text in modules.items()},
    }
