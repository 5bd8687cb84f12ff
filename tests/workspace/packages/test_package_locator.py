# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Where the files of packages are, and what to do when they are not."""

from pathlib import Path

from colcon_yamllaunch.common.suggestions import nearest_first
from colcon_yamllaunch.workspace.packages.missing_files import (
    certainly_unknown_executable,
    missing_executable,
    missing_plugin,
    not_installed,
    unknown_executable,
    unknown_plugin,
)
from colcon_yamllaunch.workspace.packages.package import Package
from colcon_yamllaunch.workspace.packages.package_locator import (
    PackageLocator,
    read_component_index,
)
from hypothesis import given
from hypothesis import strategies as st
import pytest


class Tree:
    """A workspace with one package, and two underlays, as bare files."""

    def __init__(self, root, merge=False, type_='ros.ament_cmake'):
        self.root = root
        self.install = root / 'ws/install'
        self.prefix = self.install if merge else self.install / 'my_pkg'
        self.source = root / 'ws/src/my_pkg'
        self.source.mkdir(parents=True)
        index = 'share/ament_index/resource_index/packages'
        self.file(f'ros/{index}/rclpy')
        self.file(f'ros/{index}/my_pkg')
        self.file('ros/lib/rclpy/talk', mode=0o755)
        self.file('ros/lib/rclpy/data.txt')
        self.file('over/flow/share/colcon-core/packages/flow')
        self.file('merged/share/colcon-core/packages/nav')
        self.locator = PackageLocator(
            [Package('my_pkg', self.source, type_)],
            self.install,
            merge,
            {
                'AMENT_PREFIX_PATH': f'/nowhere:{root}/ros',
                'COLCON_PREFIX_PATH': f'{root}/over:{root}/merged',
            },
        )

    def file(self, path, text='', mode=0o644):
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        file.chmod(mode)
        return file

    def src(self, path, text='', mode=0o644):
        return self.file(self.source / path, text, mode)

    def installed(self, path, mode=0o644):
        return self.file(self.prefix / path, mode=mode)


@pytest.fixture(params=[False, True], ids=['isolated', 'merged'])
def tree(request, tmp_path):
    return Tree(tmp_path, request.param)


def test_prefix_of_a_package(tree):
    find = tree.locator.prefix
    assert find('my_pkg') == str(tree.prefix)
    assert find('rclpy') == f'{tree.root}/ros'
    assert find('flow') == f'{tree.root}/over/flow'
    assert find('nav') == f'{tree.root}/merged'
    assert find('nothing') is None
    assert find('') is None
    assert find('..') is None
    assert tree.locator.share('my_pkg') == f'{tree.prefix}/share/my_pkg'
    assert tree.locator.share('nothing') is None


def test_names_of_all_packages(tree):
    assert tree.locator.names() == ('flow', 'my_pkg', 'nav', 'rclpy')


def test_executable(tree):
    find = tree.locator.executable
    # of the workspace: where it is going to be
    assert find('my_pkg', 'x') == f'{tree.prefix}/lib/my_pkg/x'
    assert find('rclpy', 'talk') == f'{tree.root}/ros/lib/rclpy/talk'
    assert find('rclpy', 'data.txt') is None
    assert find('nothing', 'x') is None
    assert tree.locator.executables('rclpy') == ('talk',)
    assert tree.locator.executables('my_pkg') == ()


def test_source_of(tree):
    config = tree.src('config/a.yaml')
    other = tree.src('params/b.yaml')
    tree.src('x/twice.yaml')
    tree.src('y/twice.yaml')
    share = f'{tree.prefix}/share/my_pkg'
    find = tree.locator.source_of
    assert find(f'{share}/config/a.yaml') == str(config)
    assert find(f'{share}/launch/../config/a.yaml') == str(config)
    assert find(f'{share}/config') == str(tree.source / 'config')
    assert find(f'{share}/b.yaml') == str(other)
    assert find(f'{share}/twice.yaml') is None
    assert find(f'{share}/none.yaml') is None
    assert find(f'{tree.root}/ros/share/rclpy/a.yaml') is None
    assert find(f'{tree.prefix}/lib/my_pkg/a.yaml') is None
    assert find('relative.yaml') is None


def test_package_of_and_installed_path(tree):
    launch = tree.src('launch/a.yaml')
    outside = tree.file('elsewhere/a.yaml')
    assert tree.locator.package_of(str(launch)).name == 'my_pkg'
    assert tree.locator.package_of(str(outside)) is None
    find = tree.locator.installed_path
    expected = f'{tree.prefix}/share/my_pkg/launch/a.yaml'
    assert find('my_pkg', str(launch)) == expected
    assert find('my_pkg', str(outside)) is None
    assert find('rclpy', str(launch)) is None


