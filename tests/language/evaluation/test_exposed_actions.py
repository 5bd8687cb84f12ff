# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Actions and substitutions of other packages reach the host as written."""

from collections.abc import Mapping
from dataclasses import replace
import json
from typing import Any

from colcon_yamllaunch.language.evaluation.request import Request
from colcon_yamllaunch.language.evaluation.walk import Walk
from colcon_yamllaunch.language.policies.check import check, find_declarations
from colcon_yamllaunch.language.policies.evaluate import evaluate, Evaluation
from colcon_yamllaunch.language.python_files import exposed_actions
from colcon_yamllaunch.language.python_files.python_visit import (
    NotTakenOverError,
)
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.plan.position import Span
import pytest
from support.language_fixtures import Launcher


class Brought:
    """What two packages bring, one of them not built yet."""

    def __init__(self) -> None:
        self.asked = 0

    def action(self, name: str) -> str | None:
        return self.actions().get(name)

    def substitution(self, name: str) -> str | None:
        return self.substitutions().get(name)

    def actions(self) -> Mapping[str, str]:
        self.asked += 1
        return {'gz_server': 'gz', 'raw-2': 'gz', 'later': 'unbuilt'}

    def substitutions(self) -> Mapping[str, str]:
        self.asked += 1
        return {'subs-file': 'gz', 'soon': 'unbuilt'}

    def is_installed(self, package: str) -> bool:
        return package != 'unbuilt'


class Host:
    """Remembers what it is asked for, and answers what it is told."""

    def __init__(self) -> None:
        self.requests: list[dict[str, Any]] = []
        self.places: list[tuple[int, int]] = []
        self.answer: str | None = None
        self.problem: Exception | None = None

    def ask(
        self, walk: Walk, request: Mapping[str, Any], origin: Span
    ) -> str | None:
        place = origin.position
        self.requests.append(json.loads(json.dumps(request)))
        self.places.append((place.line, place.column))
        walk.draft.process_name('one')
        if self.problem is not None:
            raise self.problem
        return self.answer


@pytest.fixture
def host(monkeypatch: pytest.MonkeyPatch) -> Host:
    played = Host()
    monkeypatch.setattr(exposed_actions, 'ask_worker', played.ask)
    return played


def request(
    launcher: Launcher, text: str, suffix: str = 'yaml', **arguments: str
) -> Request:
    made = launcher.request('', **arguments)
    path = str(launcher.write(f'main.{suffix}', text))
    return replace(made, name=path, path=path, exposed=Brought)


def done(
    launcher: Launcher, text: str, suffix: str = 'yaml', **arguments: str
) -> Evaluation:
    return evaluate(request(launcher, text, suffix, **arguments))


def entity(host: Host) -> dict[str, Any]:
    (asked,) = host.requests
    found: dict[str, Any] = asked['entity']
    return found


def test_action_reaches_the_host_as_it_is_written(
    launcher: Launcher, host: Host
) -> None:
    evaluation = done(
        launcher,
        """\
launch:
- gz_server:
    if: 'true'
    world: $(find-pkg-share alpha)/a\\b.sdf
    number: 1
    real: 1.5
    flag: yes
    date: 2020-01-01
    nothing: null
    list: [a, 2]
    param:
    - name: p
      value: 1
      param: [{name: q}]
    children:
    - node: {pkg: alpha, exec: talker, if: '1'}
    - group:
      - log: {message: hi}
""",
    )
    assert evaluation.diagnostics == ()
    (asked,) = host.requests
    path = str(launcher.folder / 'main.yaml')
    assert asked['do'] == 'action'
    assert asked['frontend'] == 'yaml'
    assert asked['position'] == asked['entity']['position'] == [path, 2, 3]
    assert host.places == [(2, 3)]
    sent = entity(host)
    assert sent['type'] == 'gz_server'
    param = sent['attributes'].pop('param')
    assert sent['attributes'] == {
        'world': '$(find-pkg-share alpha)/a\\b.sdf',
        'number': 1,
        'real': 1.5,
        'flag': True,
        'date': '2020-01-01',
        'nothing': None,
        'list': ['a', 2],
    }
    assert param[0]['type'] == 'param'
    assert param[0]['attributes'].pop('param')[0]['attributes'] == {
        'name': 'q'
    }
    assert param[0]['attributes'] == {'name': 'p', 'value': 1}
    node, group = sent['children']
    assert node['type'] == 'node'
    assert node['attributes'] == {
        'pkg': 'alpha',
        'exec': 'talker',
        'if': '1',
    }
    assert node['children'] is None
    assert node['position'] == [path, 16, 7]
    assert group['attributes'] == {}
    assert group['children'][0]['attributes'] == {'message': 'hi'}
    assert evaluation.packages.keys() == {'gz', 'alpha'}


