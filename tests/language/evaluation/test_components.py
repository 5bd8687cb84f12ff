# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What containers are loaded with."""

import json
from pathlib import Path
import re

from colcon_yamllaunch.language.policies.check import check
from colcon_yamllaunch.language.policies.evaluate import evaluate
from colcon_yamllaunch.plan.plan import Component, Process, Timer
import pytest
from support.language_fixtures import Launcher, Marked

PAGE = Path(__file__).parents[3] / 'docs' / 'components.md'
EXAMPLES = re.findall(
    r'^```(?:yaml|xml)\n(.*?)^```$',
    PAGE.read_text(encoding='utf-8'),
    re.MULTILINE | re.DOTALL,
)
BOX = '- node_container: {pkg: alpha, exec: talker, name: box}\n'
PARAMETERS = """\
/**:
  ros__parameters: {a: 1, deep: {er: {x: 2.5}}}
e1:
  ros__parameters: {b: without namespace}
/ns/e1:
  ros__parameters: {a: 7, list: [1, 2.5], text: "5", inf: .inf}
ns:
  e1:
    ros__parameters: {nested: true}
/*/e1:
  ros__parameters: {wild: 1, a: 3}
/ns/**:
  ros__parameters: {below: 1}
"""


def loaded(*lines: str, target: str = 'box') -> str:
    """Return an action that loads one component with these attributes."""
    return (
        f'- load_composable_node:\n    target: {target}\n'
        '    composable_node:\n    - pkg: my_pkg\n'
        '      plugin: my_pkg::Camera\n'
        + ''.join(f'      {line}\n' for line in lines)
    )


def components(launcher: Launcher, text: str) -> list[Component]:
    return list(launcher.good(f'launch:\n{text}').plan.components())


def component(launcher: Launcher, *lines: str, before: str = '') -> Component:
    (found,) = components(launcher, BOX + before + loaded(*lines))
    return found


def values(found: Component) -> dict[str, str]:
    """Return the parameters that count: the last of each name."""
    return {p.name: p.value for p in found.parameters}


def test_a_container_and_what_is_loaded_into_it(launcher):
    evaluation = launcher.good("""launch:
- group:
  - push_ros_namespace: {namespace: outer}
  - node_container:
      pkg: alpha
      exec: talker
      name: c
      namespace: inner
      args: --x
      respawn: true
      ros_args: --log-level debug
      composable_node:
      - {pkg: my_pkg, plugin: 'my_pkg::Camera', name: one, namespace: sub}
      - {pkg: my_pkg, plugin: 'my_pkg::Viewer', name: two, namespace: /abs}
  - node: {pkg: alpha, exec: listener}
""")
    container, one, two, node = evaluation.plan.entries
    assert isinstance(container, Process)
    assert isinstance(node, Process)
    assert (container.is_container, node.is_container) == (True, False)
    assert container.node_name == '/outer/inner/c'
    assert container.respawn
    assert container.argv[1:5] == (
        '--x',
        '--ros-args',
        '--log-level',
        'debug',
    )
    assert one == Component(
        label='one',
        package='my_pkg',
        plugin='my_pkg::Camera',
        container='/outer/inner/c',
        position=one.position,
        name='one',
        # not below that of the container, as in ROS 2
        namespace='/outer/sub',
        block=container.block,
    )
    assert (one.position.line, one.node_name) == (13, '/outer/sub/one')
    assert (two.container, two.node_name) == ('/outer/inner/c', '/abs/two')
    assert list(evaluation.packages) == ['alpha', 'my_pkg']
    uses = [
        (p.package, p.plugin, p.package_position.column, p.position.column)
        for p in evaluation.plugins
    ]
    assert uses == [
        ('my_pkg', 'my_pkg::Camera', 15, 31),
        ('my_pkg', 'my_pkg::Viewer', 15, 31),
    ]


def test_what_is_left_out(launcher):
    found = component(launcher)
    assert (found.label, found.name, found.namespace) == ('Camera', '', '')
    assert found.node_name is None
    assert found == component(launcher, "name: ''")


def test_names_of_components_of_one_name(launcher):
    text = BOX + loaded('name: a') + loaded('name: a', 'namespace: b')
    assert [c.label for c in components(launcher, text)] == ['a', 'b/a']
    labels = [c.label for c in components(launcher, BOX + loaded() + loaded())]
    assert len(set(labels)) == 2


