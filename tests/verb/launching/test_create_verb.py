# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""`colcon create`, from a user's side."""

import ast
from pathlib import Path
import re
import shlex
import subprocess
import xml.etree.ElementTree as ET

import pytest
from support.user import DEADLINE, User
import yaml

IDENTITY = '[user]\nname = Ada <Ö> & Co\nemail = ada@example.com\n'
LICENSE = Path(__file__).parents[3] / 'LICENSE'


@pytest.fixture
def developer(user: User) -> User:
    """Return a user with an empty workspace, whom git knows."""
    home = Path(user.environment['HOME'])
    (home / '.gitconfig').write_text(IDENTITY, encoding='utf-8')
    user.environment |= {
        'GIT_CONFIG_NOSYSTEM': '1',
        'XDG_CONFIG_HOME': str(home),
    }
    (user.root / 'src').mkdir()
    return user


def create(
    user: User, *words: str, code: int = 0, cwd: Path | None = None
) -> subprocess.CompletedProcess[str]:
    """Run `colcon create` to its end."""
    done = subprocess.run(
        ['colcon', 'create', *words],
        cwd=cwd or user.root,
        env=user.environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=DEADLINE,
        check=False,
    )
    assert done.returncode == code, done.stdout + done.stderr
    assert 'Traceback' not in done.stderr
    return done


def error(user: User, *words: str, cwd: Path | None = None) -> str:
    """Return what `colcon create` complains about; it has made nothing."""
    before = sorted(user.root.rglob('*'))
    done = create(user, *words, code=1, cwd=cwd)
    assert done.stdout == ''
    assert sorted(user.root.rglob('*')) == before
    pattern = r'colcon create: error: ([^\n]*(\n  help: [^\n]*)?)\n'
    found = re.fullmatch(pattern, done.stderr)
    assert found, done.stderr
    return found[1]


def launch_and_test(user: User, made: str, greeting: str) -> None:
    """Type what `colcon create` said, then test the package."""
    command = made.rpartition('Try it:')[2].strip()
    launch = user.start(*shlex.split(command))
    launch.wait_for(f'{greeting} 2')
    logs = user.start('colcon', 'launch', '--logs')
    logs.wait_for(f'{greeting} 1')
    logs.interrupt()
    assert launch.interrupt() == 0, launch.output
    for words in (['test'], ['test-result', '--verbose']):
        test = user.start('colcon', *words)
        assert test.end() == 0, test.output
    assert re.search('[12] tests?, 0 errors, 0 failures', test.output)


@pytest.mark.parametrize(
    ('build_type', 'name', 'executable'),
    [
        ('ament_cmake', 'my_pkg', 'counter.py'),
        ('ament_python', 'my-pkg', 'counter'),
        ('cmake', 'MyPkg', 'counter.py'),
        ('cmake+rclpy', 'my_pkg', 'counter.py'),
    ],
)
def test_package_builds_launches_runs_and_passes_its_tests(
    developer: User,
    build_type: str,
    name: str,
    executable: str,
    ros_domain_id: int,
) -> None:
    if build_type != 'cmake':
        pytest.importorskip('rclpy', reason='needs the ROS wheels')
    developer.environment |= {
        'ROS_DOMAIN_ID': str(ros_domain_id),
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
    }
    build_type, *dependencies = build_type.split('+')
    words = [name, '--node', 'counter', '--build-type', build_type]
    if dependencies:
        words += ['--dependencies', *dependencies]
    done = create(developer, *words)
    file = f'{name}.launch.yaml'
    check = developer.start(
        'colcon', 'launch', name, file, '--check', '--portable'
    )
    assert check.end() == 0, check.output
    launch_and_test(developer, done.stdout, f'Hello from {name}')
    run = developer.start('colcon', 'run', name, executable)
    run.wait_for('Hello 2')
    assert run.interrupt() in (0, 130), run.output