def test_xml_reaches_the_host_as_texts_and_elements(
    launcher: Launcher, host: Host
) -> None:
    text = """\
<launch>
  <gz_server world="1" unless="false" names="a;b" names-sep=";">
    <param name="p" value="1.0"/>
    <node pkg="alpha" exec="talker"><remap from="a" to="b"/></node>
  </gz_server>
</launch>
"""
    assert done(launcher, text, 'xml').diagnostics == ()
    (asked,) = host.requests
    assert asked['frontend'] == 'xml'
    sent = entity(host)
    assert sent['attributes'] == {
        'world': '1',
        'names': 'a;b',
        'names-sep': ';',
    }
    param, node = sent['children']
    assert param['attributes'] == {'name': 'p', 'value': '1.0'}
    assert param['children'] == []
    assert node['children'][0]['attributes'] == {'from': 'a', 'to': 'b'}
    assert sent['position'][1:] == [2, 4]


def test_what_depends_on_the_place_is_made_there(
    launcher: Launcher, host: Host
) -> None:
    text = """\
launch:
- for_each:
    values: '{robot: "a(b"}'
    children:
    - gz_server:
        world: $(dirname)/$(var x)/$(for-var robot)
        list: ['$(if true $(for-var robot) $(filename))', '$(dirname']
"""
    assert done(launcher, text).diagnostics == ()
    folder = launcher.folder
    assert entity(host)['attributes'] == {
        'world': f'{folder}/$(var x)/a\\(b',
        'list': [f'$(if true a\\(b {folder}/main.yaml)', '$(dirname'],
    }


@pytest.mark.parametrize(
    ('written', 'children'),
    [
        ('gz_server: {}', None),
        ('gz_server:', None),
        ('gz_server: []', []),
        ('gz_server: {children: []}', []),
    ],
)
def test_what_has_no_children_says_so(
    launcher: Launcher, host: Host, written: str, children: object
) -> None:
    assert done(launcher, f'launch:\n- {written}\n').diagnostics == ()
    assert entity(host)['attributes'] == {}
    assert entity(host)['children'] == children


def test_condition_decides_before_the_host_is_asked(
    launcher: Launcher, host: Host
) -> None:
    text = 'launch: [{gz_server: {unless: $(var sim)}}]'
    assert done(launcher, text, sim='true').diagnostics == ()
    assert host.requests == []
    evaluation = done(launcher, text, sim='false')
    assert 'unless' not in entity(host)['attributes']
    assert [c.taken for c in evaluation.plan.conditions] == [True]


@pytest.mark.parametrize(
    ('marked', 'message'),
    [
        (
            '- gz_server: «x»',
            "'gz_server' has attributes or a list of actions, and no text",
        ),
        ('- gz_server: {a: «{b: c}»}', "'a' cannot be a mapping"),
        (
            '- gz_server: {children: [«node»]}',
            "what stands in 'gz_server' is a list of names with attributes",
        ),
        (
            "- gz_server: {if: 'true', unless: «'true'»}",
            "'if' and 'unless' exclude one another",
        ),
    ],
)
def test_mistakes_are_found_before(
    launcher: Launcher, host: Host, marked: str, message: str
) -> None:
    text = 'launch:\n' + marked.replace('«', '').replace('»', '')
    (error,) = done(launcher, text).errors
    assert error.message == message
    assert error.position is not None
    assert error.position.column == marked.index('«') + 1
    assert host.requests == []


def test_substitution_is_made_by_the_host(
    launcher: Launcher, host: Host
) -> None:
    host.answer = 'a b'
    text = """\
launch:
- executable:
    cmd: [echo, "x$(subs-file $(var name) 'b c')"]
"""
    evaluation = done(launcher, text, name='one')
    assert evaluation.diagnostics == ()
    (process,) = evaluation.plan.processes()
    assert process.argv == ('echo', 'xa b')
    (asked,) = host.requests
    assert asked['name'] == 'subs-file'
    assert asked['arguments'] == ['one', 'b c']
    assert asked['file'] == str(launcher.folder / 'main.yaml')
    assert host.places == [(3, 19)]
    assert 'gz' in evaluation.packages


def test_substitution_works_in_files_with_parameters(
    launcher: Launcher, host: Host
) -> None:
    host.answer = '5'
    path = launcher.write(
        'p.yaml', '/**: {ros__parameters: {x: $(subs-file)}}'
    )
    evaluation = done(
        launcher,
        'launch: [{node: {pkg: alpha, exec: talker, param: '
        f'[{{from: {path}, allow_substs: true}}]}}}}]',
    )
    assert evaluation.diagnostics == ()
    assert [r['name'] for r in host.requests] == ['subs-file']


@pytest.mark.parametrize(
    ('written', 'what'),
    [
        ('later: {}', "the action 'later'"),
        ('log: {message: $(soon)}', "the substitution 'soon'"),
    ],
)
def test_package_that_is_not_built_is_built_first(
    launcher: Launcher, host: Host, written: str, what: str
) -> None:
    evaluation = done(launcher, f'launch: [{written}]')
    (error,) = evaluation.errors
    assert what in error.message
    assert error.may_pass_after_build
    assert evaluation.packages.keys() == {'unbuilt'}
    assert host.requests == []