@pytest.mark.parametrize('target', ['box', '/box', "$(env A 'box')"])
def test_targets(launcher, target):
    (found,) = components(launcher, BOX + loaded(target=target))
    assert found.container == '/box'


def test_a_target_has_no_namespace_of_its_own(launcher):
    inner = '- push_ros_namespace: {namespace: ns}\n'
    (found,) = components(launcher, BOX + inner + loaded('name: a'))
    assert (found.container, found.node_name) == ('/box', '/ns/a')


def test_conditions(launcher):
    text = BOX + ''.join(
        loaded(f'name: n{number}', condition)
        for number, condition in enumerate(
            ("if: 'true'", 'if: false', "unless: '1'", 'unless: $(not true)')
        )
    )
    evaluation = launcher.good(f'launch:\n{text}')
    names = [c.name for c in evaluation.plan.components()]
    assert names == ['n0', 'n3']
    assert [c.taken for c in evaluation.plan.conditions] == [
        True,
        False,
        False,
        True,
    ]


def test_the_order_is_that_of_the_file(launcher):
    text = """
- node_container:
    pkg: alpha
    exec: talker
    name: box
    composable_lifecycle_node:
    - {pkg: my_pkg, plugin: 'my_pkg::Camera', name: a, autostart: true}
    - {pkg: my_pkg, plugin: 'my_pkg::Camera', name: b}
    composable_node:
    - {pkg: my_pkg, plugin: 'my_pkg::Camera', name: c}
"""
    found = components(launcher, text)
    assert [(c.name, c.is_lifecycle, c.autostart) for c in found] == [
        ('a', True, True),
        ('b', True, False),
        ('c', False, False),
    ]


def test_remaps_of_the_scope_come_first(launcher):
    before = '- set_remap: {from: a, to: b}\n'
    found = component(launcher, 'remap: [{from: a, to: c}]', before=before)
    assert found.remaps == ('a:=b', 'a:=c')


def test_parameters_of_the_scope_come_first(launcher):
    before = "- set_parameter: {name: x, value: '1'}\n"
    found = component(launcher, 'param: [{name: x, value: 2}]', before=before)
    assert [(p.name, p.value) for p in found.parameters] == [
        ('x', '1'),
        ('x', '2'),
    ]
    assert [p.position.line for p in found.parameters] == [3, 9]


@pytest.mark.parametrize(
    ('value', 'expected'),
    [
        ('1', '1'),
        ('1.0', '1.0'),
        ('1.0e+20', '1.0e+20'),
        ('.inf', '.inf'),
        ('-.inf', '-.inf'),
        ('.nan', '.nan'),
        ('true', 'true'),
        ("'true'", '"true"'),
        ("''", '""'),
        ('é"\\n', '"é\\"n"'),
        ('[1, 2]', '[1, 2]'),
        ('[1.0, .inf]', '[1.0, .inf]'),
        ('[a, b]', '["a", "b"]'),
        ("$(env A '5')", '5'),
        ('"$(env A \'[true, false]\')"', '[true, false]'),
    ],
)
def test_values_are_json(launcher, value, expected):
    found = component(launcher, 'param:', f'- {{name: x, value: {value}}}')
    assert [p.value for p in found.parameters] == [expected]


def test_texts_are_json(launcher):
    found = component(
        launcher,
        'param:',
        '- {name: x, value: "a\\U0001F600\\U000E0001\\x85"}',
    )
    (parameter,) = found.parameters
    assert json.loads(parameter.value) == 'a\U0001f600\U000e0001\x85'


def test_nested_parameters_and_types(launcher):
    found = component(
        launcher,
        'param:',
        '- {name: a, param: [{name: b, param: [{name: c, value: 1}]}]}',
        "- {name: t, value: $(env A '5'), type: str}",
    )
    assert values(found) == {'a.b.c': '1', 't': '"5"'}


def test_extra_arguments_are_read_as_yaml(launcher):
    found = component(
        launcher,
        'extra_arg:',
        "- {name: a, value: 'true'}",
        '- {name: b, value: 5}',
        '- {name: c, value: "$(env A \'[1.5]\')"}',
        '- {name: d, value: text}',
    )
    assert [(p.name, p.value) for p in found.extra_arguments] == [
        ('a', 'true'),
        ('b', '5'),
        ('c', '[1.5]'),
        ('d', '"text"'),
    ]


