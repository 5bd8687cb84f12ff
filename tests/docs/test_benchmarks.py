# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""`benchmarks/peers.py` measures a launcher, and its report says what."""

import importlib
from pathlib import Path
import platform
import subprocess
import sys
from types import ModuleType
from typing import Any
from xml.etree import ElementTree

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture
def peers(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(str(ROOT / 'benchmarks'))
    return importlib.import_module('peers')


@pytest.fixture
def launchers(peers: ModuleType) -> ModuleType:
    return importlib.import_module('peers_launchers')


@pytest.fixture
def report(peers: ModuleType) -> ModuleType:
    return importlib.import_module('peers_report')


@pytest.fixture
def filled(report: ModuleType) -> Any:
    """Return a report of three launchers, of which one does not start."""
    filled = report.Report()
    for seconds in (0.2, 0.4, 0.3):
        filled.add('colcon launch', {'one': seconds, 'left': 0.0})
    filled.add('fast', {'one': 0.1, 'left': 144.0})
    filled.fail('fast', {'stop'}, 'it did not end')
    filled.versions |= {
        'colcon launch': '0.1.0',
        'absent': 'not available here',
        'fast': '1.2',
    }
    filled.machine |= {'cores': '2'}
    return filled


def test_table_has_medians_and_quartiles(filled: Any) -> None:
    head, _, *lines = filled.table().splitlines()
    assert head == '|  | colcon launch | fast |'
    assert lines == [
        '| start one program | 0.3 s (0.25–0.35) | 0.1 s |',
        '| processes left 12 s after SIGKILL | 0 | 144 |',
    ]


def test_where_others_need_less_is_named(filled: Any) -> None:
    assert list(filled.worse()) == ['start one program: 0.3 s; fast 0.1 s']


def test_plot_has_a_bar_for_each_launcher(filled: Any) -> None:
    plot = ElementTree.fromstring(filled.plot('times'))
    texts = [text for text in plot.itertext() if text.strip()]
    assert texts[1:] == [
        *('start one program (s)', 'colcon launch', '0.3 s', 'fast', '0.1 s')
    ]


def test_block_is_replaced_in_the_page(
    filled: Any, report: ModuleType, tmp_path: Path
) -> None:
    page = tmp_path / 'benchmarks.md'
    page.write_text(f'a\n{report.BEGIN}\nold\n{report.END}\nb\n')
    for _ in range(2):
        report.write_report(filled, tmp_path)
    text = page.read_text()
    assert text.startswith(f'a\n{report.BEGIN}\n\n| machine |')
    assert text.endswith(f'- fast: it did not end\n\n{report.END}\nb\n')
    assert '| absent | not available here |' in text
    assert 'old' not in text
    assert (tmp_path / 'benchmarks_times.svg').is_file()


def test_machine_has_no_names_and_paths(report: ModuleType) -> None:
    machine = report.machine(3)
    assert machine['runs'] == '3'
    assert int(machine['cores']) > 0
    text = ' '.join(machine.values()).replace('GNU/Linux', '')
    assert '/' not in text
    assert platform.node() not in text.split()


def test_launcher_that_does_not_start_is_reported(
    launchers: ModuleType, tmp_path: Path
) -> None:
    program = tmp_path / 'broken'
    program.write_text(
        '#!/bin/sh\necho "/tmp/x/broken: no library" >&2\nexit 1'
    )
    program.chmod(0o755)
    peer = launchers.Peer('broken', 'broken', '', 'broken', path=program)
    with pytest.raises(
        launchers.FailedError, match=r'here: broken: no library$'
    ):
        launchers.version(peer)


def test_release_that_cannot_be_downloaded_is_reported(
    launchers: ModuleType, tmp_path: Path
) -> None:
    address = (tmp_path / 'missing.tar.gz').as_uri()
    with pytest.raises(launchers.FailedError, match='not available here'):
        launchers.download(address, 'program', tmp_path / 'folder')


@pytest.mark.parametrize('name', ['one_program', 'edited'])
def test_trivial_launcher_is_measured(
    peers: ModuleType,
    launchers: ModuleType,
    tmp_path: Path,
    name: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(peers, 'PROCESSES', 3)
    peer = launchers.Peer(
        'shell',
        'sh',
        'sh {file}',
        '',
        write=lambda commands: (
            ''.join(f'{c[0]} &\n' for c in commands) + 'wait'
        ),
    )
    measured = getattr(peers, name)(peer, peers.Room(tmp_path))
    assert all(0 < seconds < 60 for seconds in measured.values())
    assert measured


def test_help_of_the_benchmark() -> None:
    command = [sys.executable, ROOT / 'benchmarks/peers.py', '--help']
    ended = subprocess.run(command, capture_output=True, text=True, check=True)
    assert '--autoware FOLDER' in ended.stdout