def missing(tree, name, package='my_pkg'):
    problem = missing_executable(tree.locator, package, name)
    return problem and str(problem)


def test_program_that_is_there(tree):
    tree.installed('lib/my_pkg/counter.py', 0o755)
    assert missing(tree, 'counter.py') is None


def test_script_without_executable_bit(tree):
    script = tree.src('scripts/counter.py')
    link = tree.prefix / 'lib/my_pkg/counter.py'
    link.parent.mkdir(parents=True)
    link.symlink_to(script)
    text = missing(tree, 'counter.py')
    assert 'chmod +x scripts/counter.py' in text
    assert str(tree.source) in text


def test_copy_without_executable_bit(tree):
    tree.src('scripts/counter.py')
    copy = tree.installed('lib/my_pkg/counter.py')
    text = missing(tree, 'counter.py')
    assert text.endswith(f"'chmod +x scripts/counter.py' in {tree.source}")
    tree.src('scripts/counter.py', mode=0o755)
    assert missing(tree, 'counter.py').endswith(f"'chmod +x {copy}'")


@pytest.mark.parametrize('mode', [0o644, 0o755])
def test_script_that_is_not_installed(tree, mode):
    tree.src('scripts/counter.py', mode=mode)
    for name in ('counter.py', 'counter'):
        text = missing(tree, name)
        assert (
            'install(PROGRAMS scripts/counter.py DESTINATION '
            'lib/${PROJECT_NAME})'
        ) in text
        assert str(tree.source / 'CMakeLists.txt') in text
        assert ('chmod' in text) == (mode == 0o644)


def test_target_that_is_not_installed(tree):
    tree.src('src/talker.cpp')
    tree.src('CMakeLists.txt', 'add_executable(talker src/talker.cpp)\n')
    text = missing(tree, 'talker')
    assert 'install(TARGETS talker DESTINATION lib/${PROJECT_NAME})' in text


def test_program_under_another_spelling(tree):
    tree.installed('lib/my_pkg/counter.py', 0o755)
    tree.src('scripts/counter.py')
    assert "did you mean 'counter.py'" in missing(tree, 'counter')


def test_program_in_bin(tree):
    tree.installed('bin/flow', 0o755)
    assert 'DESTINATION lib/${PROJECT_NAME}' in missing(tree, 'flow')


def test_programs_there_are_nearest_first(tree):
    for name in ('abc', 'counter', 'count'):
        tree.installed(f'lib/my_pkg/{name}', 0o755)
    assert missing(tree, 'countr').endswith('has counter, count, abc')
    assert missing(tree, 'x', 'rclpy').endswith('has talk')
    assert missing(tree, 'x', 'flow').endswith('has installed none')
    assert 'no package' in missing(tree, 'x', 'nothing')


def test_programs_in_subfolders_go_by_their_path(tree):
    tree.installed('lib/my_pkg/tools/count', 0o755)
    tree.installed('lib/my_pkg/count', 0o755)
    tree.installed('lib/my_pkg/tools/data.txt')
    names = tree.locator.executables('my_pkg')
    assert names == ('count', 'tools/count')


def test_python_package(tmp_path):
    tree = Tree(tmp_path, type_='ros.ament_python')
    tree.src('my_pkg/talk.py')
    text = missing(tree, 'talk')
    assert "'talk = my_pkg.talk:main'" in text
    assert 'console_scripts' in text
    tree.installed('bin/talk', 0o755)
    assert 'install_scripts=$base/lib/my_pkg' in missing(tree, 'talk')


def test_file_that_is_not_installed(tree):
    tree.src('config/a.yaml')
    tree.src('plan.xml')
    share = tree.prefix / 'share/my_pkg'

    def explain(locator, path):
        problem = not_installed(locator, path)
        return problem and problem.hint

    text = explain(tree.locator, f'{share}/config/a.yaml')
    assert (
        'install(DIRECTORY config DESTINATION share/${PROJECT_NAME})' in text
    )
    text = explain(tree.locator, f'{share}/plan.xml')
    assert 'install(FILES plan.xml DESTINATION share/${PROJECT_NAME})' in text
    # the folder is installed, file by file
    tree.installed('share/my_pkg/config/b.yaml')
    text = explain(tree.locator, f'{share}/config/a.yaml')
    assert (
        'install(FILES config/a.yaml DESTINATION share/${PROJECT_NAME}/config)'
    ) in text
    assert explain(tree.locator, f'{share}/config/none.yaml') is None
    tree.installed('share/my_pkg/config/a.yaml')
    assert explain(tree.locator, f'{share}/config/a.yaml') is None


