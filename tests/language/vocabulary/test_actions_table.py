# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The tables of actions and substitutions say what the language does."""

from collections.abc import Iterator
import re

from colcon_yamllaunch.language.actions.node_names import (
    join_namespace,
    namespace_problem,
    node_name_problem,
)
from colcon_yamllaunch.language.syntax.launch_tree import read_launch_file
from colcon_yamllaunch.language.vocabulary.actions import (
    Action,
    ACTIONS,
    Attribute,
    items_of,
    PARAMETER,
    RELEASES,
    Type,
)
from colcon_yamllaunch.language.vocabulary.substitutions import KINDS
from hypothesis import given
from hypothesis import strategies as st
from launch_examples import EXAMPLES
import pytest
from support.language_fixtures import Launcher, source

DEFAULTS = [
    pytest.param(action, attribute, id=f'{action.name}-{attribute.name}')
    for action in ACTIONS.values()
    for attribute in action.attributes
    if attribute.default is not None
]
# the shortest use of each action that has a default
MINIMAL = {
    'append_env': (
        '- append_env: {name: SET, value: more}\n- executable: {cmd: echo}\n'
    ),
    'executable': '- executable: {cmd: echo}\n',
    'group': (
        '- let: {name: x, value: before}\n'
        '- group:\n'
        '    children:\n'
        '    - log: {message: $(var x)}\n'
        '    - let: {name: x, value: within}\n'
        '- log: {message: $(var x)}\n'
    ),
    'log': '- log: {message: hello}\n',
    'node': '- node: {pkg: my_pkg, exec: my_node}\n',
    'node_container': '- node_container: {pkg: my_pkg, exec: my_node}\n',
    'lifecycle_node': (
        '- lifecycle_node: {pkg: my_pkg, exec: my_node, name: n}\n'
    ),
    'ros_timer': '- ros_timer: {period: 1, children: [shutdown: {}]}\n',
    'timer': '- timer: {period: 1, children: [shutdown: {}]}\n',
}


def all_attributes(action: Action) -> Iterator[Attribute]:
    """Iterate over an action's attributes and those of their items."""
    for attribute in action.attributes:
        yield attribute
        yield from items_of(attribute)


def with_attribute(text: str, action: str, line: str) -> str:
    """Put an attribute into the only such action of a text."""
    flow, block = f'- {action}: {{', f'- {action}:\n'
    if flow in text:
        return text.replace(flow, f'{flow}{line}, ')
    return text.replace(block, f'{block}    {line}\n')


@pytest.mark.parametrize('action', ACTIONS.values(), ids=list(ACTIONS))
def test_every_entry_is_complete(action: Action) -> None:
    assert action.since in RELEASES
    assert action.help.endswith('.')
    for attribute in all_attributes(action):
        assert attribute.help.endswith('.'), attribute
        assert not (attribute.required and attribute.default is not None)
        if attribute.since is not None:
            newer = RELEASES[RELEASES.index(action.since) + 1 :]
            assert attribute.since in newer, attribute
        has_items = bool(items_of(attribute))
        assert has_items == (attribute.type is Type.ITEMS), attribute


def test_substitutions_are_complete() -> None:
    for kind in KINDS.values():
        assert kind.since in RELEASES, kind
        assert kind.help.endswith('.'), kind
        assert f'$({kind.name}' in kind.example


@pytest.mark.parametrize(('action', 'attribute'), DEFAULTS)
def test_a_default_is_what_the_action_does_without_it(
    action: Action, attribute: Attribute, launcher: Launcher
) -> None:
    text = MINIMAL[action.name]
    default = attribute.default
    line = f"{attribute.name}: '{default}'"
    without = launcher.good(f'launch:\n{text}').plan
    given = with_attribute(f'launch:\n{text}', action.name, line)
    assert line in given
    written = launcher.good(given).plan

    assert without.entries

    def bare(plan: object) -> str:
        # the attribute moves what stands behind it
        return re.sub(r'(line|column)=\d+', '', repr(plan))

    assert bare(written) == bare(without)


def test_values_of_an_attribute_are_accepted(launcher: Launcher) -> None:
    for action in ACTIONS.values():
        for attribute in action.attributes:
            for value in attribute.values:
                text = with_attribute(
                    f'launch:\n{MINIMAL[action.name]}',
                    action.name,
                    f'{attribute.name}: {value}',
                )
                launcher.good(text)


def test_every_action_has_an_example_and_no_other_has() -> None:
    assert list(EXAMPLES) == list(ACTIONS)


@pytest.mark.parametrize('name', EXAMPLES)
def test_the_example_of_an_action_can_be_launched(
    name: str, launcher: Launcher
) -> None:
    text = 'launch:\n' + EXAMPLES[name]
    file = read_launch_file(source(text))
    assert name in {entity.action.name for entity in file.walk()}

    launcher.packages.programs = {
        'my_pkg': {'camera', 'driver', 'my_node', 'planner'}
        | {'simulator', 'spawn'},
        'rclcpp_components': {'component_container'},
    }
    errors = launcher.evaluate(text).errors

    # a fake package has no files, and there may be no ros2 on the PATH
    assert all(error.may_pass_after_build for error in errors) or (
        name == 'include' and 'camera.yaml' in errors[0].message
    ), errors


@pytest.mark.parametrize('name', KINDS)
def test_the_example_of_a_substitution_can_be_made(
    name: str, launcher: Launcher
) -> None:
    launcher.write('arm.urdf', '<robot/>')
    launcher.write('version', ' 1.0\n')
    text = f'- log: {{message: {KINDS[name].example}}}'
    loop = f'- for: {{len: 1, name: i, children: [{text[2:]}]}}'

    evaluation = launcher.good(f'launch:\n{loop}\n')

    (message,) = evaluation.plan.entries
    assert '$(' not in str(message)


@given(st.text('aZ_09-/~{}. ', max_size=8))
def test_patterns_of_names_are_the_rules_of_names(text: str) -> None:
    node = ACTIONS['node']
    name, namespace = node.attribute('name'), node.attribute('namespace')
    assert name is not None and namespace is not None
    assert name.pattern is not None and namespace.pattern is not None

    is_name = re.fullmatch(name.pattern, text) is not None
    assert is_name == (node_name_problem(text) is None)
    is_namespace = re.fullmatch(namespace.pattern, text) is not None
    problem = namespace_problem(join_namespace(None, text))
    assert is_namespace == (problem is None)


def test_a_nested_parameter_has_the_attributes_of_a_parameter() -> None:
    nested = next(a for a in PARAMETER if a.name == 'param')
    assert items_of(nested) == PARAMETER
