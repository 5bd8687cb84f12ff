# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is saved, made or deleted while a package is built."""

import os

import pytest
from support.package_builds import PackageBuilds

pytestmark = pytest.mark.hostile

MAIN = 'src/flow/main.c'
CHANGED = 'main.c changed'


@pytest.fixture
def builds(tmp_path):
    return PackageBuilds(tmp_path)


def test_an_edit_that_is_undone_later_builds_again(builds):
    builds.build(lambda: builds.write(MAIN, 'two'))
    assert builds.why == CHANGED
    builds.write(MAIN, 'one')
    assert builds.why == CHANGED
    builds.build()
    assert builds.why == ''


def test_an_edit_that_is_undone_during_the_build_builds_again(builds):
    def compiler():
        builds.write(MAIN, 'two')
        builds.write(MAIN, 'one')

    builds.build(compiler)
    assert builds.why == CHANGED
    builds.build()
    assert builds.why == ''


def test_an_edit_whose_time_is_set_back_builds_again(builds):
    path = builds.root / MAIN
    before = path.stat().st_mtime_ns

    def compiler():
        builds.write(MAIN, 'two')
        builds.write(MAIN, 'one')
        os.utime(path, ns=(before, before))

    builds.build(compiler)
    assert builds.why == CHANGED


def test_an_edit_within_the_tick_of_the_snapshot_builds_again(builds):
    path = builds.root / MAIN
    path.write_text('now')
    builds.build(lambda: path.write_text('own'))
    assert builds.why == CHANGED
    builds.write(MAIN, 'now')
    assert builds.why == CHANGED


def test_an_edit_during_a_build_that_fails(builds):
    builds.build()
    before = (builds.root / MAIN).stat().st_mtime_ns
    builds.build(lambda: builds.write(MAIN, 'two'), fails=True)
    builds.write(MAIN, 'one')
    os.utime(builds.root / MAIN, ns=(before, before))
    reasons = [reason.text for reason in builds.decide().reasons]
    assert CHANGED in reasons


def test_a_file_that_is_there_during_the_build_only(builds):
    builds.build(lambda: builds.write('src/flow/new.c'))
    assert builds.why == 'new file new.c'
    (builds.root / 'src/flow/new.c').unlink()
    assert builds.why == 'new.c was deleted'
    builds.build()
    assert builds.why == ''


def test_a_file_that_is_missing_during_the_build(builds):
    builds.build((builds.root / MAIN).unlink)
    assert builds.why == 'main.c was deleted'
    builds.write(MAIN, 'one')
    assert builds.why == CHANGED
    builds.build()
    assert builds.why == ''


def test_a_header_from_elsewhere_that_is_edited_and_undone(builds):
    header = builds.write('common/x.h', 'one')

    def compiler():
        builds.write('build/flow/x.d', f'x.o: {header}\n')

    def edit():
        compiler()
        builds.write('common/x.h', 'two')
        builds.write('common/x.h', 'one')

    builds.build(compiler)
    assert builds.why == ''
    builds.write(MAIN, 'two')
    builds.build(edit)
    assert builds.why == f'{header} changed'
    builds.build(compiler)
    assert builds.why == ''
    builds.write(MAIN, 'three')
    builds.build(header.unlink)
    assert builds.why == f'{header} was deleted'


def test_a_build_that_writes_into_its_source_is_no_endless_one(builds):
    def generate():
        builds.write('src/flow/version.h', 'one')

    builds.build(generate)
    assert builds.why == 'new file version.h'
    builds.build(generate)
    assert builds.why == ''
    # one that writes it now and then only, and something else then
    builds.write(MAIN, 'two')
    builds.build()
    assert builds.why == ''
    builds.write(MAIN, 'three')
    builds.build(lambda: builds.write('src/flow/version.h', 'two'))
    assert builds.why == ''
    builds.write('src/flow/version.h', 'by hand')
    assert builds.why == 'version.h changed'


def test_a_build_that_writes_what_was_there_before(builds):
    def generate():
        builds.write('src/flow/version.h', 'one')

    generate()
    builds.build(generate)
    assert builds.why == 'version.h changed'
    builds.build(generate)
    assert builds.why == ''
    builds.build(generate)
    assert builds.why == ''


def test_edits_during_two_builds_are_no_generated_file(builds):
    for text in ('two', 'three', 'four'):
        builds.build(lambda text=text: builds.write(MAIN, text))
        assert builds.why == CHANGED


def test_what_editors_leave_during_a_build_does_not_matter(builds):
    builds.build(lambda: builds.write('src/flow/.main.c.swp', '1'))
    assert builds.why == ''