def test_file_of_a_python_package_that_is_not_installed(tmp_path):
    tree = Tree(tmp_path, type_='ros.ament_python')
    tree.src('config/a.yaml')
    path = tree.prefix / 'share/my_pkg/config/a.yaml'
    text = not_installed(tree.locator, str(path)).hint
    assert "('share/my_pkg/config', ['config/a.yaml'])" in text
    assert 'data_files' in text


def test_first_of_two_packages_with_a_name(tmp_path):
    packages = [Package('a', Path(f'/{i}'), 'cmake') for i in range(2)]
    locator = PackageLocator(packages, tmp_path, False, {})
    assert locator.package('a').path == Path('/0')


def test_nearest_name_is_suggested():
    assert nearest_first('my_pgk', ['rviz2', 'my_pkg', 'other'])[0] == 'my_pkg'


def test_what_is_no_program_is_not_offered_as_one(tree):
    tree.src('scripts/drive.py', mode=0o755)
    for path in ('test/test_drive.py', 'launch/x.launch.py', 'setup.py'):
        tree.src(path)
    problem = unknown_executable(tree.locator, 'my_pkg', 'test_driv')
    assert str(problem) == (
        "my_pkg has no executable 'test_driv': it has drive.py"
    )


INDEX = 'share/ament_index/resource_index/rclcpp_components'


def test_components(tree):
    assert tree.locator.plugins('my_pkg') is None
    # an underlay's counts until the package has its own
    tree.file(f'ros/{INDEX}/my_pkg', 'old::Node;lib/libold.so\n')
    assert tree.locator.plugins('my_pkg') == ('old::Node',)
    listed = tree.installed(f'{INDEX}/my_pkg')
    listed.write_text('a::Talker;lib/liba.so\n\na::Listener;lib/liba.so')
    assert tree.locator.plugins('my_pkg') == ('a::Talker', 'a::Listener')
    assert missing_plugin(tree.locator, 'my_pkg', 'a::Talker') is None
    assert missing_plugin(tree.locator, 'my_pkg', 'a::Talkr') == (
        "my_pkg has no component 'a::Talkr': did you mean 'a::Talker'? "
        'it has a::Talker, a::Listener',
        True,
    )


def test_a_package_without_components(tree):
    # containers of other kinds may know better
    assert missing_plugin(tree.locator, 'rclpy', 'a::B') == (
        'rclpy has installed no components',
        False,
    )
    text, is_certain = missing_plugin(tree.locator, 'my_pkg', 'a::B')
    assert is_certain
    assert 'rclcpp_components_register_nodes(TARGET "a::B")' in text
    assert str(tree.source / 'CMakeLists.txt') in text


def test_components_that_a_build_may_bring(tree):
    def reason(plugin):
        found = unknown_plugin(tree.locator, 'my_pkg', plugin)
        return None if found is None else found.reason

    assert 'it has installed none' in reason('a::Talker')
    cmake = tree.src(
        'CMakeLists.txt',
        'rclcpp_components_register_node(t PLUGIN "a::Talker" EXECUTABLE t)\n',
    )
    assert reason('a::Talker') is None
    assert "did you mean 'a::Talker'?" in reason('a::Talkr')
    # what other macros or variables make of it shows in the build only
    cmake.write_text('my_register(${PROJECT_NAME}::Camera)\n')
    assert reason('my_pkg::Camera') is None
    tree.src('src/viewer.cpp', 'RCLCPP_COMPONENTS_REGISTER_NODE(v::Viewer)')
    assert reason('v::Viewer') is None
    assert reason('v::Viewr') is not None
    tree.installed(f'{INDEX}/my_pkg').write_text('gone::Node;lib/liba.so')
    assert reason('gone::Node') is None
    # an underlay is built already
    found = unknown_plugin(tree.locator, 'rclpy', 'x::Y')
    assert found.reason == 'rclpy has installed no components'


def test_a_package_that_is_not_there(tree):
    assert str(tree.locator.no_package('my_pgk')) == (
        "there is no package 'my_pgk' in the workspace or the sourced "
        "environment: did you mean 'my_pkg'?"
    )


