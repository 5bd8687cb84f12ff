# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Actions and substitutions of packages are known without running them."""

from collections.abc import Mapping
from pathlib import Path

from colcon_yamllaunch.workspace.packages import python_modules
from colcon_yamllaunch.workspace.packages.package import Package
from colcon_yamllaunch.workspace.packages.python_modules import (
    ExposedNames,
    python_folders,
)
import pytest

GROUP = 'launch.frontend.launch_extension'
ENTRY = f'[{GROUP}]\nown = {{module}}\n\n[console_scripts]\nno = no:main\n'
ACTION = """\
from launch.action import Action
from launch.frontend import expose_action


@expose_action('{name}')
class Own(Action):
    '''Fails wherever it is imported: @expose_action('in_text').'''

    raise SystemExit
"""


def write(folder: Path, files: Mapping[str, str]) -> None:
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


def install(
    folder: Path, name: str, files: Mapping[str, str], module: str = ''
) -> None:
    """Install a distribution with an extension of its name."""
    entry = ENTRY.format(module=module or name)
    write(folder / f'{name}-1.0.egg-info', {'entry_points.txt': entry})
    write(folder / name, files)


def exposed(
    *folders: Path, packages: tuple[Package, ...] = ()
) -> ExposedNames:
    path = ':'.join(map(str, folders))
    environment = {'PYTHONPATH': path, 'PATH': '/nowhere'}
    return ExposedNames(environment, packages)


def package(folder: Path, name: str, files: Mapping[str, str]) -> Package:
    write(folder / name, files)
    return Package(name, folder / name, 'ros.ament_python')


def test_names_come_from_what_the_module_imports(tmp_path: Path) -> None:
    files = {
        '__init__.py': 'from . import actions\n',
        'actions/__init__.py': 'from .one import Own\nimport own.more.two\n',
        'actions/one.py': ACTION.format(name='one'),
        'actions/unused.py': ACTION.format(name='unused'),
        'more/__init__.py': "NAME = 'alias'\nexpose_substitution(NAME)(int)\n",
        'more/two.py': (
            'from launch import frontend\n\n\n'
            "@frontend.expose_action('two')\n"
            "@frontend.expose_substitution('two-file')\n"
            'def parse(entity, parser):\n    raise SystemExit\n'
        ),
    }
    install(tmp_path, 'own', files)
    found = exposed(tmp_path)
    assert found.actions() == {'one': 'own', 'two': 'own'}
    assert found.substitutions() == {'alias': 'own', 'two-file': 'own'}
    assert found.action('one') == found.substitution('alias') == 'own'
    assert found.action('unused') is found.substitution('one') is None
    assert found.is_installed('own')


@pytest.mark.parametrize(
    'module', ['own.actions', 'own.actions.one:Own', 'own.actions.one']
)
def test_entry_point_may_name_any_module(tmp_path: Path, module: str) -> None:
    files = {
        '__init__.py': '',
        'actions/__init__.py': 'from .one import *\n',
        'actions/one.py': ACTION.format(name='one'),
    }
    install(tmp_path, 'own', files, module)
    assert exposed(tmp_path).action('one') == 'own'


def test_modules_that_only_running_tells_are_all_taken(tmp_path: Path) -> None:
    files = {
        '__init__.py': 'for n in NAMES:\n    importlib.import_module(n)\n',
        'one.py': ACTION.format(name='one'),
        'more/__init__.py': ACTION.format(name='two'),
    }
    install(tmp_path, 'own', files)
    assert set(exposed(tmp_path).actions()) == {'one', 'two'}


def test_damaged_packages_expose_nothing(tmp_path: Path) -> None:
    install(tmp_path, 'own', {'__init__.py': "@expose_action('one'\n"})
    install(tmp_path, 'gone', {}, 'not_there')
    (tmp_path / 'file.egg-info').write_text('Name: file\n')
    found = exposed(tmp_path, tmp_path / 'nowhere')
    assert not found.actions()
    assert not found.substitutions()


def test_first_of_two_distributions_counts(tmp_path: Path) -> None:
    for name in ('overlay', 'underlay'):
        files = {'__init__.py': ACTION.format(name=name)}
        install(tmp_path / name, 'own', files)
    found = exposed(tmp_path / 'overlay', tmp_path / 'underlay')
    assert found.actions() == {'overlay': 'own'}


def test_package_of_ros_itself_is_looked_at_last(tmp_path: Path) -> None:
    write(tmp_path / 'launch', {'__init__.py': ACTION.format(name='newest')})
    install(tmp_path, 'odd', {}, 'launch_ros')
    found = exposed(tmp_path)
    assert found.action('newest') == 'launch'
    assert found.actions() == {'newest': 'launch'}


