# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What Tab offers, asked for as the shell code of argcomplete does."""

from collections.abc import Callable
from pathlib import Path
import pkgutil
import time

import colcon_yamllaunch
from colcon_yamllaunch.observers.log_store import INDEX_NAME
import pytest
from support.completion import complete, imported
from support.user import User

ARGUMENTS = """\
launch:
  - arg:
      name: mode
      default: fast
      choice: [{value: fast}, {value: slow}]
  - arg: {name: depth}
  - bool_arg: {name: loud, default: 'false'}
  - executable: {cmd: touch started}
"""
SLEEPER = """\
launch:
  - executable: {name: sleeper, cmd: sleep 1000}
  - executable: {name: typist, cmd: cat, emulate_tty: true}
  - node: {exec: sh, args: -c cat, name: camera, namespace: left}
  - node: {exec: sh, args: -c cat, name: camera, namespace: right}
"""
Complete = Callable[[str], list[str]]


@pytest.fixture
def completes(user: User) -> Complete:
    """Complete a line in the user's workspace, and leave no trace there."""

    def run(line: str) -> list[str]:
        before = files(user.root)
        found = complete(line, user.root, user.environment)
        assert files(user.root) == before
        return sorted(found)

    return run


def files(root: Path) -> set[str]:
    return {str(path.relative_to(root)) for path in root.rglob('*')}


def test_packages(user: User, completes: Complete) -> None:
    user.package('alpha')
    user.package('beta')
    user.manifest('gamma')
    user.write('src/py/setup.py', "setup(name='delta')\n")
    user.write('src/off/CMakeLists.txt', 'project(off)\n')
    user.write('src/off/COLCON_IGNORE', '')
    for verb in ('launch', 'run'):
        assert completes(f'colcon {verb} ') == [
            *('alpha', 'beta', 'delta', 'gamma')
        ]
    assert completes('colcon launch al') == ['alpha']
    assert completes('colcon launch --no-build be') == ['beta']
    # the word behind is no format
    assert completes('colcon launch --check be') == ['beta']
    assert completes('colcon launch --check alpha a') == ['alpha.yaml']
    dependencies = completes('colcon create new --dependencies alpha ')
    assert {'alpha', 'beta', 'delta', 'gamma'} <= set(dependencies)


def test_launch_files(user: User, completes: Complete) -> None:
    folder = user.package('alpha')
    (folder / 'launch' / 'more.launch.xml').write_text('<launch/>')
    (folder / 'config' / 'parameters.yaml').write_text('a: 1\n')
    assert completes('colcon launch alpha ') == [
        'alpha.yaml',
        'more.launch.xml',
    ]
    assert completes('colcon launch alpha --why m') == ['more.launch.xml']
    assert completes('colcon launch alpha launch/m') == [
        'launch/more.launch.xml'
    ]


def test_launch_files_by_path(user: User, completes: Complete) -> None:
    user.package('alpha', ARGUMENTS)
    assert completes('colcon launch src/') == ['src/alpha/']
    assert completes('colcon launch src/alpha/launch/') == [
        'src/alpha/launch/alpha.yaml'
    ]
    # config/hello.txt is no launch file
    assert completes('colcon launch src/alpha/config/') == []
    assert completes('colcon launch src/alpha/launch/alpha.yaml d') == [
        'depth:='
    ]


def test_launch_arguments(user: User, completes: Complete) -> None:
    user.package('alpha', ARGUMENTS)
    start = 'colcon launch alpha alpha.yaml '
    assert completes(start) == ['depth:=', 'loud:=', 'mode:=']
    assert completes(start + 'de') == ['depth:=']
    assert completes(start + 'mode:=slow --why ') == ['depth:=', 'loud:=']
    # bash keeps what is in front of the last word break
    assert completes(start + 'mode:') == ['=']
    assert completes(start + 'mode:=') == ['fast', 'slow']
    assert completes(start + 'mode:=s') == ['slow']
    assert completes(start + 'loud:=') == ['false', 'true']
    assert completes(start + 'depth:=') == []
    assert complete(
        start + 'mode:=s', user.root, user.environment, wordbreaks=' '
    ) == ['mode:=slow']


def test_included_arguments(user: User, completes: Complete) -> None:
    user.package('alpha', ARGUMENTS)
    user.package(
        'beta',
        'launch:\n  - include:\n'
        '      file: $(find-pkg-share alpha)/launch/alpha.yaml\n'
        '      arg: [{name: depth, value: "1"}]\n',
    )
    # the launch file itself sets the depth
    assert completes('colcon launch beta beta ') == ['loud:=', 'mode:=']


@pytest.mark.parametrize(
    'text',
    [
        'launch: [',
        'launch:\n  - nonsense: {}\n',
        '\0',
    ],
)
def test_broken_launch_file_offers_nothing(
    user: User, completes: Complete, text: str
) -> None:
    user.package('alpha', text)
    assert completes('colcon launch alpha ') == ['alpha.yaml']
    assert completes('colcon launch alpha alpha.yaml ') == []


def test_nothing_is_run(user: User, completes: Complete) -> None:
    user.package(
        'alpha',
        'launch:\n'
        '  - arg: {name: a, default: $(command "touch ran")}\n'
        '  - include: {file: $(command "touch ran")}\n',
    )
    assert completes('colcon launch alpha alpha.yaml ') == ['a:=']
    assert not (user.root / 'ran').exists()


