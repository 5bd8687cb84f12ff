# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The JSON Schema accepts what the language accepts, as far as it can tell."""

import json
from pathlib import Path
from typing import Any

from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.launch_tree import read_launch_file
from colcon_yamllaunch.language.vocabulary.actions import (
    Action,
    ACTIONS,
    ALIASES,
    Type,
)
from colcon_yamllaunch.language.vocabulary.json_schema import (
    json_schema,
    schema_text,
)
from jsonschema import Draft7Validator
from launch_examples import EXAMPLES
import pytest
from support.language_fixtures import Launcher, source
import yaml

CONFORMANCE = Path(__file__).parents[2] / 'conformance'
VALIDATOR = Draft7Validator(json_schema({}))

#: The cases whose mistakes only a YAML parser finds.
NOT_YAML = {'bad_yaml'}
#: The cases whose mistakes show only when they are evaluated or run.
NOT_STRUCTURAL = {
    'args_choices_bad',
    'args_malformed',
    'args_missing_required',
    'bad_error_after_start',
    'bad_param_file_syntax',
    'env_missing',
    'executable_missing',
    'include_missing_file',
    'include_missing_required_arg',
    'node_missing_exec',
    'node_missing_pkg',
    'node_not_executable',
    'subst_command_fails',
    'subst_command_stderr_default',
    'subst_command_stderr_fail',
    'subst_eval_error',
    'subst_unknown',
    'subst_unterminated',
    'subst_var_missing',
}
#: Values for the types that do not take every text.
SAMPLES = {
    Type.ACTIONS: [],
    Type.BOOLEAN: True,
    Type.INTEGER: 1,
    Type.SECONDS: 1,
}
CASES = sorted(
    path.stem
    for path in (CONFORMANCE / 'expected').glob('*.json')
    if path.stem not in NOT_YAML
)


def schema_accepts(text: str) -> bool:
    return bool(VALIDATOR.is_valid(yaml.safe_load(text)))


def reader_accepts(text: str) -> bool:
    try:
        return not read_launch_file(source(text)).has_mistakes
    except LaunchError:
        return False


def required_attributes(action: Action) -> dict[str, Any]:
    """Return the attributes that an action needs, with some value."""
    return {
        attribute.name: SAMPLES.get(attribute.type, 'x')
        for attribute in action.attributes
        if attribute.required
    }


def test_it_is_a_schema() -> None:
    Draft7Validator.check_schema(json_schema({}))
    assert json.loads(schema_text({})) == json_schema({})
    assert schema_text({}).endswith('}\n')


@pytest.mark.parametrize('name', CASES)
def test_conformance_case(name: str) -> None:
    case = CONFORMANCE / 'cases' / f'{name}.yaml'
    expected = CONFORMANCE / 'expected' / f'{name}.json'
    outcome = json.loads(expected.read_text(encoding='utf-8'))
    runs = outcome['exit_ok'] or outcome['processes']
    wanted = bool(runs) or name in NOT_STRUCTURAL

    assert schema_accepts(case.read_text(encoding='utf-8')) == wanted


@pytest.mark.parametrize('name', EXAMPLES)
def test_example(name: str) -> None:
    assert schema_accepts('launch:\n' + EXAMPLES[name])


@pytest.mark.parametrize('name', [*ACTIONS, *ALIASES])
def test_the_attributes_of_an_action(name: str) -> None:
    needed = required_attributes(ACTIONS[ALIASES.get(name, name)])

    def accepts(attributes: object) -> bool:
        text = yaml.safe_dump({'launch': [{name: attributes}]})
        verdict = schema_accepts(text)
        assert verdict == reader_accepts(text), text
        return verdict

    assert accepts(needed)
    assert accepts({**needed, 'if': True})
    assert accepts({**needed, 'unless': '$(var x)'})
    assert not accepts({**needed, 'if': True, 'unless': True})
    assert not accepts({**needed, 'nmae': 'typo'})
    assert not accepts(None)
    assert not accepts('text')
    for missing in needed:
        assert not accepts({k: v for k, v in needed.items() if k != missing})
        assert not accepts({**needed, missing: None})
    assert accepts([]) == (name == 'group')


@pytest.mark.parametrize(
    'text',
    [
        'launch: []',
        'launch: {children: []}',
        'launch: {deprecated: old, children: [shutdown: {}]}',
        'launch: [node: {exec: 5}]',
        'launch: [node: {exec: x, namespace: /a/b/}]',
        "launch: [node: {exec: x, namespace: ''}]",
        'launch: [node: {exec: x, namespace: $(var ns)/a}]',
        'launch: [node: {exec: x, name: camera_$(var side)}]',
        'launch: [node: {exec: x, respawn: yes, respawn_delay: "$(var d)"}]',
        "launch: [node: {exec: x, respawn: 'off', respawn_delay: ' 1e-1 '}]",
        'launch: [node: {exec: x, respawn_max_retries: "-1"}]',
        'launch: [node: {exec: x, output: $(var where)}]',
        'launch: [node: {exec: x, args: 5, ros_args: [a, 5, true]}]',
        'launch: [node: {exec: x, param: [{name: a, value: [1.0, 2.5]}]}]',
        'launch: [node: {exec: x, param: [{name: a, value: [1, $(var x)]}]}]',
        'launch: [node: {exec: x, param: [{name: a, value: []}]}]',
        'launch: [node: {exec: x, param: [{from: f, allow_substs: true}]}]',
        'launch: [node: {exec: x, param: '
        '[{name: a, param: [{name: b, param: [{name: c, value: 1}]}]}]}]',
        "launch: [executable: {cmd: x, if: ' TRUE '}]",
        'launch: [log: {message: 5, level: Info}]',
        'launch: [log: {message: true, level: $(var level)}]',
        'launch: [group: [group: [group: []]]]',
        'launch: [timer: {period: "5", children: []}]',
        'launch: [for: {len: $(var n), name: i, children: []}]',
        'launch: [&a {shutdown: {}}, *a, {shutdown: {<<: {reason: x}}}]',
    ],
)
def test_accepted(text: str) -> None:
    assert reader_accepts(text)
    assert schema_accepts(text)


