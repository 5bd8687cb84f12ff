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
SAMPLE = ROOT / 'sample_ws'
#: Where a distribution has the sample workspace, and a clone a link to it.
PACKAGED_SAMPLE = 'colcon_yamllaunch/workspace/create/sample_ws'
#: What colcon and Python make in a sample workspace that is used.
PRODUCTS = (
    *('build/talk/a.py', 'install/setup.bash', 'log/latest/a.log'),
    *('talk/talk.egg-info/PKG-INFO', 'talk/talk/__pycache__/a.pyc'),
    *('talk/.pytest_cache/a', 'src/my_pkg/scripts/__pycache__/a.pyc'),
    'src/my_py_pkg/__pycache__/setup.pyc',
)
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
    clone = copy_clone(folder / 'clone')
    # setuptools adds such a file to an sdist unless told otherwise
    (clone / 'tests').mkdir()
    (clone / 'tests/test_something.py').touch()
    for name in PRODUCTS:
        product = clone / SAMPLE.name / name
        product.parent.mkdir(parents=True, exist_ok=True)
        product.touch()
    subprocess.run(
        [
            *(sys.executable, '-m', 'build', '--no-isolation'),
            *('--outdir', folder / 'dist', clone),
        ],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    return folder / 'dist'


def copy_clone(clone: Path) -> Path:
    """Copy what a distribution is built of, without products."""
    shutil.copytree(
        PACKAGE,
        clone / PACKAGE.name,
        symlinks=True,
        ignore=shutil.ignore_patterns('__pycache__'),
    )
    for name in SOURCES:
        shutil.copy(ROOT / name, clone)
    for name in sample_files():
        copy = clone / SAMPLE.name / name
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(SAMPLE / name, copy)
    return clone


def sample_files() -> set[str]:
    """Return the files of the sample workspace that nobody has built."""
    return {
        str(path.relative_to(SAMPLE))
        for path in SAMPLE.rglob('*')
        if path.is_file()
        and '__pycache__' not in path.parts
        and path.relative_to(SAMPLE).parts[0]
        not in ('build', 'install', 'log')
    }


def package_files() -> set[str]:
    own = {
        str(path.relative_to(ROOT))
        for path in PACKAGE.rglob('*')
        if path.is_file() and path.suffix != '.pyc'
    }
    return own | {f'{PACKAGED_SAMPLE}/{name}' for name in sample_files()}


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


@pytest.fixture(
    scope='module', params=['-py3-none-any.whl', '.tar.gz', 'editable']
)
def environment(
    built: Path,
    request: pytest.FixtureRequest,
    tmp_path_factory: pytest.TempPathFactory,
) -> Path:
    """Return a new environment, with the dependencies of this one."""
    folder = tmp_path_factory.mktemp('environment')
    environment = folder / 'venv'
    venv = [sys.executable, '-m', 'venv', '--without-pip', environment]
    subprocess.run(venv, check=True)
    (site,) = environment.glob('lib/python3*/site-packages')
    pip = [sys.executable, '-m', 'pip', '--python', str(environment)]
    install = [*pip, 'install', '--quiet', '--no-deps', '--no-index']
    install.append('--no-build-isolation')
    dependencies = folder / 'dependencies'
    dependencies.mkdir()
    for entry in Path(sysconfig.get_path('purelib')).iterdir():
        if not entry.name.startswith(PACKAGE.name):
            (dependencies / entry.name).symlink_to(entry)
    (site / 'dependencies.pth').write_text(str(dependencies), 'utf-8')
    if request.param == 'editable':
        clone = copy_clone(folder / 'clone')
        install += ['--editable', str(clone)]
    else:
        install.append(str(built / f'{NAME}{request.param}'))
    subprocess.run(install, check=True)
    imported = subprocess.run(
        [
            environment / 'bin/python',
            *('-c', 'import colcon_yamllaunch as c; print(c.__file__)'),
        ],
        cwd=folder,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    assert imported.stdout.startswith(str(folder)), imported.stdout
    return environment


def colcon(
    environment: Path, *words: str, cwd: Path
) -> subprocess.CompletedProcess[str]:
    """Run colcon of an environment to its successful end."""
    program = 'import sys, colcon_core.command as c; sys.exit(c.main())'
    done = subprocess.run(
        [environment / 'bin/python', '-c', program, *words],
        cwd=cwd,
        env={
            name: value
            for name, value in os.environ.items()
            if not FOREIGN_VARIABLES.match(name)
        }
        | dict.fromkeys(('HOME', 'TMPDIR'), str(environment.parent)),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done


def test_installed_distribution_launches(
    environment: Path, tmp_path: Path
) -> None:
    package = tmp_path / 'ws/src/greeter'
    (package / 'launch').mkdir(parents=True)
    (package / 'CMakeLists.txt').write_text(CMAKE, encoding='utf-8')
    (package / 'launch/hello.yaml').write_text(LAUNCH, encoding='utf-8')
    words = ('greeter', 'hello.yaml', 'who:=there')
    done = colcon(environment, 'launch', *words, cwd=tmp_path / 'ws')
    assert 'hello there' in done.stdout
    assert (tmp_path / 'ws/install/greeter').is_dir()


def test_installed_distribution_has_the_sample_workspace(
    environment: Path, tmp_path: Path
) -> None:
    until = ('--until', 'Heard 2', 'period:=0.1')
    done = colcon(environment, 'launch', '--demo', *until, cwd=tmp_path)
    assert 'colcon create --example' in done.stderr
    assert [*environment.parent.glob('colcon-demo-*')] == []
    assert [*tmp_path.iterdir()] == []
    colcon(environment, 'create', '--example', cwd=tmp_path)
    copy = tmp_path / 'sample_ws'
    found = {p.relative_to(copy) for p in copy.rglob('*') if p.is_file()}
    assert {str(path) for path in found} == sample_files()
    assert (copy / 'src/my_pkg/scripts/counter.py').stat().st_mode & 0o100
    colcon(environment, 'launch', 'talk', 'talk.yaml', *until, cwd=copy)
