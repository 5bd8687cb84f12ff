# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
A launch as a JUnit report.

There is no standard; the report is valid against the two schemas that are in
use, that of Jenkins' xUnit plugin (junit-10.xsd) and that of Apache Ant's
reports (JUnit.xsd by Windy Road).
"""

from collections import Counter
from collections.abc import Iterator, Sequence
import platform
import re
import time
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.readiness_record import ReadinessRecord
from colcon_yamllaunch.engine.state import LaunchState, ProcessState

# what XML 1.0 has no place for (its production "Char")
_NOT_IN_XML = re.compile(
    '[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]'
)


class JUnitReport:
    """
    The report of a launch, with one case for each process and component.

    The last run of a process that is respawned decides, as for the exit code.
    Each exit condition of the launch has a case, too, and so has the readiness
    of each process and component if the launch knows what is ready.

    :param class_name: The name under which the cases are grouped, members
      separated by dots
    :param started: When, in seconds since the epoch
    """

    def __init__(self, name: str, class_name: str, started: float) -> None:
        self._name = name
        self._class_name = class_name
        self._started = started
        self._ended: events.Ended | None = None
        self._readiness = ReadinessRecord()

    def handle(self, event: events.Event) -> None:
        """Note an event of the launch."""
        self._readiness.handle(event)
        if isinstance(event, events.Ended):
            self._ended = event

    def document(self, seconds: float) -> bytes:
        """Return the report."""
        cases = [
            junit_case(name, self._class_name, taken, outcome)
            for name, taken, outcome in self._cases()
        ]
        return junit_document(
            self._name, self._class_name, self._started, seconds, cases
        )

    def _cases(self) -> Iterator[tuple[str, float, Element | None]]:
        """Iterate over names, seconds, and why a case did not succeed."""
        if self._ended is None:
            text = 'the launch failed before a process was started'
            yield 'launch', 0.0, junit_outcome('error', text, source='launch')
            return
        failures = {
            None if f.member is None else f.member.label: f
            for f in self._ended.failures
        }
        state = self._ended.state
        for label, member in state.by_label.items() if state else ():
            outcome = None
            if label in failures:
                outcome = _failure(failures[label])
            elif not member.is_begun:
                is_process = isinstance(member, ProcessState)
                what = 'started' if is_process else 'loaded'
                outcome = junit_outcome('skipped', f'it was never {what}')
            yield label, member.run_seconds, outcome
        if state is not None and state.has_readiness:
            yield from self._readiness_cases(state, self._ended.exit_code)
        if None in failures:
            yield 'launch', 0.0, _failure(failures[None])
        for verdict in self._ended.verdicts:
            missed = None
            if verdict.failure is not None:
                missed = junit_outcome(
                    'failure', verdict.failure, source='launch'
                )
            yield verdict.name, verdict.seconds, missed

    def _readiness_cases(
        self, state: LaunchState, exit_code: int
    ) -> Iterator[tuple[str, float, Element | None]]:
        """
        Iterate over the times until members were ready, or why they were not.

        A launch that succeeded may have ended before all were ready.
        """
        known = self._readiness
        for label in state.by_label:
            outcome = None
            if label not in known.seconds:
                text = known.reasons.get(label, 'not started')
                if exit_code or label in known.failed:
                    outcome = junit_outcome('failure', text, source='launch')
                else:
                    outcome = junit_outcome('skipped', text)
            yield f'{label} is ready', known.seconds.get(label, 0.0), outcome


def _failure(report: events.FailureReport) -> Element:
    lines = [report.text]
    if report.member is not None:
        lines.append(f'from {report.member.position}')
    if report.tail:
        lines += ['', 'the last lines of its output:', *report.tail]
    if report.log_file is not None:
        lines += ['', f'all of its output: {report.log_file}']
    return junit_outcome('failure', report.text, '\n'.join(lines), 'launch')


def junit_document(
    name: str,
    class_name: str,
    started: float,
    seconds: float,
    cases: Sequence[Element],
) -> bytes:
    """
    Return a report with one suite.

    :param class_name: The name under which the cases are grouped
    :param started: When, in seconds since the epoch
    """
    outcomes = Counter(outcome.tag for case in cases for outcome in case)
    suite = Element(
        'testsuite',
        {
            'name': _clean(name),
            'package': _clean(class_name),
            'id': '0',
            'timestamp': time.strftime(
                '%Y-%m-%dT%H:%M:%S', time.gmtime(started)
            ),
            'hostname': platform.node() or 'localhost',
            'tests': str(len(cases)),
            'failures': str(outcomes['failure']),
            'errors': str(outcomes['error']),
            'skipped': str(outcomes['skipped']),
            'time': f'{seconds:.3f}',
        },
    )
    ElementTree.SubElement(suite, 'properties')
    suite.extend(cases)
    for stream in ('system-out', 'system-err'):
        ElementTree.SubElement(suite, stream)
    root = Element('testsuites')
    root.append(suite)
    ElementTree.indent(root)
    xml: bytes = ElementTree.tostring(root, 'utf-8', xml_declaration=True)
    return xml + b'\n'


def junit_case(
    name: str, class_name: str, seconds: float, outcome: Element | None
) -> Element:
    """Return a case; `outcome` is None if it succeeded."""
    attributes = {
        'name': _clean(name),
        'classname': _clean(class_name),
        'time': f'{seconds:.3f}',
    }
    element = Element('testcase', attributes)
    if outcome is not None:
        element.append(outcome)
    return element


def junit_outcome(
    kind: str, message: str, text: str = '', source: str = ''
) -> Element:
    """
    Return why a case did not succeed.

    :param kind: `failure`, `error` or `skipped`
    :param text: More about a failure or an error, by default the message
    :param source: The type of a failure or an error
    """
    element = Element(kind, {'message': _clean(message)})
    if source:
        element.set('type', source)
        element.text = _clean(text or message)
    return element


def _clean(text: str) -> str:
    return _NOT_IN_XML.sub('', text)
