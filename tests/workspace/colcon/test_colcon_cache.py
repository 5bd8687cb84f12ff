# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The cache of colcon is used while it holds, and never else."""

import json
import os
from pathlib import Path

from colcon_yamllaunch.common import fingerprint
from colcon_yamllaunch.workspace.colcon import colcon_cache
from colcon_yamllaunch.workspace.colcon.colcon_cache import (
    cache_key,
    CachedColcon,
)
from colcon_yamllaunch.workspace.packages.package import Package
from colcon_yamllaunch.workspace.packages.package_index import (
    IGNORED,
    PACKAGE,
    PackageIndex,
    PLAIN,
)
import pytest
from support.file_clock import let_files_settle
from support.manifest import manifest


class Identifier:
    """Knows a package by its manifest, and records what it was asked."""

    def __init__(self, root):
        self.root = root
        self.asked = []

    def identify(self, folder):
        self.asked.append(folder)
        files = os.listdir(self.root / folder)
        if 'AMENT_IGNORE' in files:
            return IGNORED, ''
        if 'package.xml' in files:
            return PACKAGE, 'ros.ament_cmake'
        return PLAIN, ''

    def describe(self):
        return {
            folder: (
                Package(
                    Path(folder).name, self.root / folder, 'ros.ament_cmake'
                ),
                '',
            )
            for folder in self.asked
            if (self.root / folder / 'package.xml').exists()
        }


@pytest.fixture
def find(workspace):
    """Find packages; get them, what was asked and what to keep."""

    def run(known=None, environment=None, everywhere=False):
        identifier = Identifier(workspace.root)
        index = PackageIndex(
            workspace.root, ['.'], environment or {}, everywhere
        )
        index.find(known or {}, lambda: identifier)
        entries = json.loads(json.dumps(index.cacheable_entries()))
        return sorted(index.packages()), identifier.asked, entries

    return run


@pytest.fixture
def two(workspace):
    """A workspace with two packages whose files are no longer new."""
    for name in ('one', 'two'):
        workspace.write(
            f'src/{name}/package.xml', manifest(name, 'ament_cmake')
        )
    workspace.write('src/notes/deep/readme.txt')
    workspace.write('build/COLCON_IGNORE')
    let_files_settle(workspace.root.parent)
    return workspace


def test_nothing_is_asked_again(two, find):
    packages, asked, entries = find()
    assert packages == ['./src/one', './src/two']
    assert asked == ['./src/one', './src/two']
    assert find(entries) == (packages, [], entries)


def test_only_what_changed_is_asked(two, find, monkeypatch):
    _, _, entries = find()
    monkeypatch.setattr(fingerprint, 'TICK', 10**12)
    two.write('src/one/package.xml', manifest('one', 'cmake'))
    two.write('src/three/package.xml', manifest('three', 'cmake'))
    _, asked, entries = find(entries)
    assert asked == ['./src/one', './src/three']
    # they changed a moment ago, so that another change might not show
    _, asked, entries = find(entries)
    assert asked == ['./src/one', './src/three']


def test_new_file_beside_a_manifest_is_seen_once(two, find):
    _, _, entries = find()
    two.write('src/one/README.md')
    _, asked, _ = find(entries)
    assert asked == []


@pytest.mark.parametrize(
    'damage',
    [
        lambda entry: entry.clear(),
        lambda entry: entry.pop('name'),
        lambda entry: entry.update(kind='other'),
        lambda entry: entry.update(files=[]),
        lambda entry: entry.update(files={'package.xml': None}),
        lambda entry: entry.update(folders=None),
        lambda entry: entry.update(variables='x'),
    ],
)
def test_damaged_entry_is_asked_again(two, find, damage):
    packages, _, entries = find()
    damage(entries['./src/one'])
    found, asked, _ = find(entries)
    assert found == packages
    assert './src/one' in asked


def test_variables_of_conditions(two, find):
    text = manifest(
        'one', 'ament_cmake', '<depend condition="$A == 1">two</depend>'
    )
    two.write('src/one/package.xml', text)
    let_files_settle(two.root.parent)
    _, _, entries = find(environment={'A': '1', 'B': '1'})
    assert find(entries, environment={'A': '1', 'B': '2'})[1] == []
    assert find(entries, environment={'A': '2'})[1] == ['./src/one']
    assert find(entries, environment={})[1] == ['./src/one']