def test_package_says_what_the_user_said(developer: User) -> None:
    # whether ROS is there makes no difference
    developer.environment['AMENT_PREFIX_PATH'] = str(developer.root)
    done = create(
        developer,
        *('my_pkg', '--build-type', 'ament_python', '--license', 'MIT'),
        *('--dependencies', 'rclpy', 'std_msgs', 'std_msgs'),
        *('--description', 'An "odd" & <short>\none, l\'été', '--node', 'a'),
    )
    assert done.stderr == ''
    folder = developer.root / 'src/my_pkg'
    manifest = ET.parse(folder / 'package.xml').getroot()
    values = {child.tag: child.text for child in manifest}
    assert values['name'] == 'my_pkg'
    assert values['description'] == 'An "odd" & <short> one, l\'été'
    assert values['maintainer'] == 'Ada <Ö> & Co'
    assert values['license'] == 'MIT'
    depends = [child.text for child in manifest.findall('depend')]
    assert depends == ['rclpy', 'std_msgs']
    setup = ast.parse((folder / 'setup.py').read_text(encoding='utf-8'))
    constants = {
        node.value
        for node in ast.walk(setup)
        if isinstance(node, ast.Constant)
    }
    expected = {'Ada <Ö> & Co', 'ada@example.com', 'a = my_pkg.a:main'}
    assert expected <= constants
    assert 'Ada <Ö> & Co' in (folder / 'LICENSE').read_text('utf-8')


@pytest.mark.parametrize('build_type', ['ament_cmake', 'cmake'])
def test_files_of_a_cmake_package(developer: User, build_type: str) -> None:
    made = create(developer, 'my_pkg', '--build-type', build_type).stdout
    folder = developer.root / 'src/my_pkg'
    files = [str(f.relative_to(folder)) for f in folder.rglob('*.*')]
    assert sorted(files) == sorted(re.findall(r'^  (\S+)', made, re.MULTILINE))
    script = folder / 'scripts/my_pkg_node.py'
    assert script.stat().st_mode & 0o777 == 0o755
    launch = yaml.safe_load((folder / 'launch/my_pkg.launch.yaml').read_text())
    assert list(launch) == ['launch']
    assert list(developer.root.iterdir()) == [developer.root / 'src']


def test_license_text_is_the_whole_one(developer: User) -> None:
    create(developer, 'my_pkg', '--license', 'Apache-2.0')
    text = (developer.root / 'src/my_pkg/LICENSE').read_text()
    assert text == LICENSE.read_text()
    create(developer, 'other', '--license', 'BSD-3-Clause')
    text = (developer.root / 'src/other/LICENSE').read_text()
    assert 'Redistribution and use' in text


def test_licenses_without_a_text(developer: User) -> None:
    done = create(developer, 'one', '--license', 'MTI')
    assert "did you mean 'MIT'?" in done.stderr
    done = create(developer, 'two', '--license', 'Zlib')
    assert 'Apache-2.0, BSD-3-Clause and MIT' in done.stderr
    assert not (developer.root / 'src/two/LICENSE').exists()
    done = create(developer, 'three')
    assert 'names no license yet' in done.stderr


def test_nothing_is_overwritten(developer: User) -> None:
    create(developer, 'my_pkg')
    readme = developer.write('src/my_pkg/scripts/my_pkg_node.py', 'mine\n')
    assert 'has a package my_pkg already' in error(developer, 'my_pkg')
    assert readme.read_text() == 'mine\n'
    other = developer.write('src/other/notes.txt', 'mine\n')
    message = error(developer, 'other')
    assert message == f'{other.parent} is there already: nothing was written'
    (developer.root / 'src/link').symlink_to('nowhere')
    assert 'is there already' in error(developer, 'link')
    file = str(developer.write('notes', ''))
    assert 'is there already' in error(developer, 'a_b', '--destination', file)


def test_package_elsewhere_in_the_workspace_has_this_name(
    developer: User,
) -> None:
    create(developer, 'my_pkg', '--destination', 'src/group')
    message = error(developer, 'my_pkg')
    assert str(developer.root / 'src/group/my_pkg') in message