def test_sections_of_a_file(launcher):
    launcher.write('p.yaml', PARAMETERS)
    common = {'a': '1', 'deep.er.x': '2.5'}
    lines = ['param: [{from: p.yaml}]', 'name: e1']
    evaluation = launcher.evaluate(
        f'launch:\n{BOX}{loaded(*lines, "namespace: ns")}'
    )
    (found,) = evaluation.plan.components()
    assert values(found) == {
        **common,
        'wild': '1',
        'below': '1',
        # what is for one node alone counts most, wherever it stands
        'a': '7',
        'list': '[1.0, 2.5]',
        'text': '"5"',
        'inf': '.inf',
        'nested': 'true',
    }
    places = {p.name: p.position for p in found.parameters}
    assert places['a'].path == str(launcher.folder / 'p.yaml')
    assert places['a'].line == 6
    # what is for '/e1' is not missed by a node with a section of its own
    assert evaluation.diagnostics == ()

    found = next(
        launcher.evaluate(f'launch:\n{BOX}{loaded(*lines)}').plan.components()
    )
    assert values(found) == {**common, 'b': '"without namespace"'}
    found = next(
        launcher.evaluate(
            f'launch:\n{BOX}{loaded(*lines, "namespace: other/ns")}'
        ).plan.components()
    )
    assert values(found) == common
    found = component(launcher, 'param: [{from: p.yaml}]')
    assert values(found) == common


def test_files_of_the_scope(launcher):
    launcher.write('p.yaml', PARAMETERS)
    before = '- set_parameters_from_file: {filename: p.yaml}\n'
    found = component(
        launcher, 'name: e1', 'param: [{name: a, value: 9}]', before=before
    )
    assert values(found) == {
        'a': '9',
        'deep.er.x': '2.5',
        'b': '"without namespace"',
    }


def test_an_empty_list_in_a_file(launcher):
    launcher.write('p.yaml', '/**:\n  ros__parameters:\n    a: []\n    b: 1\n')
    text = BOX + loaded('param: [{from: p.yaml}]')
    result = launcher.evaluate(f'launch:\n{text}')
    (warning,) = result.diagnostics
    assert warning.severity == 'warning'
    assert warning.message.startswith("the parameter 'a' is left out: ")
    assert warning.position.line == 3
    (found,) = result.plan.components()
    assert values(found) == {'b': '1'}


def test_substitutions_in_a_file(launcher):
    launcher.write('p.yaml', '/**: {ros__parameters: {a: $(env SET)}}\n')
    found = component(launcher, 'param: [{from: p.yaml, allow_substs: true}]')
    assert values(found) == {'a': '"value"'}
    found = component(launcher, 'param: [{from: p.yaml}]')
    assert values(found) == {'a': '"$(env SET)"'}


@pytest.mark.parametrize(
    ('content', 'message', 'line'),
    [
        (None, "'p.yaml' does not exist", 8),
        ('/**: {ros__parameters: {a: null}}', "'a' is nothing", 1),
        ('/**: {ros__parameters: {a: 2020-01-01}}', "'a' is nothing", 1),
        ('/**: {ros__parameters: {a: [1, x]}}', 'of several types', 1),
        ('a: [', None, 1),
        ('[a]', 'is a mapping of nodes to parameters', 1),
    ],
)
def test_files_that_cannot_be_sent(launcher, content, message, line):
    if content is not None:
        launcher.write('p.yaml', content)
    text = f'launch:\n{BOX}{loaded("param: [{from: p.yaml}]")}'
    (error,) = launcher.errors(text)
    assert (message or '') in error.message
    assert error.position.line == line
    if content is not None:
        assert [i.line for i in error.includes] == [8]


def test_a_key_that_stands_twice_in_a_file(launcher):
    launcher.write('p.yaml', '/**: {ros__parameters: {a: 1, a: 2}}\n')
    text = f'launch:\n{BOX}{loaded("param: [{from: p.yaml}]")}'
    evaluation = launcher.evaluate(text)
    (found,) = evaluation.plan.components()
    assert values(found) == {'a': '2'}
    (warning,) = evaluation.diagnostics
    assert (warning.severity, 'stands twice' in warning.message) == (
        'warning',
        True,
    )


