# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The journal, results.csv, the JUnit report and the folder of all."""

import csv
from dataclasses import replace
import io
import json
from pathlib import Path
from xml.etree import ElementTree

from colcon_yamllaunch.common.codec import to_json
from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.sweep import reports, results
from colcon_yamllaunch.sweep.results import (
    Code,
    ResultsFolder,
    RunResult,
    SweepDefinition,
    SweepJournal,
    versions_of,
)
from colcon_yamllaunch.sweep.table import run_table
import pytest

TABLE = run_table({'seed': '1..2', 'outcome': 'a,b'}, repeats=2)
GOOD = RunResult(1, 'succeeded', seconds=1.25, metrics={'far': '3.5'})
BAD = RunResult(3, 'failed', 'it "stood", still', 2.0)


def definition(values: str = '1..2', **goal: str) -> SweepDefinition:
    table = run_table({'seed': values})
    return SweepDefinition(
        'colcon sweep …', ('my_pkg', 'a.yaml'), table, goal, {}
    )


def test_journal_restores_results(tmp_path: Path) -> None:
    path = tmp_path / 'journal.jsonl'
    journal = SweepJournal(path)
    journal.add(GOOD)
    journal.add(BAD)
    journal.add(RunResult(3, 'succeeded'))
    journal.close()
    again = SweepJournal(path)
    assert again.results == {1: GOOD, 3: RunResult(3, 'succeeded')}
    again.forget([1])
    again.close()
    assert list(SweepJournal(path).results) == [3]


def test_torn_line_in_the_journal_is_ignored(tmp_path: Path) -> None:
    path = tmp_path / 'journal.jsonl'
    whole = json.dumps(to_json(GOOD)).encode() + b'\n'
    path.write_bytes(whole + b'not json\n[1]\n' + whole[:20])
    journal = SweepJournal(path)
    assert journal.results == {1: GOOD}
    journal.add(BAD)
    journal.close()
    assert SweepJournal(path).results == {1: GOOD, 3: BAD}


def test_code_versions_differ_in_shared_parts_only(
    tmp_path: Path,
) -> None:
    """Runs may use other files, which makes no other version."""
    path = tmp_path / 'journal.jsonl'
    journal = SweepJournal(path)
    first = journal.plan(1, Code('abc', {'a': '1', 'b': '1'}))
    journal.add(GOOD)
    journal.close()
    journal = SweepJournal(path)
    assert journal.results[1] == replace(GOOD, commit='abc', fingerprint=first)
    assert journal.plan(2, Code('abc', {'a': '1', 'c': '1'})) == first
    other = journal.plan(3, Code('abc-dirty', {'a': '1', 'c': '2'}))
    assert other != first
    # an edit that is undone
    assert journal.plan(4, Code('abc', {'c': '1'})) == first
    journal.add(BAD)
    assert (BAD.run, journal.results[3].fingerprint) == (3, other)
    versions = versions_of(journal.results.values())
    assert list(versions) == [f'abc, {first}', f'abc-dirty, {other}']


@pytest.mark.parametrize(
    'line',
    [
        '{"again": [[1], {}, null]}',
        '{"again": {"1": 1}}',
        '{"planned": 1, "commit": [], "fingerprint": {}}',
        '{"fingerprint": "a", "parts": {"b": [{}]}}',
        *(
            json.dumps(to_json(GOOD) | values)
            for values in (
                *({'run': True}, {'seconds': 10**400}, {'seconds': [1]}),
                *({'metrics': [1]}, {'reason': None}, {'outcome': {}}),
            )
        ),
    ],
)
def test_unexpected_types_in_the_journal_are_skipped(
    tmp_path: Path, line: str
) -> None:
    path = tmp_path / 'journal.jsonl'
    path.write_text(f'{json.dumps(to_json(BAD))}\n{line}\n')
    assert SweepJournal(path).results == {3: BAD}


def test_results_as_a_table() -> None:
    good = replace(GOOD, commit='abc', fingerprint='f1')
    text = reports.results_csv(TABLE, {1: good, 3: BAD}, ['far'])
    assert list(csv.reader(io.StringIO(text))) == [
        [
            *('run', 'seed', 'argument outcome', 'repeat', 'outcome'),
            *('reason', 'seconds', 'far', 'commit', 'fingerprint'),
        ],
        ['1', '1', 'a', '1', 'succeeded', '', '1.250', '3.5', 'abc', 'f1'],
        [
            *('3', '1', 'b', '1', 'failed', 'it "stood", still', '2.000'),
            *('', '', ''),
        ],
    ]


