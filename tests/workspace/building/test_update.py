# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""When packages are built and when not, with real builds."""

import contextlib
import os
import shutil
import signal
import subprocess
import time

import pytest

PYPROJECT = """\
[build-system]
requires = ["setuptools>=61"]
build-backend = "setuptools.build_meta"

[project]
name = "talker"
version = "0.1.0"

[project.scripts]
talk = "talker.talk:main"

[tool.setuptools]
packages = ["talker"]
"""


@pytest.fixture
def flow(workspace, update):
    """A plain CMake package that is up to date."""
    install = 'configure_file(flow.txt.in flow.txt)\n'
    folder = workspace.cmake('flow', install=install)
    workspace.write('src/flow/flow.txt.in', 'one\n')
    result, output = update('flow')
    assert result == [0, {'flow': 'never built'}, []], output
    return folder


@pytest.fixture
def why(update):
    """Get why a package is built, or None if it is not."""

    def get(name='flow', **options):
        (returncode, stale, _), output = update(name, **options)
        assert returncode == 0, output
        return stale.get(name)

    return get


def test_second_launch_builds_nothing(workspace, flow, update):
    result, output = update('flow')
    assert result == [0, {}, ['flow']]
    assert 'Starting' not in output


def test_edit_of_what_is_compiled_builds_once(flow, why):
    (flow / 'flow.txt.in').write_text('two\n')
    assert why() == 'flow.txt.in changed'
    assert why() is None


def test_same_size_and_time_does_not_hide_an_edit(flow, why):
    path = flow / 'flow.txt.in'
    status = path.stat()
    path.write_text('two\n')
    os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))
    assert why() == 'flow.txt.in changed'


def test_touch_builds_nothing(flow, why):
    os.utime(flow / 'flow.txt.in', (0, 0))
    os.utime(flow / 'CMakeLists.txt')
    assert why() is None


def test_edit_of_a_linked_file_builds_nothing(flow, why):
    (flow / 'launch/flow.yaml').write_text('launch: [{}]\n')
    assert why() is None


def test_new_and_deleted_files_build(workspace, flow, why):
    (flow / 'launch/new.yaml').write_text('launch: []\n')
    assert why() == 'new file launch/new.yaml'
    (flow / 'launch/new.yaml').unlink()
    assert why() == 'launch/new.yaml was deleted'
    assert why() is None
    share = workspace.root / 'install/flow/share/flow'
    assert [p.name for p in share.glob('launch/*')] == ['flow.yaml']


def test_what_editors_and_git_leave_does_not_matter(workspace, flow, why):
    workspace.write('src/flow/.git/index')
    workspace.write('src/flow/launch/flow.yaml~')
    workspace.write('src/flow/launch/.flow.yaml.swp')
    workspace.write('src/flow/launch/__pycache__/x.pyc')
    assert why() is None


def test_arguments_build(flow, why):
    arguments = ('--cmake-args', '-DX=1')
    assert why(arguments=arguments) == 'build arguments changed (cmake_args)'
    assert why(arguments=arguments) is None
    assert why(arguments=('--parallel-workers', '1')) == (
        'build arguments changed (cmake_args)'
    )


def test_environment_builds(workspace, flow, why):
    assert why(CXXFLAGS='-O3') == 'CXXFLAGS changed in the environment'
    assert why(CXXFLAGS='-O3', UNRELATED='1') is None


def test_sourcing_the_workspace_itself_builds_nothing(workspace, flow, why):
    install = workspace.root / 'install'
    assert (
        why(
            COLCON_PREFIX_PATH=str(install),
            CMAKE_PREFIX_PATH=str(install / 'flow'),
        )
        is None
    )


@pytest.mark.parametrize(
    ('path', 'reason'),
    [
        ('build', 'never built'),
        ('build/flow/colcon_launch.json', 'no record of a'),
        ('install', 'something else built it since'),
        ('install/flow/share/flow/launch', 'is missing'),
    ],
)
def test_removed_folders_build(workspace, flow, why, path, reason):
    target = workspace.root / path
    shutil.rmtree(target) if target.is_dir() else target.unlink()
    assert reason in why()
    share = workspace.root / 'install/flow/share/flow'
    assert (share / 'launch/flow.yaml').exists()


@pytest.mark.parametrize(
    'text', ['', '{', '[]', '{"version": 0}', '{"version": 1}', '\0\xff']
)
def test_damaged_record_builds(workspace, flow, why, text):
    workspace.write('build/flow/colcon_launch.json', text)
    assert 'no record of a successful build' in why()


def test_plain_colcon_build_in_between(workspace, flow, why):
    subprocess.run(
        ['colcon', 'build', '--cmake-args', '-DX=1'],
        cwd=workspace.root,
        env=workspace.environment(),
        check=True,
        capture_output=True,
    )
    assert why() == 'something else built it since'
    assert why() is None