@pytest.mark.parametrize(
    ('marked', 'message', 'hint'),
    [
        (
            BOX + loaded('name: «a-b»'),
            'may only have letters',
            None,
        ),
        (
            BOX + loaded(target='«a b»'),
            "'a b' is not the full name of a node",
            '/namespace/name',
        ),
        (
            BOX + '- «load_composable_node»: {target: box}\n',
            'has nothing to load',
            "'composable_node'",
        ),
        (
            '- «node_container»:\n    pkg: alpha\n    exec: talker\n'
            '    composable_node:\n'
            "    - {pkg: my_pkg, plugin: 'my_pkg::Camera'}\n",
            "needs a 'name'",
            None,
        ),
        (
            BOX + loaded("if: 'true'", "unless: «'true'»"),
            'exclude one another',
            None,
        ),
        (
            BOX + loaded('extra_arg: [{name: a, value: «null»}]'),
            'null',
            None,
        ),
    ],
)
def test_mistakes(launcher, marked, message, hint):
    mark = Marked.of(f'launch:\n{marked}')
    (error,) = launcher.errors(mark.text)
    assert (error.position.line, error.position.column) == (
        mark.line,
        mark.column,
    )
    assert message in error.message
    assert hint is None or hint in error.hint


def test_one_mistake_leaves_the_others_standing(launcher):
    text = BOX + loaded('name: a-b') + loaded('name: b')
    evaluation = launcher.evaluate(f'launch:\n{text}')
    assert len(evaluation.errors) == 1
    assert [c.name for c in evaluation.plan.components()] == ['b']


@pytest.mark.parametrize(
    ('before', 'target', 'hint'),
    [
        (BOX, 'boxx', "did you mean '/box'?"),
        (BOX, 'ns/box', "did you mean '/box'?"),
        ('', 'box', 'once it runs elsewhere'),
    ],
)
def test_a_container_that_nothing_is(launcher, before, target, hint):
    text = f'launch:\n{before}{loaded(target=f"«{target}»")}'
    warning = launcher.warning(text)
    assert f"nothing in this launch is the container '/{target}" in (
        warning.message
    )
    assert hint in warning.hint


def test_a_container_that_comes_later_or_is_a_node(launcher):
    assert components(launcher, loaded() + BOX)
    node = '- node: {pkg: alpha, exec: talker, name: box}\n'
    assert components(launcher, node + loaded())


def test_two_of_one_name(launcher):
    text = BOX + loaded('name: a') + loaded('name: «a»')
    assert "the name '/a' too" in launcher.warning(f'launch:\n{text}').message
    text = BOX + loaded('name: «box»')
    warning = launcher.warning(f'launch:\n{text}')
    assert "the name '/box' too" in warning.message


@pytest.mark.parametrize(
    ('sections', 'message', 'hint'),
    [
        (['/x'], "no section of 'p.yaml' is for the node '/ns/e1'", '/x'),
        (['/ns/e2'], 'no section', "did you mean '/ns/e2'?"),
        (['/e1'], "section '/e1' of 'p.yaml' is not for", "'/**/e1'"),
        (['/e1', '/**'], "section '/e1' of 'p.yaml' is not for", "'/ns/e1'"),
        # it may be for a node of somebody else's
        (['/**', '/x'], None, None),
        (['/ns/*'], None, None),
        (['/**/e1'], None, None),
    ],
)
def test_sections_that_say_nothing(launcher, sections, message, hint):
    launcher.write(
        'p.yaml',
        ''.join(f'{s}: {{ros__parameters: {{a: 1}}}}\n' for s in sections),
    )
    lines = ['name: e1', 'namespace: ns', 'param: [{from: p.yaml}]']
    evaluation = launcher.evaluate(f'launch:\n{BOX}{loaded(*lines)}')
    assert evaluation.errors == ()
    if message is None:
        assert evaluation.diagnostics == ()
        return
    (warning,) = evaluation.diagnostics
    assert message in warning.message
    assert hint in warning.hint
    assert warning.position.line == 10


def test_parameter_file_without_a_section_for_a_node_is_reported(launcher):
    launcher.write('p.yaml', '/x: {ros__parameters: {a: 1}}\n')
    node = '- node: {pkg: alpha, exec: talker, name: n, param: [%s]}\n'
    evaluation = launcher.evaluate('launch:\n' + node % '{from: p.yaml}')
    (warning,) = evaluation.diagnostics
    assert warning.message == "no section of 'p.yaml' is for the node '/n'"
    # its plan does not depend on the file
    assert not any(path.endswith('p.yaml') for path in evaluation.inputs)


