# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Small workspaces, and colcon in a process of its own."""

from collections.abc import Callable, Mapping
import json
import os
from pathlib import Path
import subprocess
import sys
from typing import Any

import colcon_yamllaunch
import pytest
from support.forks import Forks
from support.manifest import manifest

REPOSITORY = Path(colcon_yamllaunch.__file__).parent.parent
#: Seconds; a loaded machine needs some.
DEADLINE = 120

CMAKE = """\
cmake_minimum_required(VERSION 3.16)
project({name} NONE)
{find}
{install}
"""
SETUP = """\
from setuptools import setup

setup(
    name='{name}',
    version='0.1.0',
    packages=['{name}'],
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/{name}']),
        ('share/{name}', ['package.xml']),
        ('share/{name}/launch', ['launch/talk.yaml']),
    ],
    entry_points={{'console_scripts': ['talk = {name}.talk:main']}},
)
"""
SETUP_CFG = """\
[develop]
script_dir=$base/lib/{name}
[install]
install_scripts=$base/lib/{name}
"""
DRIVER = """\
import json
import os
from pathlib import Path
import sys

from colcon_core import location

location.set_default_config_path(path=Path('config'), env_var='COLCON_HOME')
location.set_default_log_path(
    base_path=None, env_var='COLCON_LOG_PATH', subdirectory='launch')
location.create_log_path('launch')

from colcon_yamllaunch.workspace.colcon.colcon_adapter import Colcon
from colcon_yamllaunch.workspace.colcon.colcon_cache import CachedColcon
from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.workspace.building import update
from colcon_yamllaunch.workspace.environment.sourcing import Environment


def bring_up_to_date(colcon, names, environment, announce, **options):
    return update.bring_up_to_date(
        colcon,
        update.BuildRequest(names, **options),
        Environment(environment),
        announce,
    )


def show(value):
    print('RESULT ' + json.dumps(value, default=str))


"""


class Workspace:
    """A workspace that a test puts together."""

    def __init__(self, root: Path, forks: Forks) -> None:
        self.root = root
        self._forks = forks

    def write(self, path: str, text: str = '', mode: int = 0o644) -> Path:
        """Write a file below the root."""
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding='utf-8')
        file.chmod(mode)
        return file

    def cmake(
        self, name: str, needs: tuple[str, ...] = (), install: str = ''
    ) -> Path:
        """Write a plain CMake package with a launch file."""
        find = '\n'.join(f'find_package({n} QUIET)' for n in needs)
        install += (
            'install(DIRECTORY launch DESTINATION share/${PROJECT_NAME})'
        )
        text = CMAKE.format(name=name, find=find, install=install)
        self.write(f'src/{name}/launch/{name}.yaml', 'launch: []\n')
        return self.write(f'src/{name}/CMakeLists.txt', text).parent

    def manifest(
        self, name: str, build_type: str = 'ament_cmake', depends: str = ''
    ) -> Path:
        """Write a package.xml."""
        text = manifest(name, build_type, depends)
        return self.write(f'src/{name}/package.xml', text).parent

    def ament_cmake(self, name: str, depends: str = '') -> Path:
        """Write an ament_cmake package with a node in scripts/."""
        pytest.importorskip('ament_package', reason='needs the ROS wheels')
        depends += '<buildtool_depend>ament_cmake</buildtool_depend>'
        self.manifest(name, depends=depends)
        install = (
            'install(PROGRAMS scripts/counter.py\n'
            '  DESTINATION lib/${PROJECT_NAME})\n'
            'install(DIRECTORY launch DESTINATION share/${PROJECT_NAME})\n'
            'ament_package()'
        )
        find = 'find_package(ament_cmake REQUIRED)'
        text = CMAKE.format(name=name, find=find, install=install)
        script = '#!/usr/bin/env python3\nprint(1)\n'
        self.write(f'src/{name}/scripts/counter.py', script, 0o755)
        self.write(f'src/{name}/launch/demo.yaml', 'launch: []\n')
        return self.write(f'src/{name}/CMakeLists.txt', text).parent

    def ament_python(self, name: str) -> Path:
        """Write an ament_python package with an entry point."""
        folder = self.manifest(name, 'ament_python')
        self.write(f'src/{name}/setup.py', SETUP.format(name=name))
        self.write(f'src/{name}/setup.cfg', SETUP_CFG.format(name=name))
        self.write(f'src/{name}/resource/{name}')
        self.write(f'src/{name}/{name}/__init__.py')
        self.write(f'src/{name}/{name}/talk.py', 'def main():\n    pass\n')
        self.write(f'src/{name}/launch/talk.yaml', 'launch: []\n')
        return folder

    def environment(self, **variables: str) -> dict[str, str]:
        """Get a clean environment with this Python's programs."""
        programs = str(Path(sys.executable).parent)
        base = {
            'PATH': os.pathsep.join([programs, os.environ['PATH']]),
            'HOME': str(self.root.parent),
            'COLCON_HOME': str(self.root.parent / 'colcon_home'),
            'PYTHONPATH': str(REPOSITORY),
            'LANG': 'C.UTF-8',
        }
        return base | variables

    def start(
        self,
        code: str,
        cwd: Path | None = None,
        environment: Mapping[str, str] | None = None,
        stdin: int | None = None,
    ) -> 'subprocess.Popen[str]':
        """Start code with colcon set up, in a session of its own."""
        return subprocess.Popen(
            [sys.executable, '-c', DRIVER + code],
            cwd=cwd or self.root,
            env=environment or self.environment(),
            stdin=stdin,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )

    def run(
        self,
        code: str,
        cwd: Path | None = None,
        environment: Mapping[str, str] | None = None,
    ) -> tuple[list[Any], str]:
        """Run code with colcon set up; get what it shows and its output."""
        log = self.root.parent / '.output'
        returncode = self._forks.run(
            DRIVER + code,
            cwd or self.root,
            environment or self.environment(),
            log,
            DEADLINE,
        )
        output = log.read_text(encoding='utf-8')
        log.unlink()
        assert returncode == 0, output
        results = [
            json.loads(line.removeprefix('RESULT '))
            for line in output.splitlines()
            if line.startswith('RESULT ')
        ]
        return results, output


@pytest.fixture
def workspace(tmp_path: Path, forks: Forks) -> Workspace:
    root = tmp_path / 'ws'
    root.mkdir()
    return Workspace(root, forks)


@pytest.fixture
def update(workspace: Workspace) -> Callable[..., tuple[Any, str]]:
    """Bring packages up to date; get the outcome and the output."""

    def run(
        *names: str,
        arguments: tuple[str, ...] = (),
        force: bool = False,
        **variables: str,
    ) -> tuple[Any, str]:
        code = (
            f'root = Path({str(workspace.root)!r})\n'
            f'colcon = CachedColcon(root, {arguments!r})\n'
            f'result = bring_up_to_date(colcon, {names!r}, '
            f'dict(os.environ), print, force={force})\n'
            'fresh = [d.name for d in result.decisions if not d.is_stale]\n'
            'show([result.returncode, dict(result.stale), fresh])\n'
        )
        environment = workspace.environment(**variables)
        results, output = workspace.run(code, environment=environment)
        return results[0], output

    return run
