# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Whatever is in a launch file, a check ends with diagnostics and no traceback.

`HYPOTHESIS_PROFILE=long` tries many more examples.
"""

import json
from pathlib import Path

from colcon_yamllaunch.language.evaluation.findings import Checked
from colcon_yamllaunch.language.reports import as_github
from colcon_yamllaunch.language.reports import as_json
from colcon_yamllaunch.language.reports import as_sarif
from colcon_yamllaunch.language.reports import as_text
from colcon_yamllaunch.language.vocabulary.substitutions import Kind
from colcon_yamllaunch.language.vocabulary.substitutions import KINDS
from hypothesis import given
from hypothesis import strategies as st
from support.language_fixtures import Launcher
import yaml

from tests.language.policies.test_check import checked
from tests.language.policies.test_language_fuzz import FRAGMENTS
from tests.language.policies.test_language_fuzz import YAMLISH

CASES = [
    path.read_bytes()
    for path in sorted(
        (Path(__file__).parents[2] / 'conformance' / 'cases').glob('*.yaml')
    )
]


def _substitution(kind: Kind, words: list[str]) -> str:
    maximum = 4 if kind.maximum is None else kind.maximum
    return f'$({" ".join([kind.name, *words[:maximum]])})'


ARGUMENTS = st.recursive(
    st.sampled_from(['a', 'b', "''", 'true', '0', '-1', "'1 / 0'", 'alpha']),
    lambda inner: st.sampled_from(list(KINDS.values())).flatmap(
        lambda kind: st.builds(
            _substitution,
            st.just(kind),
            st.lists(inner, min_size=kind.minimum, max_size=4),
        )
    ),
    max_leaves=8,
)
ACTIONS = st.recursive(
    st.one_of(
        st.builds(
            lambda action, name, value: {action: {name[0]: name[1], **value}},
            st.sampled_from(['let', 'set_env', 'append_env', 'set_parameter']),
            st.tuples(st.just('name'), st.sampled_from(['a', 'b', 'PATH'])),
            st.fixed_dictionaries({'value': ARGUMENTS}),
        ),
        st.builds(
            lambda name, default: {'arg': {'name': name, **default}},
            st.sampled_from(['a', 'b']),
            st.fixed_dictionaries({}, optional={'default': ARGUMENTS}),
        ),
        st.builds(
            lambda values: {
                'node': {'pkg': 'alpha', 'exec': 'talker', **values}
            },
            st.fixed_dictionaries(
                {},
                optional={
                    'name': ARGUMENTS,
                    'namespace': ARGUMENTS,
                    'args': ARGUMENTS,
                    'if': ARGUMENTS,
                    'output': ARGUMENTS,
                    'respawn': ARGUMENTS,
                },
            ),
        ),
        st.builds(
            lambda file, name, value: {
                'include': {
                    'file': file,
                    'arg': [{'name': name, 'value': value}],
                    'unless': value,
                }
            },
            st.one_of(st.just('$(dirname)/main.yaml'), ARGUMENTS),
            st.sampled_from(['a', 'b']),
            ARGUMENTS,
        ),
        st.just({'reset': {}}),
        st.just({'reset_env': {}}),
        st.builds(
            lambda name: {'push_ros_namespace': {'namespace': name}}, ARGUMENTS
        ),
    ),
    lambda inner: st.builds(
        lambda kind, values, children: {
            kind[0]: {**kind[1], **values, 'children': children}
        },
        st.sampled_from(
            [
                ('group', {}),
                ('group', {'scoped': '$(var a x)'}),
                ('group', {'forwarding': 'false'}),
                ('timer', {'period': '1'}),
                ('for', {'len': '$(var a 3)', 'name': 'i'}),
                ('for_each', {'values': '$(var b {})'}),
            ]
        ),
        st.fixed_dictionaries({}, optional={'if': ARGUMENTS}),
        st.lists(inner, max_size=3),
    ),
    max_leaves=8,
)


def look(launcher: Launcher, text: str | bytes) -> Checked:
    """Check a text, and look at all that a user would see."""
    launcher.write('other.yaml', 'launch: [log: {message: other}]')
    result = checked(launcher, text, portable=True)
    cwd = str(launcher.folder)
    as_github(result, cwd)
    as_text(result, cwd)
    shown = json.loads(as_json(result, cwd))['diagnostics']
    (run,) = json.loads(as_sarif(result, cwd))['runs']
    assert len(shown) == len(run['results']) == len(result.diagnostics)
    return result


@given(data=st.binary())
def test_bytes(shared_launcher, data):
    look(shared_launcher, data)


@given(text=YAMLISH)
def test_lines_like_those_of_a_launch_file(shared_launcher, text):
    look(shared_launcher, text)


@given(actions=st.lists(ACTIONS, max_size=6))
def test_launch_files(shared_launcher, actions):
    look(shared_launcher, yaml.safe_dump({'launch': actions}))


@given(
    case=st.sampled_from(CASES),
    place=st.integers(0, 400),
    count=st.integers(0, 5),
    new=st.sampled_from(FRAGMENTS),
)
def test_a_launch_file_with_one_slip(shared_launcher, case, place, count, new):
    changed = case[:place] + new.encode() + case[place + count :]
    look(shared_launcher, changed)