@pytest.mark.parametrize(
    'text',
    [
        '',
        'launch:',
        'launch: {}',
        'launch: 5',
        'launch: {deprecated: old}',
        'launch: {children: [], other: 1}',
        'launch: {children: {}}',
        '{launch: [], lunch: []}',
        'launch: [node]',
        'launch: [{}]',
        'launch: [[]]',
        'launch: [{shutdown: {}, reset: {}}]',
        'launch: [group: {children: }]',
        'launch: [group: [{shutdown: {}, reset: {}}]]',
        'launch: [timer: [shutdown: {}]]',
        'launch: [include: {file: x, arg: []}]',
        'launch: [include: {file: x, arg: {name: a, value: b}}]',
        'launch: [include: {file: x, arg: [a]}]',
        'launch: [include: {file: x, arg: [{name: a}]}]',
        'launch: [include: {file: [x]}]',
        'launch: [arg: {name: a, choice: [fast, careful]}]',
        'launch: [let: {name: yes, value: a}]',
        'launch: [node: {exec: x, on_exit: restart}]',
        'launch: [node: {exec: x, composable_node: []}]',
        'launch: [node: {exec: x, args: [a, [b]]}]',
        'launch: [node: {exec: x, param: [{name: a}]}]',
        'launch: [node: {exec: x, param: [{value: 1}]}]',
        'launch: [node: {exec: x, param: [{from: f, name: a}]}]',
        'launch: [node: {exec: x, param: [{name: a, value: {b: 1}}]}]',
        'launch: [node: {exec: x, param: [{name: a, value: [[1]]}]}]',
        'launch: [node: {exec: x, param: [{name: a, value: 1, type: long}]}]',
        'launch: [node: {exec: x, param: '
        '[{name: a, param: [{name: b, value: 1}], type: int}]}]',
        'launch: [node: {exec: x, param: '
        '[{name: a, value: 1, allow_substs: true}]}]',
        'launch: [composable_node: {pkg: a, plugin: b}]',
        'launch: [load_composable_node: {composable_node: []}]',
        'launch: [node_container: {exec: x, composable_node: [{pkg: a}]}]',
        'launch: [node_container: {exec: x, composable_node: '
        '[{pkg: a, plugin: b, autostart: true}]}]',
        'launch: [node_container: {exec: x, composable_node: '
        "[{pkg: a, plugin: b, if: '1', unless: '1'}]}]",
        'launch: [lifecycle_node: {exec: x}]',
    ],
)
def test_rejected(text: str) -> None:
    assert not reader_accepts(text)
    assert not schema_accepts(text)


@pytest.mark.parametrize(
    'attributes',
    [
        'if: maybe',
        "if: ''",
        'if: 2',
        'respawn: sometimes',
        'respawn: 2',
        'respawn_max_retries: many',
        'respawn_delay: soon',
        'respawn_delay: -1',
        'sigterm_timeout: 5 s',
        'output: nowhere',
        'name: bad-name',
        'name: 2nd',
        'namespace: bad name',
        'namespace: a//b',
        'param: [{name: a, value: [1, a]}]',
        'param: [{name: a, value: [true, 1]}]',
    ],
)
def test_a_value_that_evaluating_rejects(
    attributes: str, launcher: Launcher
) -> None:
    text = f'launch: [node: {{pkg: my_pkg, exec: my_node, {attributes}}}]'

    launcher.errors(text)
    assert not schema_accepts(text)


def test_an_editor_can_show_and_complete_what_there_is() -> None:
    schema: Any = json_schema({})
    definitions = schema['definitions']

    names = definitions['action']['properties']
    assert set(names) == {*ACTIONS, *ALIASES}
    assert names['node']['description'].startswith('Run a ROS node.')
    node = definitions['node']['properties']
    assert 'both' in node['output']['anyOf'][0]['enum']
    assert "Default: 'both'." in node['output']['description']
    assert 'since Jazzy' in node['respawn_max_retries']['description']


@pytest.mark.parametrize(
    ('written', 'is_valid'),
    [
        ('own: {a: 1, b: [{c: d}], if: true}', True),
        ('own: [node: {}]', True),
        ('own:', True),
        ('own: x', False),
        ("own: {if: 'true', unless: 'false'}", False),
        ('own: {if: maybe}', False),
        ('other: {}', False),
    ],
)
def test_schema_knows_actions_of_packages(
    written: str, is_valid: bool
) -> None:
    schema = json_schema({'own': 'my_pkg', 'node': 'launch_ros'})
    document = yaml.safe_load(f'launch: [{{{written}}}]')
    assert Draft7Validator(schema).is_valid(document) is is_valid
    definitions: Any = schema['definitions']
    shown = definitions['action']['properties']
    assert shown['own']['description'] == 'An action of the package my_pkg.'
    assert 'launch_ros' not in shown['node']['description']
