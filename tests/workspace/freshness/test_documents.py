# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A README changes no build, unless a CMake file may take it in."""

from colcon_yamllaunch.workspace.freshness.build_products import ARGUMENTS
from colcon_yamllaunch.workspace.packages.build_files import (
    is_document,
    may_be_named,
)
import pytest
from support.package_builds import PackageBuilds

USUAL = """\
cmake_minimum_required(VERSION 3.16)
project(flow CXX)  # no README.rst here
find_package(base REQUIRED)
# install(FILES README.md DESTINATION share)
file(GLOB sources src/*.cpp ${CMAKE_CURRENT_SOURCE_DIR}/more/*.c)
add_library(${PROJECT_NAME}_lib ${sources})
target_include_directories(flow PUBLIC
  "$<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>"
  $<INSTALL_INTERFACE:include/${PROJECT_NAME}>)
install(TARGETS flow RUNTIME DESTINATION lib/${PROJECT_NAME})
install(DIRECTORY include/ DESTINATION .)
install(DIRECTORY launch config DESTINATION share/${PROJECT_NAME}
  FILES_MATCHING PATTERN "*.yaml")
"""


@pytest.mark.parametrize(
    'path',
    [
        *('README.md', 'readme', 'LICENSE', 'LICENSE.txt', 'CHANGELOG.rst'),
        *('Contributing.md', 'notes.md', 'docs/guide.md', 'doc/index.rst'),
    ],
)
def test_documents(path):
    assert is_document(path)
    assert not may_be_named(path, [USUAL])


@pytest.mark.parametrize(
    'path',
    [
        *('README.cpp.in', 'data/README.md', 'CMakeLists.txt', 'notes.txt'),
        *('docs/conf.py', 'a/docs/x.md', '.md', 'src/readme', 'readme.d/x'),
    ],
)
def test_what_is_no_document(path):
    assert not is_document(path)


@pytest.mark.parametrize(
    'line',
    [
        'install(FILES README.md DESTINATION share)',
        'configure_file(readme.md x COPYONLY)',
        'file(READ "${CMAKE_CURRENT_SOURCE_DIR}/README.md" text)',
        'set(name README) # and elsewhere ${name}.md',
        'install(FILES ${name}.md DESTINATION share)',
        'install(FILES README.${suffix} DESTINATION share)',
        'file(GLOB all *)',
        'file(GLOB all *.*)',
        'file(GLOB_RECURSE all CONFIGURE_DEPENDS "${dir}/*.md")',
        'file(GLOB all [A-Z]*.md)',
        'install(DIRECTORY . DESTINATION share)',
        'install(DIRECTORY ./ DESTINATION share)',
        'install(DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/ DESTINATION share)',
        'install(DIRECTORY ${PROJECT_SOURCE_DIR}/.. DESTINATION share)',
        'file(COPY "." DESTINATION ${CMAKE_BINARY_DIR})',
        'execute_process(COMMAND tool)',
        'Add_Custom_Command(OUTPUT x COMMAND tool)',
        'add_custom_target(docs ALL COMMAND tool)',
    ],
)
def test_a_line_that_may_mean_it(line):
    assert may_be_named('README.md', [USUAL, f'{USUAL}\n{line}\n'])


@pytest.mark.parametrize(
    'line',
    [
        'install(DIRECTORY docs DESTINATION share)',
        'install(DIRECTORY ${CMAKE_SOURCE_DIR}/docs/ DESTINATION share)',
        'ament_auto_package(INSTALL_TO_SHARE launch docs)',
        'file(GLOB all doc*)',
    ],
)
def test_a_folder_that_is_installed(line):
    assert may_be_named('docs/guide.md', [f'{USUAL}\n{line}\n'])
    assert not may_be_named('README.md', [f'{USUAL}\n{line}\n'])


@pytest.fixture
def builds(tmp_path):
    """Return a package that was built, with a README."""
    builds = PackageBuilds(tmp_path)
    builds.write('src/flow/README.md', 'one')
    builds.build()
    assert builds.why == ''
    return builds


def test_a_document_that_is_edited_builds_nothing(builds):
    builds.write('src/flow/README.md', 'two')
    builds.write('src/flow/docs/guide.md')
    assert builds.why == ''
    (builds.package.path / 'README.md').unlink()
    assert builds.why == ''
    # what was found out is remembered
    assert builds.decide().reasons == ()
    builds.write('src/flow/main.c', 'two')
    assert builds.why == 'main.c changed'


def test_a_cmake_file_that_comes_to_mean_it(builds):
    builds.write('src/flow/README.md', 'two')
    assert builds.why == ''
    builds.write('src/flow/CMakeLists.txt', 'file(READ README.md text)')
    assert builds.why == 'CMakeLists.txt changed'
    builds.build()
    builds.write('src/flow/README.md', 'three')
    assert builds.why == 'README.md changed'


def test_a_document_that_a_build_step_reads(builds):
    rule = f'x: {builds.package.path}/README.md\n'
    builds.build(lambda: builds.write('build/flow/build.make', rule))
    builds.write('src/flow/README.md', 'two')
    assert builds.why == 'README.md changed'


def test_an_argument_that_names_it(builds):
    builds.build(
        lambda: builds.write(f'build/flow/{ARGUMENTS}', "['-DX=README.md']")
    )
    builds.write('src/flow/README.md', 'two')
    assert builds.why == 'README.md changed'


def test_python_packages_have_documents_in_their_metadata(tmp_path):
    builds = PackageBuilds(tmp_path, 'python')
    builds.build()
    builds.write('src/flow/README.md', 'one')
    assert builds.why == 'new file README.md'


def test_a_failed_build_is_repeated_whatever_changed(builds):
    builds.build(fails=True)
    builds.write('src/flow/README.md', 'two')
    assert builds.why != ''
