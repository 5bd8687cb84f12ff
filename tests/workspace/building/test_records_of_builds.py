# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is recorded around a build, with a colcon that is none."""

from pathlib import Path
from types import SimpleNamespace

from colcon_yamllaunch.common import files as common_files
from colcon_yamllaunch.workspace.building import update
from colcon_yamllaunch.workspace.colcon.colcon_cache import BuildResult
from colcon_yamllaunch.workspace.environment.sourcing import Environment
from colcon_yamllaunch.workspace.freshness.build_record import BuildMode
from colcon_yamllaunch.workspace.packages.package import Package
import pytest
from support.file_clock import let_files_settle

pytestmark = pytest.mark.hostile


class FakeColcon(SimpleNamespace):
    """A colcon that makes an object of each package."""

    merge_install = False

    def __init__(self, root: Path, *packages: Package) -> None:
        super().__init__(
            build_base=root / 'build',
            install_base=root / 'install',
            packages=lambda: packages,
            settings=lambda _: {},
            mark=bool,
            meanwhile=bool,
        )
        self.install_base.mkdir()
        for script in ('setup.sh', 'local_setup.sh'):
            (self.install_base / script).touch()
        (self.install_base / '_local_setup_util_sh.py').touch()

    def build(self, names, environment):
        for name in names:
            path = self.build_base / name / 'main.o'
            if not path.exists():
                path.write_text('good')
        self.meanwhile()
        return BuildResult(0, frozenset(names))


@pytest.fixture
def colcon(tmp_path):
    source = tmp_path / 'src/flow'
    source.mkdir(parents=True)
    (source / 'main.c').touch()
    let_files_settle(tmp_path)
    return FakeColcon(tmp_path, Package('flow', source, 'cmake'))


def bring_up_to_date(colcon, force=False, **variables):
    done = update.bring_up_to_date(
        colcon,
        update.BuildRequest(['flow'], force=force),
        Environment(variables),
        lambda _: None,
    )
    let_files_settle(colcon.build_base)
    (decision,) = done.decisions
    return decision


def test_records_are_written_before_what_survives_a_power_cut(
    colcon, monkeypatch
):
    records = []

    def sync(folders):
        assert folders == [colcon.build_base, colcon.install_base]
        record = colcon.build_base / 'flow/colcon_launch.json'
        records.append('"succeeded": true' in record.read_text())

    monkeypatch.setattr(common_files, 'sync_file_systems', sync)
    bring_up_to_date(colcon)
    assert records == [True]
    bring_up_to_date(colcon)
    # one that builds nothing need not wait for disks
    assert records == [True]


def test_what_is_damaged_is_forced_from_scratch(colcon):
    bring_up_to_date(colcon)
    assert bring_up_to_date(colcon, force=True).mode is BuildMode.CONFIGURE
    product = colcon.build_base / 'flow/main.o'
    product.write_text('go')
    let_files_settle(colcon.build_base)
    decision = bring_up_to_date(colcon, force=True)
    assert decision.reason == 'asked for'
    assert decision.mode is BuildMode.CLEAN
    assert product.read_text() == 'good'


def test_an_underlay_that_is_built_meanwhile(tmp_path, colcon):
    below = tmp_path / 'below'
    script = below / 'share/below/package.sh'
    script.parent.mkdir(parents=True)
    script.write_text('one')
    index = below / 'share/colcon-core/packages/below'
    index.parent.mkdir(parents=True)
    index.touch()
    (package,) = colcon.packages()
    needs = Package('flow', package.path, 'cmake', frozenset({'below'}))
    colcon.packages = lambda: (needs,)
    sourced = {
        'COLCON_PREFIX_PATH': str(below),
        'AMENT_PREFIX_PATH': str(below),
        'CMAKE_PREFIX_PATH': str(below),
    }
    let_files_settle(tmp_path)
    colcon.meanwhile = lambda: script.write_text('two')
    assert bring_up_to_date(colcon, **sourced).reason == 'never built'
    colcon.meanwhile = bool
    assert bring_up_to_date(colcon, **sourced).reason == 'below was rebuilt'
    assert not bring_up_to_date(colcon, **sourced).is_stale