def test_failed_build_is_repeated(workspace, flow, update):
    good = (flow / 'CMakeLists.txt').read_text()
    (flow / 'CMakeLists.txt').write_text(good + 'nonsense()\n')
    assert update('flow')[0][0] != 0
    result, _ = update('flow')
    assert result[0] != 0
    assert 'no successful build' in result[1]['flow']
    (flow / 'CMakeLists.txt').write_text(good)
    assert update('flow')[0][0] == 0
    assert update('flow')[0] == [0, {}, ['flow']]


def test_dependents_are_built_with_what_they_build_on(workspace, update):
    workspace.cmake('base')
    workspace.cmake('lib', needs=('base',))
    workspace.ament_cmake('node', '<exec_depend>lib</exec_depend>')
    assert update('node')[0][0] == 0
    assert update('node')[0] == [0, {}, ['base', 'lib', 'node']]
    workspace.write('src/base/new.txt')
    result, _ = update('node')
    stale = {'base': 'new file new.txt', 'lib': 'base is built'}
    assert result == [0, stale, ['node']]
    # built on its own before: the dependent notices later
    workspace.write('src/base/newer.txt')
    assert update('base')[0] == [0, {'base': 'new file newer.txt'}, []]
    assert update('lib')[0] == [0, {'lib': 'base was rebuilt'}, ['base']]


def test_what_only_installs_is_not_built_with_what_it_needs(workspace, update):
    base = workspace.cmake('base') / 'CMakeLists.txt'
    folder = workspace.ament_cmake('node', '<depend>base</depend>')
    assert update('node')[0][0] == 0
    base.write_text(f'{base.read_text()}\n# more\n')
    stale = {'base': 'CMakeLists.txt changed'}
    assert update('node')[0] == [0, stale, ['node']]
    assert update('node')[0] == [0, {}, ['base', 'node']]
    # once it uses that, it is
    own = folder / 'CMakeLists.txt'
    text = own.read_text().replace(
        'find_package', 'find_package(base)\nfind_package', 1
    )
    own.write_text(text)
    assert update('node')[0][1] == {'node': 'base was rebuilt'}
    base.write_text(f'{base.read_text()}\n# still more\n')
    assert update('node')[0][1] == stale | {'node': 'base is built'}


def test_node_of_ament_cmake_is_edited_in_place(workspace, update, why):
    folder = workspace.ament_cmake('node')
    assert update('node')[0][0] == 0
    script = folder / 'scripts/counter.py'
    script.write_text('print(2)\n')
    assert why('node') is None
    installed = workspace.root / 'install/node/lib/node/counter.py'
    assert installed.read_text() == 'print(2)\n'
    manifest = folder / 'package.xml'
    manifest.write_text(manifest.read_text().replace('0.1.0', '0.2.0'))
    assert why('node') == 'package.xml changed'


def test_script_that_the_build_reads_is_no_mere_copy(workspace, update, why):
    # it is linked into the install space and a configure input as well
    install = (
        'configure_file(table.csv table.txt)\n'
        'install(FILES table.csv DESTINATION share/${PROJECT_NAME})\n'
    )
    folder = workspace.cmake('flow', install=install)
    (folder / 'table.csv').write_text('1\n')
    assert update('flow')[0][0] == 0
    (folder / 'table.csv').write_text('2\n')
    assert why() == 'table.csv changed'


def test_python_package(workspace, update, why):
    folder = workspace.ament_python('talker')
    assert update('talker')[0][0] == 0
    installed = workspace.root / 'install/talker/share/talker/launch/talk.yaml'
    linked = installed.is_symlink()
    (folder / 'talker/talk.py').write_text('def main():\n    print(1)\n')
    (folder / 'launch/talk.yaml').write_text('launch: [{}]\n')
    # setuptools 80 dropped what colcon links with: then copies are made
    assert (why('talker') is None) == linked
    assert installed.read_text() == 'launch: [{}]\n'
    (folder / 'talker/more.py').touch()
    assert why('talker') == 'new file talker/more.py'
    assert why('talker') is None


def test_python_package_with_its_metadata_in_pyproject(workspace, update, why):
    folder = workspace.ament_python('talker')
    setup = 'from setuptools import setup\n\nsetup()\n'
    workspace.write('src/talker/setup.py', setup)
    project = workspace.write('src/talker/pyproject.toml', PYPROJECT)
    result, output = update('talker')
    assert result[0] == 0, output
    programs = workspace.root / 'install/talker/lib/talker'
    assert [path.name for path in programs.iterdir()] == ['talk']
    assert why('talker') is None
    project.write_text(PYPROJECT.replace('talk =', 'other ='))
    assert why('talker') == 'pyproject.toml changed'
    assert [path.name for path in programs.iterdir()] == ['other']
    (folder / 'talker/more.py').write_text('')
    assert why('talker') == 'new file talker/more.py'
    assert why('talker') is None


def test_missing_setup_is_told(workspace, update):
    folder = workspace.ament_python('talker')
    (folder / 'setup.py').rename(folder / 'pyproject.toml')
    result, output = update('talker')
    assert result[0] != 0
    told = f'talker has no setup.py, which colcon runs: make {folder}/setup.py'
    assert told in output