@pytest.mark.parametrize(
    ('value', 'written'),
    [
        ('a\rb', '"a\rb"'),
        ('a"b\nc', '"a""b\nc"'),
        ('=1+1', "'=1+1"),
        ('@SUM(1)', "'@SUM(1)"),
        ("+cmd|' /C calc'!A0", "'+cmd|' /C calc'!A0"),
        ('-x', "'-x"),
        ('-1.5', '-1.5'),
        ('+3e-7', '+3e-7'),
        ('-inf', '-inf'),
        # so that the apostrophe can be taken away again
        ("'=1", "''=1"),
        ("'t is", "'t is"),
        (' =1', "' =1"),
        ('\t=1', "'\t=1"),
        ('\r=1', '"\'\r=1"'),
        ('\x1b[2J\x9b\0', '\\x1b[2J\\x9b\\x00'),
    ],
)
def test_values_of_the_csv_are_no_formulas(value: str, written: str) -> None:
    table = run_table({'a': '1,2'})
    run = replace(table.runs[0], arguments={'a': value})
    result = RunResult(1, 'failed', value, 1.0, {'m': value})
    text = reports.results_csv(
        replace(table, runs=(run,)), {1: result}, ['m', '=evil()']
    )
    head, _, row = text.partition('\n')
    assert head.startswith("run,a,outcome,reason,seconds,m,'=evil(),commit")
    assert row == f'1,{written},failed,{written},1.000,{written},,,\n'
    # what reads RFC 4180 gets one row
    assert len(list(csv.reader(io.StringIO(text, newline='')))) == 2


@pytest.mark.parametrize('name', ['seed', 'seconds', 'commit'])
def test_metric_named_like_a_column_is_refused(name: str) -> None:
    with pytest.raises(UserError, match=f"a column '{name}' already"):
        reports.refuse_columns_twice(['seed'], [name])
    reports.refuse_columns_twice(['seed'], ['time'])


def test_junit_has_a_case_for_each_run() -> None:
    results = {
        1: GOOD,
        3: BAD,
        4: RunResult(4, 'error', 'no \0 such file'),
    }
    sweep = SweepDefinition('', ('pkg', 'a.yaml'), TABLE, {}, {})
    report = reports.junit_report(
        sweep, results, lambda n: Path(f'/logs/{n}'), 0.0
    )
    suite = ElementTree.fromstring(report)[0]
    assert (suite.get('name'), suite.get('package')) == ('pkg a.yaml', 'pkg.a')
    assert suite.get('tests') == '8'
    assert suite.get('failures') == suite.get('errors') == '1'
    assert suite.get('skipped') == '5'
    cases = {c.get('name'): c for c in suite.iter('testcase')}
    assert next(iter(cases)) == 'seed:=1 outcome:=a (repeat 1)'
    failure = cases['seed:=1 outcome:=b (repeat 1)'].find('failure')
    assert failure is not None and failure.text is not None
    assert failure.text.endswith('logs: /logs/3')


def test_folder_without_results_may_be_reused(tmp_path: Path) -> None:
    """The command may have had a mistake."""
    for values in ('1..2', '1..3'):
        ResultsFolder(tmp_path, definition(values), print).close()
    (tmp_path / 'slurm').mkdir()
    (tmp_path / 'slurm' / 'arrays.json').touch()
    for other in (definition('1..4'), definition('1..3', timeout='5')):
        with pytest.raises(UserError, match='has the results of another'):
            ResultsFolder(tmp_path, other, print)


def test_unusable_results_folders_are_refused(tmp_path: Path) -> None:
    (tmp_path / 'thesis.tex').touch()
    with pytest.raises(UserError, match='has other files than the results'):
        ResultsFolder(tmp_path, definition(), print)
    with pytest.raises(UserError, match='cannot be written: Not a directory'):
        ResultsFolder(tmp_path / 'thesis.tex' / 'x', definition(), print)


def test_second_sweep_in_a_folder_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(results, '_LOCK_TIMEOUT', 0.2)
    monkeypatch.setattr(results, '_QUIET', 0.1)
    first = ResultsFolder(tmp_path, definition(), print)
    said: list[str] = []
    with pytest.raises(UserError, match='another colcon sweep is at work'):
        ResultsFolder(tmp_path, definition(), said.append)
    assert said == [f'waiting for the colcon sweep in {tmp_path} to end']
    first.close()


def test_the_same_sweep_has_the_same_folder() -> None:
    name = definition().default_name
    assert name.startswith('my_pkg-a-')
    assert name == definition().default_name
    assert name != definition('1..3').default_name
