# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Products that are not what the build made of them."""

from dataclasses import replace
import os
import shutil
import subprocess

from colcon_yamllaunch.workspace.freshness.build_record import BuildMode
from colcon_yamllaunch.workspace.freshness.freshness import Freshness
import pytest
from support.package_builds import PackageBuilds

pytestmark = pytest.mark.hostile

CACHE = 'build/flow/CMakeCache.txt'
OBJECT = 'build/flow/CMakeFiles/flow.dir/main.c.o'
PROGRAM = 'build/flow/flow'
LIBRARY = 'build/flow/libflow.a'
HOOK = 'build/flow/hooks/path.dsv'
GENERATED = 'build/flow/gen/flow.hpp'
COPY = 'install/flow/share/flow/package.sh'
LINK = 'install/flow/share/flow/path.dsv'


@pytest.fixture
def builds(tmp_path):
    builds = PackageBuilds(tmp_path)

    def compiler():
        for path in (OBJECT, LIBRARY, HOOK, GENERATED, COPY):
            builds.write(path, 'good')
        builds.write(CACHE, '//A\nA:STRING=1\nB:INTERNAL=1\n')
        builds.write(PROGRAM, 'good', 0o755)
        (tmp_path / LINK).symlink_to(tmp_path / HOOK)

    builds.build(compiler)
    assert builds.why == ''
    return builds


@pytest.mark.parametrize(
    ('path', 'mode'),
    [
        (OBJECT, BuildMode.BUILD),
        (PROGRAM, BuildMode.BUILD),
        (LIBRARY, BuildMode.BUILD),
        (CACHE, BuildMode.CONFIGURE),
        (HOOK, BuildMode.CLEAN),
        (GENERATED, BuildMode.CLEAN),
        (COPY, BuildMode.BUILD),
    ],
)
def test_what_was_truncated_or_replaced_is_built_again(builds, path, mode):
    status = (builds.root / path).stat()
    builds.write(path, 'evil', status.st_mode & 0o777)
    os.utime(builds.root / path, ns=(status.st_atime_ns, status.st_mtime_ns))
    decision = builds.decide()
    assert 'is not as it was' in decision.reason
    assert decision.mode is mode
    # make and CMake would take it for up to date
    freshness = Freshness(builds.products, {})
    freshness.prepare(builds.package, decision.mode)
    assert not (builds.root / path).exists()


@pytest.mark.parametrize(
    ('path', 'mode'), [(PROGRAM, BuildMode.BUILD), (HOOK, BuildMode.CLEAN)]
)
def test_what_is_gone_is_built_again(builds, path, mode):
    (builds.root / path).unlink()
    decision = builds.decide()
    assert 'is missing' in decision.reason
    assert decision.mode is mode


def test_a_program_that_may_not_run_any_more(builds):
    (builds.root / PROGRAM).chmod(0o644)
    assert 'flow is not as it was built' in builds.why


def test_an_installed_link_to_something_else(builds):
    (builds.root / LINK).unlink()
    (builds.root / LINK).symlink_to(builds.root / OBJECT)
    assert 'path.dsv is not as it was installed' in builds.why


def test_the_same_content_with_other_times_is_read_once(builds, monkeypatch):
    record = builds.root / 'build/flow/colcon_launch.json'
    for path in (OBJECT, COPY):
        builds.write(path, 'good')
    before = record.read_bytes()
    assert builds.why == ''
    after = record.read_bytes()
    assert after != before
    assert builds.why == ''
    assert record.read_bytes() == after


def test_what_cmake_finds_out_for_itself_does_not_matter(builds):
    builds.write(CACHE, '//C\nA:STRING=1\nB:INTERNAL=2\n')
    assert builds.why == ''
    builds.write(CACHE, '//A\nA:STRING=2\nB:INTERNAL=1\n')
    assert 'CMakeCache.txt is not as it was built' in builds.why


