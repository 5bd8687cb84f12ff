# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
A sweep as a JUnit report, with a case for each run.

It keeps to the schemas that `observers/junit.py` names.
"""

from collections.abc import Mapping
import platform
import re
import time
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from colcon_yamllaunch.sweep.run_result import RunResult
from colcon_yamllaunch.sweep.run_table import Run
from colcon_yamllaunch.sweep.run_table import RunTable

# what XML 1.0 has no place for (its production "Char")
_NOT_IN_XML = re.compile(
    '[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]'
)


def junit_report(
    title: str,
    class_name: str,
    table: RunTable,
    results: Mapping[int, RunResult],
    logs: Mapping[int, str],
    started: float,
) -> bytes:
    """
    Return the report.

    :param title: The package and the launch file
    :param class_name: The name under which the cases are grouped
    :param logs: Where the logs of a run are
    :param started: When, in seconds since the epoch
    """
    cases = [
        _case(table.title(run), class_name, run, results, logs)
        for run in table.runs
    ]
    seconds = sum(result.seconds for result in results.values())
    suite = Element(
        'testsuite',
        {
            'name': _clean(title),
            'package': _clean(class_name),
            'id': '0',
            'timestamp': time.strftime(
                '%Y-%m-%dT%H:%M:%S', time.gmtime(started)
            ),
            'hostname': platform.node() or 'localhost',
            'tests': str(len(cases)),
            'failures': _count(cases, 'failure'),
            'errors': _count(cases, 'error'),
            'skipped': _count(cases, 'skipped'),
            'time': f'{seconds:.3f}',
        },
    )
    ElementTree.SubElement(suite, 'properties')
    suite.extend(cases)
    for name in ('system-out', 'system-err'):
        ElementTree.SubElement(suite, name)
    root = Element('testsuites')
    root.append(suite)
    ElementTree.indent(root)
    xml: bytes = ElementTree.tostring(root, 'utf-8', xml_declaration=True)
    return xml + b'\n'


def _case(
    name: str,
    class_name: str,
    run: Run,
    results: Mapping[int, RunResult],
    logs: Mapping[int, str],
) -> Element:
    result = results.get(run.number)
    seconds = 0.0 if result is None else result.seconds
    element = Element(
        'testcase',
        {
            'name': _clean(name),
            'classname': _clean(class_name),
            'time': f'{seconds:.3f}',
        },
    )
    if result is None:
        message = {'message': 'it was not run yet'}
        ElementTree.SubElement(element, 'skipped', message)
    elif not result.succeeded:
        kind = 'failure' if result.outcome == 'failed' else 'error'
        attributes = {'message': _clean(result.reason), 'type': 'run'}
        found = ElementTree.SubElement(element, kind, attributes)
        found.text = _clean(f'{result.reason}\n\nlogs: {logs[run.number]}')
    return element


def _count(cases: list[Element], kind: str) -> str:
    return str(sum(case.find(kind) is not None for case in cases))


def _clean(text: str) -> str:
    return _NOT_IN_XML.sub('', text)