@pytest.mark.parametrize(
    ('variables', 'hint'),
    [
        ({'ROS_DISTRO': 'jazzy'}, 'install it (on Debian and Ubuntu: sudo '),
        ({}, 'source /opt/ros/<distro>/setup.bash first; or install it (on'),
    ],
)
def test_unknown_package_is_to_be_installed(tmp_path, variables, hint):
    locator = PackageLocator([], tmp_path, False, variables)
    found = locator.no_package('rviz_common')
    assert found.hint.startswith(hint)
    distro = variables.get('ROS_DISTRO', '<distro>')
    assert f'sudo apt install ros-{distro}-rviz-common); or' in found.hint
    assert 'apt' not in (locator.no_package('a; rm b').hint or '')


@given(st.text())
def test_any_list_of_components_can_be_read(text):
    for plugin in read_component_index(text):
        assert plugin
        assert ';' not in plugin
        assert plugin in text


def test_what_the_source_tells_before_a_build(tree):
    def explain(name):
        texts = {
            str(explain(tree.locator, 'my_pkg', name) or '')
            for explain in (unknown_executable, certainly_unknown_executable)
        }
        assert len(texts) == 1
        return texts.pop() or None

    rule = 'install(PROGRAMS scripts/{} DESTINATION lib/${{PROJECT_NAME}})\n'
    cmake = tree.src('CMakeLists.txt', rule.format('counter.py'))
    tree.src('scripts/counter.py', mode=0o755)
    tree.src('scripts/other.py', mode=0o755)
    assert explain('counter.py') is None
    assert explain('counter').endswith("did you mean 'counter.py'?")
    assert rule.format('other.py').strip() in explain('other.py')
    assert rule.format('other.py').strip() in explain('other')
    assert explain('nothing').endswith('it has counter.py')
    tree.src('scripts/counter.py')
    assert 'chmod +x scripts/counter.py' in explain('counter.py')
    # a copy elsewhere may be meant
    tree.src('more/counter.py', mode=0o755)
    assert explain('counter.py') is None
    cmake.write_text('install_all(scripts)\n')
    unsure = certainly_unknown_executable
    assert unsure(tree.locator, 'my_pkg', 'other.py') is None
    assert unsure(tree.locator, 'my_pkg', 'nothing') is None


def test_what_a_setup_tells_before_a_build(tmp_path):
    tree = Tree(tmp_path, type_='ros.ament_python')
    entry = "{'console_scripts': ['talk = my_pkg.talk:main']}"
    tree.src('setup.py', f'setup(entry_points={entry})')
    tree.src('setup.cfg', '[develop]\nscript_dir=$base/lib/my_pkg\n')
    tree.src('my_pkg/talk.py')
    tree.src('my_pkg/hear.py')

    def explain(name):
        problem = certainly_unknown_executable(tree.locator, 'my_pkg', name)
        return problem and str(problem)

    assert explain('talk') is None
    assert explain('talk.py').endswith("did you mean 'talk'?")
    assert "'hear = my_pkg.hear:main'" in explain('hear')
    assert explain('sub/talk') is None
    tree.src('setup.cfg')
    assert 'install_scripts=$base/lib/my_pkg' in explain('talk')


def test_what_its_build_files_name_is_not_unknown(tree):
    tree.src('CMakeLists.txt').write_text(
        'project(my_pkg)\nadd_executable(${PROJECT_NAME}_node x.cpp)\n'
    )
    assert unknown_executable(tree.locator, 'my_pkg', 'my_pkg_node') is None
    problem = unknown_executable(tree.locator, 'my_pkg', 'drive')
    assert problem.hint == 'it has my_pkg_node'
    tree.src('CMakeLists.txt').write_text('project(my_pkg)\n')
    problem = unknown_executable(tree.locator, 'my_pkg', 'drive')
    assert problem.hint == 'its build files name none'


def test_an_entry_point_with_the_name_of_a_module(tmp_path):
    tree = Tree(tmp_path, type_='ros.ament_python')
    tree.src('setup.cfg', '[develop]\nscript_dir=$base/lib/my_pkg\n')
    tree.src('my_pkg/drive.py')
    tree.src('setup.py').write_text(
        "setup(entry_points={'console_scripts': "
        "['drive.py = my_pkg.drive:main']})"
    )
    assert unknown_executable(tree.locator, 'my_pkg', 'drive.py') is None


def test_what_is_built_in_a_way_that_is_not_known(tmp_path):
    tree = Tree(tmp_path, type_='ros.ament_cargo')
    tree.src('Cargo.toml')
    assert unknown_executable(tree.locator, 'my_pkg', 'drive') is None