def test_nothing_heavy_is_imported(user: User) -> None:
    user.package('alpha', ARGUMENTS)
    names = pkgutil.walk_packages(
        colcon_yamllaunch.__path__, 'colcon_yamllaunch.'
    )
    ours = {name for _, name, _ in names}
    # what reads launch files takes longer than all else
    for words, most in (
        ('', 130),
        ('alpha ', 130),
        ('alpha alpha ', 170),
        ('--stop ', 130),
    ):
        modules = imported(
            f'colcon launch {words}', user.root, user.environment
        )
        assert 20 < len(modules & ours) < most
        # what colcon finds packages with
        assert modules.isdisjoint(('catkin_pkg', 'setuptools'))


def test_options(user: User, completes: Complete) -> None:
    user.package('alpha')
    assert completes('colcon launch --no-b') == ['--no-build']
    assert completes('colcon launch alpha --no-b') == ['--no-build']
    assert completes('colcon launch --check=s') == ['sarif']
    assert completes('colcon launch alpha alpha --check=s') == ['sarif']
    assert completes('colcon launch --plan=') == [
        *('dot', 'json', 'mermaid', 'sh', 'text')
    ]
    assert completes('colcon launch --workspace ') == ['src/']
    assert completes('colcon launch alpha alpha --paths src/') == [
        'src/alpha/'
    ]
    # those of the program are its own
    assert completes('colcon run alpha hello.sh --no-b') == []


def test_build_types_and_licenses(completes: Complete) -> None:
    types = ['ament_cmake', 'ament_python', 'cmake']
    assert completes('colcon create --build-type ') == types
    assert completes('colcon create --build-type=') == types
    assert completes('colcon create new --license M') == ['MIT']


def test_folder_of_the_example(user: User, completes: Complete) -> None:
    (user.root / 'src').mkdir(exist_ok=True)
    assert 'src/' in completes('colcon create --example ')
    assert completes('colcon create ') == []


def test_workspace_elsewhere(user: User, tmp_path: Path) -> None:
    user.package('alpha', ARGUMENTS)
    line = f'colcon launch --workspace {user.root} '
    elsewhere = tmp_path / 'elsewhere'
    elsewhere.mkdir()

    def completed(words: str) -> list[str]:
        return complete(line + words, elsewhere, user.environment)

    assert completed('') == ['alpha']
    assert completed('alpha ') == ['alpha.yaml']
    assert completed('alpha alpha mo') == ['mode:=']
    assert not list(elsewhere.iterdir())


def test_executables_of_a_source(user: User, completes: Complete) -> None:
    folder = user.package('alpha')
    with (folder / 'CMakeLists.txt').open('a') as file:
        file.write('add_executable(pump a.cpp)\n# add_executable(old a.c)\n')
    user.write(
        'src/py/setup.py',
        "setup(name='py', entry_points={'console_scripts': [\n"
        "  'square = py.square:main',\n  'cube=py.cube:main']})\n",
    )
    assert completes('colcon run alpha ') == ['hello.sh', 'pump']
    assert completes('colcon run --prefix "gdb --args" alpha p') == ['pump']
    assert completes('colcon run py ') == ['cube', 'square']


def test_what_is_built(user: User, completes: Complete) -> None:
    user.package('alpha', ARGUMENTS)
    user.package('beta')
    user.launch('beta', 'beta')
    # what is installed stays when the source is put aside
    user.write('src/beta/COLCON_IGNORE', '')
    assert completes('colcon launch ') == ['alpha', 'beta']
    assert completes('colcon launch beta ') == ['beta.yaml']
    assert completes('colcon run beta ') == ['hello.sh']
    # one that is new is there at once
    user.package('new')
    assert 'new' in completes('colcon run ')


def test_processes(user: User, completes: Complete, tmp_path: Path) -> None:
    # launches of others may be where temporary files go
    user.environment['TMPDIR'] = str(tmp_path)
    user.package('alpha', SLEEPER)
    launch = user.start('colcon', 'launch', 'alpha', 'alpha.yaml')
    launch.wait_for(r'right/camera: started')
    # the last file that a launch makes by itself
    deadline = time.monotonic() + 60
    while not (user.root / 'log' / INDEX_NAME).exists():
        assert time.monotonic() < deadline
        time.sleep(0.01)
    every = ['left/camera', 'right/camera', 'sleeper', 'typist']
    for option in ('stop', 'restart', 'logs'):
        assert completes(f'colcon launch --{option} ') == every
    # other names when one of them is begun
    assert completes('colcon launch --stop sh-') == ['sh-3', 'sh-4']
    assert completes('colcon launch --stop /r') == ['/right', '/right/camera']
    assert completes('colcon launch --logs -f s') == ['sleeper']
    assert completes('colcon launch --stop sleeper ty') == ['typist']
    assert completes('colcon launch --of alpha --stop s') == ['sleeper']
    assert completes('colcon launch --of other --stop s') == []
    assert completes('colcon launch --attach ') == ['typist']
    assert completes('colcon launch --of ') == sorted(
        ['alpha', 'alpha.yaml', str(launch.process.pid)]
    )
    launch.interrupt()
    assert completes('colcon launch --stop ') == []


def test_sweeps(user: User, completes: Complete) -> None:
    user.package('alpha')
    user.write('src/alpha/launch/alpha.yaml', ARGUMENTS)
    assert completes('colcon sweep al') == ['alpha']
    assert completes('colcon sweep alpha al') == ['alpha.yaml']
    assert completes('colcon sweep alpha alpha.yaml mo') == ['mode:=']
    assert completes('colcon sweep alpha alpha.yaml mode:=s') == ['slow']
    assert completes('colcon sweep alpha alpha.yaml --again ') == [
        *('all', 'failed')
    ]
    assert '--metric' in completes('colcon sweep alpha alpha.yaml --m')