def test_a_file_that_several_share(launcher):
    launcher.write(
        'p.yaml',
        ''.join(f'{n}: {{ros__parameters: {{a: 1}}}}\n' for n in ('a', 'b')),
    )
    text = ''.join(
        loaded(f'name: {name}', 'param: [{from: p.yaml}]')
        for name in ('a', 'b', 'without')
    )
    assert len(components(launcher, BOX + text)) == 3


def test_lifecycle_nodes(launcher):
    lines = '\n'.join(
        f'- lifecycle_node: {{pkg: alpha, exec: talker, name: n{number}'
        f'{text}}}'
        for number, text in enumerate(
            ('', ', autostart: true', ", autostart: $(env A 'false')")
        )
    )
    found = launcher.processes(f'launch:\n{lines}\n')
    assert [(p.is_lifecycle, p.autostart) for p in found] == [
        (True, False),
        (True, True),
        (True, False),
    ]


@pytest.mark.parametrize(
    ('before', 'is_simulated'),
    [
        ('', False),
        ('- set_use_sim_time: {value: true}\n', True),
        ("- set_use_sim_time: {value: $(env A 'true')}\n", True),
        ('- group: [set_use_sim_time: {value: true}]\n', False),
        # what nodes are told does not count in ROS 2's launcher either
        ("- set_parameter: {name: use_sim_time, value: 'true'}\n", False),
        (
            '- set_use_sim_time: {value: true}\n'
            '- set_use_sim_time: {value: false}\n',
            False,
        ),
    ],
)
def test_timers_of_ros_time(launcher, before, is_simulated):
    timers = '- {0}: {{period: 1.5, children: [log: {{message: a}}]}}\n'
    text = before + timers.format('ros_timer') + timers.format('timer')
    ros, plain = launcher.good(f'launch:\n{text}').plan.entries
    assert isinstance(ros, Timer)
    assert isinstance(plain, Timer)
    assert (ros.period, ros.on_ros_time) == (1.5, is_simulated)
    assert not plain.on_ros_time


def test_components_behind_a_timer(launcher):
    text = (
        BOX
        + '- timer:\n    period: 1\n    children:\n'
        + ''.join(f'    {line}\n' for line in loaded('name: a').splitlines())
    )
    _, timer = launcher.good(f'launch:\n{text}').plan.entries
    (found,) = timer.entries
    assert isinstance(found, Component)


def example(launcher, number):
    """Return what evaluates an example of the page."""
    text = EXAMPLES[number]
    name = 'example.xml' if text.startswith('<') else 'example.yaml'
    launcher.write(name, text)
    launcher.packages.programs = {
        'my_pkg': {'driver', 'planner'},
        'rclcpp_components': {'component_container', 'component_container_mt'},
    }
    return launcher.request(f'launch: [include: {{file: {name}}}]\n')


@pytest.mark.parametrize('number', range(len(EXAMPLES)))
def test_the_examples_of_the_page(launcher, number):
    request = example(launcher, number)
    evaluation = evaluate(request)
    # a fake package has no files
    assert all(e.may_pass_after_build for e in evaluation.errors)
    assert len(evaluation.diagnostics) == len(evaluation.errors)
    assert evaluation.plan.entries
    assert check(request, portable=True).errors == ()


def test_that_the_page_says_the_same_in_yaml_and_xml(launcher):
    assert len(EXAMPLES) == 6
    yaml, xml = (
        [
            (c.node_name, c.remaps, values(c))
            for c in evaluate(example(launcher, number)).plan.components()
        ]
        for number in (0, 1)
    )
    assert len(yaml) == 2
    assert yaml == xml


def test_an_error_of_a_container_is_all_that_is_said(launcher):
    box = BOX.replace('talker', 'tolker')
    (problem,) = launcher.evaluate(f'launch:\n{box}{loaded()}').diagnostics
    assert "'tolker'" in problem.message


def test_autostart_of_what_has_no_states(launcher):
    text = BOX + loaded('autostart: true')
    (problem,) = launcher.errors(f'launch:\n{text}')
    assert "'composable_lifecycle_node'" in problem.hint
