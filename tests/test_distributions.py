# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The wheel and the sdist of a release: their contents, and their use."""

import os
from pathlib import Path
import re
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import zipfile

import colcon_yamllaunch
import pytest
from support.user import FOREIGN_VARIABLES

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / 'colcon_yamllaunch'
VERSION = colcon_yamllaunch.__version__
NAME = f'colcon_yamllaunch-{VERSION}'
#: What the sdist has beside the package and what setuptools writes.
SOURCES = {
    *('CHANGELOG.md', 'LICENSE', 'MANIFEST.in', 'README.md', 'setup.cfg'),
    *('setup.py', 'stdeb.cfg'),
}
WRITTEN = {'PKG-INFO'}
LAUNCH = """\
launch:
  - arg: {name: who, default: world}
  - executable: {cmd: echo hello $(var who)}
"""
CMAKE = """\
cmake_minimum_required(VERSION 3.16)
project(greeter NONE)
install(DIRECTORY launch DESTINATION share/greeter)
"""

pytestmark = pytest.mark.full


@pytest.fixture(scope='module')
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a wheel and an sdist of the clone."""
    pytest.importorskip('build', reason='needs the extra "test"')
    folder = tmp_path_factory.mktemp('distributions')
    clone = folder / 'clone'
    shutil.copytree(
        PACKAGE,
        clone / PACKAGE.name,
        ignore=shutil.ignore_patterns('__pycache__'),
    )
    for name in SOURCES:
        shutil.copy(ROOT / name, clone)
    # setuptools adds such a file to an sdist unless told otherwise
    (clone / 'tests').mkdir()
    (clone / 'tests/test_something.py').touch()
    subprocess.run(
        [
            *(sys.executable, '-m', 'build', '--no-isolation'),
            *('--outdir', folder / 'dist', clone),
        ],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    return folder / 'dist'


def package_files() -> set[str]:
    return {
        str(path.relative_to(ROOT))
        for path in PACKAGE.rglob('*')
        if path.is_file() and path.suffix != '.pyc'
    }


def test_wheel_has_the_package_and_its_license(built: Path) -> None:
    with zipfile.ZipFile(built / f'{NAME}-py3-none-any.whl') as wheel:
        names = set(wheel.namelist())
        metadata = wheel.read(f'{NAME}.dist-info/METADATA').decode()
    package = {name for name in names if '.dist-info/' not in name}
    assert package == package_files()
    for name in (
        *('py.typed', 'sweep/report.css'),
        *('workspace/create/template/license_MIT.em',),
    ):
        assert f'colcon_yamllaunch/{name}' in package
    assert f'{NAME}.dist-info/licenses/LICENSE' in names or (
        # setuptools before 77
        f'{NAME}.dist-info/LICENSE' in names
    )
    assert 'Apache-2.0' in metadata
    assert f'\nVersion: {VERSION}\n' in metadata


def test_sdist_has_the_package_and_no_test(built: Path) -> None:
    with tarfile.open(built / f'{NAME}.tar.gz') as archive:
        names = {
            member.name.removeprefix(f'{NAME}/')
            for member in archive
            if member.isfile()
        }
    assert names == package_files() | SOURCES | WRITTEN


def test_changelog_describes_the_version() -> None:
    text = (ROOT / 'CHANGELOG.md').read_text(encoding='utf-8')
    releases = re.findall(r'^## \[(.*?)\] - \d{4}-\d\d-\d\d$', text, re.M)
    assert VERSION in releases


@pytest.mark.parametrize('suffix', ['-py3-none-any.whl', '.tar.gz'])
def test_installed_distribution_launches(
    built: Path, suffix: str, tmp_path: Path
) -> None:
    """In a new environment, with the dependencies of this one."""
    environment = tmp_path / 'venv'
    venv = [sys.executable, '-m', 'venv', '--without-pip', environment]
    subprocess.run(venv, check=True)
    (site,) = environment.glob('lib/python3*/site-packages')
    subprocess.run(
        [
            *(sys.executable, '-m', 'pip', 'install', '--quiet', '--no-deps'),
            *('--no-index', '--no-build-isolation', '--target', site),
            built / f'{NAME}{suffix}',
        ],
        check=True,
    )
    dependencies = site / 'dependencies.pth'
    dependencies.write_text(sysconfig.get_path('purelib'), encoding='utf-8')
    package = tmp_path / 'ws/src/greeter'
    (package / 'launch').mkdir(parents=True)
    (package / 'CMakeLists.txt').write_text(CMAKE, encoding='utf-8')
    (package / 'launch/hello.yaml').write_text(LAUNCH, encoding='utf-8')
    colcon = 'import sys, colcon_core.command as c; sys.exit(c.main())'
    launch = subprocess.run(
        [
            *(environment / 'bin/python', '-c', colcon),
            *('launch', 'greeter', 'hello.yaml', 'who:=there'),
        ],
        cwd=tmp_path / 'ws',
        env={
            name: value
            for name, value in os.environ.items()
            if not FOREIGN_VARIABLES.match(name)
        }
        | {'HOME': str(tmp_path), 'TMPDIR': str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert launch.returncode == 0, launch.stderr
    assert 'hello there' in launch.stdout
    assert (tmp_path / 'ws/install/greeter').is_dir()