def test_merged_layout(workspace, update, why):
    folder = workspace.cmake('flow')
    arguments = ('--merge-install',)
    assert update('flow', arguments=arguments)[0][0] == 0
    assert update('flow')[0] == [0, {}, ['flow']]
    (folder / 'launch/flow.yaml').write_text('launch: [{}]\n')
    assert why() is None
    (folder / 'launch/flow.yaml').unlink()
    assert why() == 'launch/flow.yaml was deleted'


@pytest.mark.parametrize('arguments', [(), ('--merge-install',)])
def test_moved_workspace(workspace, update, arguments):
    workspace.cmake('flow')
    workspace.ament_python('talker')
    workspace.ament_cmake('node')
    names = ['flow', 'node', 'talker']
    assert update(*names, arguments=arguments)[0][0] == 0
    old = workspace.root
    workspace.root = old.parent / 'moved'
    old.rename(workspace.root)
    (returncode, stale, _), output = update(*names)
    assert (returncode, sorted(stale)) == (0, names)
    assert 'moved or copied' in output
    assert not old.exists()
    install = workspace.root / 'install'
    for path in install.rglob('*'):
        if path.is_symlink():
            assert old not in path.readlink().parents, path
            assert path.exists(), path
    prefix = install if arguments else install / 'talker'
    assert (prefix / 'share/talker/launch/talk.yaml').exists()
    assert update(*names)[0] == [0, {}, names]


def test_copied_workspace_leaves_the_original_alone(workspace, flow, update):
    old = workspace.root
    cache = old / 'build/flow/CMakeCache.txt'
    before = cache.stat().st_mtime_ns
    workspace.root = old.parent / 'copy'
    shutil.copytree(old, workspace.root, symlinks=True)
    assert update('flow')[0][0] == 0
    launch = workspace.root / 'install/flow/share/flow/launch/flow.yaml'
    assert launch.resolve() == workspace.root / 'src/flow/launch/flow.yaml'
    assert cache.stat().st_mtime_ns == before
    assert (old / 'install/flow/share/flow/launch/flow.yaml').exists()


def test_force_builds_what_is_up_to_date(flow, why):
    assert why(force=True) == 'asked for'


def test_nothing_of_the_workspace_is_needed(workspace, update):
    workspace.cmake('flow')
    assert update('rviz2')[0] == [0, {}, []]
    assert not (workspace.root / 'build').exists()


def test_removed_setup_scripts_are_made_again(workspace, flow, why):
    install = workspace.root / 'install'
    for path in [*install.glob('setup.*'), *install.glob('local_setup.*')]:
        path.unlink()
    assert 'setup.sh is missing' in why()
    assert (install / 'setup.bash').exists()


def test_rebuilt_dependency_in_an_underlay(workspace, update):
    workspace.cmake('below')
    assert update('below')[0][0] == 0
    underlay = workspace.root / 'install'
    workspace.root = workspace.root.parent / 'over'
    workspace.cmake('above', needs=('below',))

    def stale():
        return update('above', COLCON_PREFIX_PATH=str(underlay))[0][1]

    assert stale() == {'above': 'never built'}
    assert stale() == {}
    os.utime(underlay / 'below/share/below/package.sh')
    assert stale() == {'above': 'below was rebuilt'}
    assert stale() == {}


def test_user_defaults_hold(workspace, update):
    pytest.importorskip('colcon_defaults')
    workspace.cmake('flow')
    defaults = workspace.root.parent / 'colcon_home/defaults.yaml'
    defaults.parent.mkdir()
    defaults.write_text('build: {cmake-args: [-DFROM=1]}\n')
    assert update('flow')[0][0] == 0
    cache = workspace.root / 'build/flow/CMakeCache.txt'
    assert 'FROM:UNINITIALIZED=1' in cache.read_text()
    assert update('flow')[0] == [0, {}, ['flow']]
    defaults.write_text('build: {cmake-args: [-DFROM=2]}\n')
    stale = {'flow': 'build arguments changed (cmake_args)'}
    assert update('flow')[0] == [0, stale, []]


def test_interrupted_build_is_repeated(workspace, update):
    folder = workspace.cmake(
        'slow', install='execute_process(COMMAND false)\n'
    )
    text = (folder / 'CMakeLists.txt').read_text()
    (folder / 'CMakeLists.txt').write_text(text.replace('false', 'sleep 600'))
    code = (
        f'colcon = CachedColcon(Path({str(workspace.root)!r}))\n'
        'result = bring_up_to_date('
        'colcon, ["slow"], dict(os.environ), print)\n'
        'show(result.returncode)\n'
    )
    with workspace.start(code) as process:
        try:
            trace = workspace.root / 'build/slow/CMakeFiles'
            end = time.monotonic() + 60
            while not trace.exists() and time.monotonic() < end:
                time.sleep(0.02)
            os.killpg(process.pid, signal.SIGINT)
            output, _ = process.communicate(timeout=60)
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
    assert 'RESULT 130' in output
    (folder / 'CMakeLists.txt').write_text(text)
    result, _ = update('slow')
    assert result[0] == 0
    assert 'no successful build' in result[1]['slow']