def test_package_of_an_underlay_has_this_name(
    developer: User, tmp_path: Path
) -> None:
    index = tmp_path / 'ros/share/ament_index/resource_index/packages'
    index.mkdir(parents=True)
    (index / 'my_pkg').touch()
    developer.environment['AMENT_PREFIX_PATH'] = str(tmp_path / 'ros')
    done = create(developer, 'my_pkg')
    assert 'takes its place' in done.stderr


def test_names(developer: User) -> None:
    assert "'2d' is no name for a package" in error(developer, '2d')
    assert "'none' is no name" in error(developer, 'a_b', '--node', 'none')
    done = create(developer, 'My-pkg')
    assert (
        'REP 144 asks for lower case letters only and underscores in place of '
        "'-', such as my_pkg" in done.stderr
    )
    assert (developer.root / 'src/My-pkg/scripts/My_pkg_node.py').is_file()


def test_dependencies_that_are_misspelt(developer: User) -> None:
    create(developer, 'flow')
    names = ('--dependencies', 'std_msg', 'flow', 'flou', 'boost')
    done = create(developer, 'my_pkg', *names)
    warned = [x for x in done.stderr.splitlines() if 'there is no' in x]
    assert len(warned) == 2
    assert "no package 'std_msg' here: did you mean 'std_msgs'?" in warned[0]
    assert "no package 'flou' here: did you mean 'flow'?" in warned[1]


def test_maintainer(developer: User) -> None:
    who = ['--maintainer-name', 'Ada', '--maintainer-email']
    message = error(developer, 'my_pkg', *who, 'ada@localhost')
    assert 'Invalid email "ada@localhost"' in message
    done = create(developer, 'my_pkg', *who, 'ada@example.com')
    assert 'maintainer' not in done.stderr


@pytest.mark.parametrize(
    ('settings', 'missing', 'maintainer'),
    [
        ('', 'name and e-mail address', 'grace <TODO@example.com>'),
        ('name = Ada', 'e-mail address', 'Ada <TODO@example.com>'),
        ('email = a@example.com', 'name', 'grace <a@example.com>'),
    ],
)
def test_maintainer_whom_git_does_not_know_is_the_login_name(
    developer: User, settings: str, missing: str, maintainer: str
) -> None:
    home = Path(developer.environment['HOME'])
    (home / '.gitconfig').write_text(f'[user]\n{settings}\n')
    developer.environment['LOGNAME'] = 'grace'
    done = create(developer, 'my_pkg', '--license', 'MIT')
    (warning,) = done.stderr.splitlines()
    assert f'warning: git knows no {missing}, so package.xml' in warning
    assert f' {maintainer} ' in warning
    manifest = developer.root / 'src/my_pkg/package.xml'
    root = ET.parse(manifest).getroot()
    element = root.find('maintainer')
    assert element is not None
    assert f'{element.text} <{element.get("email")}>' == maintainer


@pytest.mark.parametrize(
    ('words', 'message'),
    [
        ([], 'no name for the package\n  help: usage: colcon create PKG'),
        (['a_b', 'c_d'], "'c_d' is one word too many"),
        (['a_b', '--nude', 'c'], "did you mean '--node'?"),
        (['--dependencies', 'rclpy', 'a_b'], 'took all that follows it'),
        (['a_b', '--dependencies', 'a_b'], 'cannot depend on itself'),
        (['a_b', '--dependencies', '<a>'], "'<a>' is no name of a package"),
    ],
)
def test_mistakes(developer: User, words: list[str], message: str) -> None:
    assert message in error(developer, *words)


def test_unknown_build_type(developer: User) -> None:
    done = create(developer, 'a_b', '--build-type', 'catkin', code=2)
    assert "invalid choice: 'catkin'" in done.stderr


