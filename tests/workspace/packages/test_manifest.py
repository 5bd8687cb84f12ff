# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Manifests that colcon passes over."""

from colcon_yamllaunch.workspace.packages.package import (
    broken_manifests,
    invalid_manifest,
    Package,
)

BAD_MAIL = '<package format="3"><name>my_pkg</name></package>'


def test_colcon_takes_a_broken_package_for_plain_cmake(workspace):
    folder = workspace.ament_cmake('my_pkg')
    manifest = folder / 'package.xml'
    text = manifest.read_text().replace('someone@example.com', 'a@b.c')
    manifest.write_text(text)
    code = (
        'from colcon_yamllaunch.workspace.packages.package '
        'import invalid_manifest\n'
        f'colcon = CachedColcon(Path({str(workspace.root)!r}))\n'
        'show([[p.type, invalid_manifest(p)] for p in colcon.packages()])\n'
    )
    (((type_, reason),),), _ = workspace.run(code)
    assert type_ == 'cmake'
    assert 'email' in reason.lower()
    assert '\n' not in reason


def test_sound_packages_have_nothing_to_object_to(workspace):
    folder = workspace.manifest('a')
    assert invalid_manifest(Package('a', folder, 'cmake')) is None
    plain = workspace.cmake('b')
    assert invalid_manifest(Package('b', plain, 'cmake')) is None


def test_two_build_types(workspace):
    folder = workspace.manifest('a')
    text = (folder / 'package.xml').read_text()
    text = text.replace('<export>', '<export><build_type>x</build_type>')
    (folder / 'package.xml').write_text(text)
    reason = invalid_manifest(Package('a', folder, 'cmake'))
    assert 'build_type' in reason or 'build type' in reason


def test_manifests_that_make_no_package(workspace):
    workspace.write('src/my_pkg/package.xml', BAD_MAIL)
    workspace.write('src/garbled/package.xml', '<package')
    workspace.write('src/ignored/package.xml', BAD_MAIL)
    workspace.write('src/ignored/COLCON_IGNORE')
    workspace.write('src/known/package.xml', BAD_MAIL)
    known = Package('known', workspace.root / 'src/known', 'cmake')
    broken = broken_manifests([workspace.root], [known])
    assert [(b.name, b.path.name) for b in broken] == [
        (None, 'garbled'),
        ('my_pkg', 'my_pkg'),
    ]
    assert all(b.reason for b in broken)