def test_any_folder_is_asked_when_files_elsewhere_may_say_so(two, find):
    _, asked, entries = find(everywhere=True)
    assert './src/notes/deep' in asked
    assert './build' not in asked
    assert find(entries, everywhere=True)[1] == []


class Colcon:
    """Stands for colcon, which must not be asked."""

    def __init__(self, root, arguments, runs):
        raise AssertionError('colcon was asked')


@pytest.fixture
def known(two, monkeypatch):
    """A workspace that is known to this process."""
    monkeypatch.setenv('COLCON_HOME', str(two.root.parent / 'colcon_home'))
    monkeypatch.chdir(two.root)
    for name in list(os.environ):
        if name.startswith('COLCON_') and name != 'COLCON_HOME':
            monkeypatch.delenv(name)
    text = (
        'from colcon_yamllaunch.workspace.colcon.colcon_cache '
        'import CachedColcon\n'
        f'colcon = CachedColcon(Path({str(two.root)!r}), ())\n'
        'show([p.name for p in colcon.packages()])\n'
    )
    (names,), output = two.run(text, environment=two.environment())
    assert names == ['one', 'two'], output
    path = two.root / 'build' / colcon_cache.CACHE_NAME
    # as if this process had written it
    values = json.loads(path.read_bytes())
    values['key'] = cache_key(Path(os.path.realpath(two.root)), (), os.environ)
    path.write_text(json.dumps(values))
    monkeypatch.setattr(
        'colcon_yamllaunch.workspace.colcon.colcon_adapter.Colcon',
        Colcon,
    )
    return path


def test_known_workspace_needs_no_colcon(two, known):
    colcon = CachedColcon(two.root)
    assert [p.name for p in colcon.packages()] == ['one', 'two']
    assert colcon.install_base == two.root / 'install'
    assert not colcon.merge_install
    assert colcon.settings('one')['merge_install'] == 'false'


def test_layout_is_looked_up(two, known):
    two.write('install/.colcon_install_layout', 'merged\n')
    colcon = CachedColcon(two.root)
    assert colcon.merge_install
    assert colcon.settings('one')['merge_install'] == 'true'


@pytest.mark.parametrize(
    ('key', 'value'),
    [
        ('version', colcon_cache.CACHE_VERSION + 1),
        ('named', {'/nowhere': [1, 2, 3, 4]}),
        ('named', None),
        ('everywhere', None),
        ('arguments', {}),
        ('arguments', {'build_base': 3}),
        ('key', None),
        ('folders', {'src': 1}),
        ('folders', None),
    ],
)
def test_damaged_cache_is_not_used(two, known, key, value):
    values = json.loads(known.read_bytes())
    known.write_text(json.dumps(values | {key: value}))
    with pytest.raises(AssertionError, match='was asked'):
        CachedColcon(two.root)


@pytest.mark.parametrize('content', [b'', b'{', b'[]', b'\xff', b'null'])
def test_unreadable_cache_is_not_used(two, known, content):
    known.write_bytes(content)
    with pytest.raises(AssertionError, match='was asked'):
        CachedColcon(two.root)


@pytest.mark.parametrize(
    ('key', 'value'),
    [
        ('program', '0.0.0'),
        ('python', ['/usr/bin/python0', '0']),
        ('root', '/elsewhere'),
        ('arguments', ['--merge-install']),
        ('variables', {'COLCON_HOME': '/elsewhere'}),
        ('extensions', {}),
        ('installed', {}),
        ('files', {}),
    ],
)
def test_cache_with_another_key_is_not_used(two, known, key, value):
    values = json.loads(known.read_bytes())
    values['key'][key] = value
    known.write_text(json.dumps(values))
    with pytest.raises(AssertionError, match='was asked'):
        CachedColcon(two.root)


def test_nothing_is_cached_with_an_unknown_extension(two, monkeypatch):
    module = 'colcon_yamllaunch.workspace.colcon.colcon_cache'
    monkeypatch.delenv('COLCON_EXTENSION_BLOCKLIST', raising=False)
    assert cache_key(two.root, (), {}) is not None
    monkeypatch.setattr(
        f'{module}.get_extension_points',
        lambda group: {'cargo': 'colcon_cargo.identification:Cargo'},
    )
    assert cache_key(two.root, (), {}) is None