def test_what_tests_and_programs_write_does_not_matter(builds):
    builds.build(lambda: builds.write('build/flow/out.txt', 'one'))
    for path in ('out.txt', 'Testing/x.o', 'test_results/a.py', 'run.log'):
        builds.write(f'build/flow/{path}', 'two')
    builds.write('build/flow/__pycache__/x.py', 'two')
    assert builds.why == ''


def test_damage_in_what_runs_commands_is_built_from_scratch(builds):
    builds.write('src/flow/CMakeLists.txt', 'add_custom_command(OUTPUT x)')
    builds.build()
    builds.write(OBJECT, 'evil')
    assert builds.decide().mode is BuildMode.CLEAN


@pytest.mark.parametrize('product', ['flow.egg-info/PKG-INFO', 'flow'])
def test_a_python_package_without_a_product(tmp_path, product):
    builds = PackageBuilds(tmp_path, 'ros.ament_python')

    def setup():
        builds.write('build/flow/flow.egg-info/PKG-INFO')
        (tmp_path / 'build/flow/flow').symlink_to(tmp_path / 'src/flow')

    builds.build(setup)
    assert builds.why == ''
    path = tmp_path / 'build/flow' / product.partition('/')[0]
    path.unlink() if path.is_symlink() else shutil.rmtree(path)
    decision = builds.decide()
    assert f'{product} is missing' in decision.reason
    assert decision.mode is BuildMode.CLEAN


def test_another_build_of_the_same_with_other_products(builds):
    builds.write('build/flow/colcon_build.rc', '0')
    decision = builds.decide()
    assert decision.reasons == ()
    builds.write('build/flow/colcon_build.rc', '1')
    builds.write(OBJECT, 'evil')
    decision = builds.decide()
    assert decision.reason == 'something else built it since'
    assert decision.mode is BuildMode.CLEAN


def test_unknown_state_of_a_record_is_no_error(builds):
    builds.context = replace(builds.context, settings={'a': '1'})
    shutil.rmtree(builds.root / 'build/flow/CMakeFiles')
    assert len(builds.decide().reasons) == 2


PROGRAM_OF_TWO = """\
cmake_minimum_required(VERSION 3.16)
project(two C)
add_library(one STATIC one.c)
add_executable(two main.c)
target_link_libraries(two one)
install(TARGETS two DESTINATION lib/two)
"""


def test_products_of_cmake(workspace, update):
    workspace.write('src/two/CMakeLists.txt', PROGRAM_OF_TWO)
    one = workspace.write('src/two/one.c', 'int one(void) { return 7; }\n')
    workspace.write(
        'src/two/main.c', 'int one(void); int main(void) { return one(); }\n'
    )
    build = workspace.root / 'build/two'
    program = workspace.root / 'install/two/lib/two/two'

    def run():
        (returncode, stale, _), output = update('two')
        assert returncode == 0, output
        assert subprocess.run([program], check=False).returncode == 7
        return stale.get('two', '')

    assert run() == 'never built'
    assert run() == ''
    for damaged in ('two', 'libone.a', 'CMakeFiles/one.dir/one.c.o'):
        path = build / damaged
        os.truncate(path, path.stat().st_size // 2)
        assert f'{damaged} is not as it was built' in run()
        assert run() == ''
    # make compares times only, so the object of the edit would stay
    status = one.stat()
    one.write_text('int one(void) { return 8; }\n')
    subprocess.run(['make', '-C', build], check=True, capture_output=True)
    one.write_text('int one(void) { return 7; }\n')
    os.utime(one, ns=(status.st_atime_ns, status.st_mtime_ns))
    assert 'is not as it was built' in run()
    subprocess.run(
        ['cmake', '-DCMAKE_C_FLAGS=-Dseven=8', build],
        check=True,
        capture_output=True,
    )
    assert 'CMakeCache.txt is not as it was built' in run()
    assert run() == ''
