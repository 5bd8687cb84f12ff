# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""JUnit reports of replayed launches."""

from dataclasses import replace
from pathlib import Path
import re
from xml.etree import ElementTree

from colcon_yamllaunch.engine.events import (
    Dropped,
    Ended,
    Exited,
    FailureReport,
    Loaded,
    MemberChanged,
    NotReady,
    Planned,
    Ready,
    Started,
    Waiting,
)
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.observers.junit import JUnitReport
import pytest
from support.history import component
from support.launch_states import planned_state

# what both schemas ask for, see the module's docstring
SUITE = {
    'name': r'.+',
    'package': r'.+',
    'id': r'\d+',
    'timestamp': r'\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d',
    'hostname': r'.+',
    'tests': r'\d+',
    'failures': r'\d+',
    'errors': r'\d+',
    'skipped': r'\d+',
    'time': r'\d{1,3}\.\d{3}',
}
CASE = {'name': r'.+', 'classname': r'.+', 'time': r'\d{1,3}\.\d{3}'}
OUTCOMES = {
    'failure': {'message': '.+', 'type': '.+'},
    'error': {'message': '.+', 'type': '.+'},
    'skipped': {'message': '.+'},
}


def check(element, attributes):
    assert set(element.attrib) == set(attributes)
    for name, value in element.attrib.items():
        assert re.fullmatch(attributes[name], value), (name, value)


@pytest.fixture
def report():
    """Return a function that replays events, and returns a checked suite."""

    def make(*events, processes=(), name='my_pkg demo.yaml', after=()):
        junit = JUnitReport(name, 'my_pkg.demo', 1_732_000_000.5)
        state = planned_state(*processes)
        state.has_readiness = bool(after)
        state.after = dict(after)
        for event in events:
            state.apply(event)
            if isinstance(event, Ended):
                event = replace(event, state=state)
            junit.handle(event)
        root = ElementTree.fromstring(junit.document(12.3456))
        assert root.tag == 'testsuites'
        (suite,) = root
        check(suite, SUITE)
        first, *cases, out, err = (child.tag for child in suite)
        assert set(cases) <= {'testcase'}
        assert (first, out, err) == ('properties', 'system-out', 'system-err')
        assert suite.get('tests') == str(len(cases))
        for case in suite.iter('testcase'):
            check(case, CASE)
            assert len(case) <= 1
            for outcome in case:
                check(outcome, OUTCOMES[outcome.tag])
        return suite

    return make


def exited(process, seconds=1.25):
    return Exited(process, 9, Outcome(code=0), seconds, False, False)


def test_each_process_is_a_case(report, process):
    good, bad, late = map(process, ('good', 'bad', 'late'))
    text, log = 'bad exited with code 3 after 1.2 s', Path('/log/bad/out.log')
    failure = FailureReport(bad, text, ('one', 'two'), log)
    suite = report(
        *(Started(good, 8), Started(bad, 9), exited(good), exited(bad)),
        Ended(1, (), (failure,)),
        processes=(good, bad, late),
    )
    assert suite.get('timestamp') == '2024-11-19T07:06:40'
    assert suite.get('time') == '12.346'
    counts = [suite.get(n) for n in ('failures', 'errors', 'skipped')]
    assert counts == ['1', '0', '1']
    first, second, third = suite.iter('testcase')
    attributes = [first.get(n) for n in ('name', 'classname', 'time')]
    assert attributes == ['good', 'my_pkg.demo', '1.250']
    assert len(first) == 0
    assert second[0].get('message') == text
    assert second[0].text == (
        f'{text}\nfrom /ws/demo.yaml:14:5\n\n'
        'the last lines of its output:\none\ntwo\n\n'
        f'all of its output: {log}'
    )
    assert third[0].tag == 'skipped'


def test_launch_that_never_ended_is_an_error(report, process):
    suite = report(processes=(process('a'),))
    assert suite.get('errors') == '1'


@pytest.mark.parametrize(('code', 'tag'), [(0, 'skipped'), (1, 'failure')])
def test_readiness_of_each_process_is_a_case(report, process, code, tag):
    driver, nav, map_server = map(process, ('driver', 'nav', 'map_server'))
    unmet = ('a publisher of scan',)
    suite = report(
        *(Waiting(nav, ('driver',)), Started(driver, 8), Started(nav, 9)),
        *(MemberChanged(driver, unmet=unmet), Ready(nav, 1.5)),
        NotReady(map_server, ('the file x',), 'warn', 60.0),
        Ended(code),
        processes=(driver, nav, map_server),
        after={'nav': ('driver',)},
    )
    cases = {case.get('name'): case for case in suite.iter('testcase')}
    assert cases['nav is ready'].get('time') == '1.500'
    assert len(cases['nav is ready']) == 0
    (outcome,) = cases['driver is ready']
    assert outcome.tag == tag
    assert outcome.get('message') == 'waiting for a publisher of scan'
    (outcome,) = cases['map_server is ready']
    assert outcome.tag == 'failure'
    assert 'not ready after 60.0 s' in outcome.get('message')


def test_time_of_a_case_is_the_sum_of_runs(report, process):
    a = process('a')
    events = (Started(a, 8), exited(a), Started(a, 9), exited(a), Ended(0))
    suite = report(*events, processes=(a,))
    assert next(suite.iter('testcase')).get('time') == '2.500'


def test_characters_invalid_in_xml_are_removed(report, process):
    odd = process('od\x00d\x1b\ud800')
    failure = FailureReport(odd, 'a\x01b', ('<c> & \x07"d"\uffff',))
    suite = report(
        Ended(1, (), (failure,)), processes=(odd,), name='a\x0bb.yaml'
    )
    assert suite.get('name') == 'ab.yaml'
    (case,) = suite.iter('testcase')
    assert case.get('name') == 'odd'
    assert case[0].get('message') == 'ab'
    assert '<c> & "d"\n' in case[0].text + '\n'


def test_each_component_is_a_case(report):
    good, bad, late = map(component, ('good', 'bad', 'late'))
    failures = (
        FailureReport(bad, 'bad could not be loaded'),
        FailureReport(None, 'ROS is lost'),
    )
    suite = report(
        *(Loaded(good, '/good', 1, 0.25), Ended(1, (), failures)),
        processes=(good, bad, late),
    )
    cases = {case.get('name'): case for case in suite.iter('testcase')}
    assert list(cases) == ['good', 'bad', 'late', 'launch']
    assert cases['good'].get('time') == '0.250'
    assert cases['bad'][0].tag == 'failure'
    assert '/ws/demo.yaml:7:9' in cases['bad'][0].text
    assert cases['late'][0].get('message') == 'it was never loaded'
    assert cases['launch'][0].get('message') == 'ROS is lost'


def test_processes_planned_later_are_cases(report, process):
    a, b, c = map(process, 'abc')
    suite = report(
        *(Started(a, 9), Planned((b, c)), Planned((b,))),
        *(Started(c, 9), Dropped(c), Ended(0)),
        processes=[a],
    )
    cases = {c.get('name'): c for c in suite.iter('testcase')}
    assert list(cases) == ['a', 'b']
    assert cases['b'].find('skipped').get('message') == 'it was never started'