@pytest.mark.parametrize(
    ('written', 'message', 'hint'),
    [
        (
            'gz_serve: {}',
            "unknown action 'gz_serve'",
            "did you mean 'gz_server'?",
        ),
        (
            'log: {message: $(sub-file x)}',
            "unknown substitution 'sub-file'",
            "did you mean 'subs-file'?",
        ),
    ],
)
def test_name_that_nobody_has_is_unknown(
    launcher: Launcher, written: str, message: str, hint: str
) -> None:
    (error,) = done(launcher, f'launch: [{written}]').errors
    assert (error.message, error.hint) == (message, hint)


def test_what_an_action_that_fails_sets_is_not_missed(
    launcher: Launcher, host: Host
) -> None:
    text = 'launch: [{later: {}}, {log: {message: $(var x)}}]'
    (error,) = done(launcher, text).errors
    assert error.may_pass_after_build


def test_argument_that_only_such_an_action_reads_is_known(
    launcher: Launcher, host: Host
) -> None:
    text = 'launch: [{gz_server: {world: $(var world)}}]'
    assert done(launcher, text, world='a').diagnostics == ()
    (warning,) = done(launcher, text, wrld='a').diagnostics
    assert "'wrld'" in warning.message


def test_packages_are_not_looked_at_without_need(launcher: Launcher) -> None:
    brought = Brought()
    made = request(
        launcher,
        'launch: [{let: {name: a, value: $(env SET)}}, {log: '
        '{message: $(var a)}}]',
    )
    made = replace(made, exposed=lambda: brought)
    assert evaluate(made).diagnostics == ()
    assert brought.asked == 0


USES = """\
launch:
- arg: {name: world}
- arg: {name: file}
- gz_server: {world: $(var world)}
- let: {name: made, value: $(subs-file $(var file))}
- log: {message: $(var made)}
"""


def test_check_knows_them(launcher: Launcher) -> None:
    checked = check(request(launcher, USES), portable=True)
    assert [d.message for d in checked.errors] == []
    assert checked.packages.keys() == {'gz'}


def test_check_has_the_host_do_what_is_known(
    launcher: Launcher, host: Host
) -> None:
    host.answer = 'made'
    text = USES.replace('name: world', 'name: world, default: w')
    checked = check(request(launcher, text), portable=True)
    assert checked.diagnostics == ()
    # the argument 'file' is given by each launch
    assert [r['do'] for r in host.requests] == ['action']
    checked = check(request(launcher, USES, file='f'), portable=True)
    assert checked.diagnostics == ()
    assert host.requests[-1]['arguments'] == ['f']
    assert all(r['do'] == 'substitute' for r in host.requests[1:])


def test_check_does_nothing_that_no_launch_does(
    launcher: Launcher, host: Host
) -> None:
    text = "launch: [{gz_server: {if: 'false'}}, {gz_server: {if: '1'}}]"
    assert check(request(launcher, text), portable=False).errors == ()
    assert len(host.requests) == 1


@pytest.mark.parametrize(
    ('reason', 'wanted'),
    [
        (None, "of the package 'gz' is run by ROS 2's 'launch', which"),
        ('it does x', 'cannot be a part of the plan: it does x'),
    ],
)
@pytest.mark.parametrize(
    ('written', 'what'),
    [
        ('gz_server: {}', "the action 'gz_server' "),
        ('log: {message: $(subs-file a)}', "the substitution 'subs-file' "),
    ],
)
def test_what_the_host_cannot_do_is_an_error(
    launcher: Launcher,
    host: Host,
    reason: str | None,
    wanted: str,
    written: str,
    what: str,
) -> None:
    host.problem = NotTakenOverError(reason)
    text = f'launch: [{written}]'
    (error,) = done(launcher, text).errors
    assert what + wanted in error.message
    assert error.hint is not None
    (warning,) = check(request(launcher, text), portable=False).diagnostics
    assert warning.severity == 'warning'
    assert warning.message == f'this cannot be checked: {error.message}'


@pytest.mark.parametrize(
    ('condition', 'severity'),
    [('true', 'error'), ('$(var rare false)', 'warning')],
)
def test_what_fails_in_the_host_fails_a_check(
    launcher: Launcher, host: Host, condition: str, severity: str
) -> None:
    host.problem = error('it fails')
    text = f"launch: [{{gz_server: {{if: '{condition}'}}}}]"
    (problem,) = check(request(launcher, text), portable=False).diagnostics
    assert (problem.message, problem.severity) == ('it fails', severity)


def test_launch_arguments_are_listed_without_them(launcher: Launcher) -> None:
    found = find_declarations(request(launcher, USES))
    assert [a.name for a in found.arguments] == ['world', 'file']
    assert found.mistakes == ()