def test_place(developer: User, tmp_path: Path) -> None:
    root = developer.root
    create(developer, 'one')
    create(developer, 'two', cwd=root / 'src')
    assert {p.name for p in (root / 'src').iterdir()} == {'one', 'two'}
    message = error(developer, 'three', cwd=root / 'src/one/launch')
    assert f'{root / "src/one"} is a package' in message
    done = create(developer, 'three', '--destination', '../an other/src')
    command = f"cd '{root.parent}/an other' && colcon launch three"
    assert command in done.stdout
    empty = tmp_path / 'empty'
    empty.mkdir()
    done = create(developer, 'four', cwd=empty)
    assert 'Try it:  colcon launch four four.launch.yaml' in done.stdout
    assert [p.name for p in empty.iterdir()] == ['four']


def test_first_package_of_an_empty_folder_launches(
    developer: User, tmp_path: Path
) -> None:
    empty = tmp_path / 'empty'
    empty.mkdir()
    done = create(developer, 'one', '--build-type', 'cmake', cwd=empty)
    command = done.stdout.rpartition('Try it:')[2].split()
    launch = developer.start(*command, cwd=empty)
    launch.wait_for('Hello from one 1')
    assert launch.interrupt() == 0, launch.output


def test_help(developer: User) -> None:
    for words in (['--help'], ['my_pkg', '-h']):
        assert '--build-type' in create(developer, *words).stdout
    assert list((developer.root / 'src').iterdir()) == []


def test_nodes_in_cpp_and_one_more(developer: User) -> None:
    words = ['pumps', '--build-type', 'cmake', '--license', 'MIT']
    create(developer, *words, '--node', 'pump.cpp')
    done = create(developer, 'pumps', '--add-node', 'valve')
    assert (
        '  scripts/valve.py (new)\n  CMakeLists.txt (changed)' in done.stdout
    )
    until = ('--until', 'Hello from pumps 2')
    output = developer.launch('pumps', 'pumps.launch.yaml', *until)
    assert '] Hello from pumps 1' in output
    assert (developer.root / 'install/pumps/lib/pumps/valve.py').is_file()


def test_package_with_a_node_of_rclcpp(developer: User) -> None:
    done = create(developer, 'pumps', '--node', 'pump.cpp')
    assert 'rclcpp of ROS 2 is not to be found here' in done.stderr
    folder = developer.root / 'src/pumps'
    text = (folder / 'CMakeLists.txt').read_text()
    assert 'target_link_libraries(pump rclcpp::rclcpp)' in text
    assert '<depend>rclcpp</depend>' in (folder / 'package.xml').read_text()
    assert (
        'class Pump : public rclcpp::Node'
        in (folder / 'src/pump.cpp').read_text()
    )
    assert 'is in C++' in error(
        developer, 'a', '--node', 'b.cpp', '--build-type', 'ament_python'
    )
    assert 'CMake has a target' in error(developer, 'a', '--node', 'test.cpp')
    assert "did you mean 'pumps'?" in error(
        developer, 'pump', '--add-node', 'x'
    )
    assert 'already' in error(developer, 'pumps', '--add-node', 'pump.cpp')
    done = create(developer, 'pumps', '--add-node', 'valve.cpp')
    assert 'rclcpp of ROS 2 is not to be found here' in done.stderr


def test_package_outside_of_workspaces_is_made_in_the_named_one(
    developer: User, tmp_path: Path
) -> None:
    outside = tmp_path / 'outside'
    outside.mkdir()
    (developer.root / 'src').mkdir(exist_ok=True)
    developer.environment['ROS_WORKSPACE'] = str(developer.root)
    command = ('colcon', 'create', 'my_pkg')
    made = developer.start(*command, cwd=outside)
    assert made.end() == 0, made.output
    assert (developer.root / 'src/my_pkg/package.xml').is_file()
    # where there is a workspace around, or going to be one, that is meant
    (outside / 'src').mkdir()
    made = developer.start(*command, cwd=outside)
    assert made.end() == 0, made.output
    assert (outside / 'src/my_pkg/package.xml').is_file()