@pytest.mark.parametrize(
    ('file', 'text'),
    [
        (
            'setup.cfg',
            '[options.entry_points]\nconsole_scripts =\n  a = a:b\n'
            f'{GROUP} =\n  own = own\nother =\n  c = c\n',
        ),
        (
            'setup.py',
            f"setup(entry_points={{'{GROUP}': ['own = own'], 'b': ['c = d']}})"
            '\nraise SystemExit\n',
        ),
        (
            'setup.py',
            f"setup(entry_points={{'{GROUP}': '''\n  own = own\n'''}})\n",
        ),
        (
            'pyproject.toml',
            f'[project]\nname = "own"\n[project.entry-points."{GROUP}"]\n'
            'own = "own"\n[tool.x]\nc = "c"\n',
        ),
    ],
)
@pytest.mark.parametrize('place', ['', 'src/'])
def test_package_of_workspace_is_known_before_its_build(
    tmp_path: Path, file: str, text: str, place: str
) -> None:
    files = {
        file: text,
        f'{place}own/__init__.py': ACTION.format(name='one'),
        f'{place}c/__init__.py': ACTION.format(name='no'),
        f'{place}d/__init__.py': ACTION.format(name='no'),
    }
    found = exposed(packages=(package(tmp_path, 'own', files),))
    assert found.actions() == {'one': 'own'}
    assert not found.is_installed('own')


def test_source_counts_more_than_what_was_built(tmp_path: Path) -> None:
    files = {
        'setup.cfg': f'[options.entry_points]\n{GROUP} =\n  own = own\n',
        'own/__init__.py': ACTION.format(name='new'),
    }
    built = {'__init__.py': ACTION.format(name='old')}
    install(tmp_path / 'install', 'own', built)
    packages = (package(tmp_path / 'src', 'own', files),)
    found = exposed(tmp_path / 'install', packages=packages)
    assert found.actions() == {'new': 'own'}
    assert found.is_installed('own')


def test_source_that_is_elsewhere_hides_nothing(tmp_path: Path) -> None:
    files = {'setup.cfg': f'[options.entry_points]\n{GROUP} =\n  own = own\n'}
    built = {'__init__.py': ACTION.format(name='one')}
    install(tmp_path / 'install', 'own', built)
    packages = (package(tmp_path / 'src', 'ros_name', files),)
    found = exposed(tmp_path / 'install', packages=packages)
    assert found.actions() == {'one': 'own'}


def test_large_modules_are_passed_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(python_modules, 'MAXIMUM_SIZE', 10)
    install(tmp_path, 'own', {'__init__.py': ACTION.format(name='one')})
    assert not exposed(tmp_path).actions()


def test_number_of_modules_is_bounded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(python_modules, 'MAXIMUM_MODULES', 3)
    files = {'__init__.py': 'from . import m0\n'}
    for number in range(9):
        files[f'm{number}.py'] = f'from . import m{number + 1}\n'
    files['m9.py'] = ACTION.format(name='far')
    install(tmp_path, 'own', files)
    assert exposed(tmp_path).action('far') is None


def test_folders_of_an_environment(tmp_path: Path) -> None:
    base, own = tmp_path / 'base', tmp_path / 'own'
    write(base, {'bin/python3': '', 'lib/python3.9/site-packages/a': ''})
    write(
        own,
        {
            'bin/python3': '',
            'lib/python3.9/site-packages/a.pth': f'{tmp_path}/dev\nimport x\n',
            'pyvenv.cfg': (
                f'home = {base}/bin\ninclude-system-site-packages = true\n'
            ),
        },
    )
    (own / 'bin' / 'python3').chmod(0o755)
    write(tmp_path / 'ros', {'local/lib/python3.9/dist-packages/a': ''})
    environment = {
        'PYTHONPATH': f'{tmp_path}/first:relative:{tmp_path}/second',
        'AMENT_PREFIX_PATH': f'{tmp_path}/ros',
        'PATH': f'{own}/bin',
        'HOME': str(tmp_path / 'home'),
    }
    assert python_folders(environment) == [
        f'{tmp_path}/first',
        f'{tmp_path}/second',
        f'{tmp_path}/ros/local/lib/python3.9/dist-packages',
        f'{own}/lib/python3.9/site-packages',
        f'{base}/lib/python3.9/site-packages',
        f'{tmp_path}/dev',
    ]
