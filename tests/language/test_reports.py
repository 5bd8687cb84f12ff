# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The formats that a check's problems are shown in."""

import json
from typing import Any

from colcon_yamllaunch.language.evaluation.findings import CheckResult
from colcon_yamllaunch.language.reports import (
    as_github,
    as_json,
    as_sarif,
    as_text,
)
from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic
from colcon_yamllaunch.language.syntax.source_text import Source
from colcon_yamllaunch.plan.position import Position

ERROR = Diagnostic(
    'error',
    '100% wrong: a, b',
    Position('/ws/launch/a b,c.yaml', 3, 5),
    hint='see\nbelow',
    length=4,
    includes=(Position('/ws/top.yaml', 2, 7),),
)
WARNING = Diagnostic('warning', 'odd', Position('/else/ä.yaml', 1, 1))
ARGUMENT = Diagnostic('warning', 'no such argument')


def _checked(*diagnostics: Diagnostic) -> CheckResult:
    files = tuple(
        Source(path, path, '')
        for path in ('/ws/top.yaml', '/ws/launch/a b,c.yaml')
    )
    return CheckResult(diagnostics, files, {}, (), ())


def test_text() -> None:
    lines = as_text(_checked(ERROR, WARNING, ARGUMENT), '/ws').split('\n')
    assert lines[0] == 'launch/a b,c.yaml:3:5: error: 100% wrong: a, b'
    assert lines[-1] == '1 error, 2 warnings in 2 launch files'


def test_text_without_problems() -> None:
    assert as_text(_checked(), '/ws') == 'no problems in 2 launch files'


def test_json() -> None:
    document = json.loads(as_json(_checked(ERROR, ARGUMENT), '/ws'))
    assert document == {
        'version': 1,
        'files': ['top.yaml', 'launch/a b,c.yaml'],
        'diagnostics': [
            {
                'severity': 'error',
                'message': '100% wrong: a, b',
                'help': 'see\nbelow',
                'path': 'launch/a b,c.yaml',
                'line': 3,
                'column': 5,
                'length': 4,
                'includes': [{'path': 'top.yaml', 'line': 2, 'column': 7}],
            },
            {
                'severity': 'warning',
                'message': 'no such argument',
                'help': None,
                'path': None,
                'line': None,
                'column': None,
                'length': 1,
                'includes': [],
            },
        ],
    }


def test_github() -> None:
    lines = as_github(_checked(ERROR, WARNING, ARGUMENT), '/ws').split('\n')
    assert lines == [
        '::error file=launch/a b%2Cc.yaml,line=3,col=5,endColumn=9'
        '::100%25 wrong: a, b%0Ahelp: see%0Abelow',
        '::warning file=/else/ä.yaml,line=1,col=1,endColumn=2::odd',
        '::warning::no such argument',
        '1 error, 2 warnings in 2 launch files',
    ]


def _run(*diagnostics: Diagnostic) -> Any:
    log = json.loads(as_sarif(_checked(*diagnostics), '/ws'))
    assert log['version'] == '2.1.0'
    (run,) = log['runs']
    return run


def test_sarif_results() -> None:
    first, second, third = _run(ERROR, WARNING, ARGUMENT)['results']
    assert first['level'] == 'error'
    (location,) = first['locations']
    place = location['physicalLocation']
    assert place == {
        'artifactLocation': {
            'uri': 'launch/a%20b%2Cc.yaml',
            'uriBaseId': 'SRCROOT',
        },
        'region': {'startLine': 3, 'startColumn': 5, 'endColumn': 9},
    }
    assert len(first['relatedLocations']) == 1
    (location,) = second['locations']
    artifact = location['physicalLocation']['artifactLocation']
    assert artifact == {'uri': 'file:///else/%C3%A4.yaml'}
    assert 'locations' not in third


def test_sarif_rules() -> None:
    run = _run(ERROR, WARNING)
    rules = run['tool']['driver']['rules']
    for result in run['results']:
        assert rules[result['ruleIndex']]['id'] == result['ruleId']
    # a base must end with a slash (SARIF 2.1.0, 3.14.14)
    assert run['originalUriBaseIds']['SRCROOT']['uri'] == 'file:///ws/'
