# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Mistakes in what a launch file says, each where it is and with a way out."""

from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.launch_tree import read_launch_file
from colcon_yamllaunch.language.syntax.source_text import Source
import pytest
from support.language_fixtures import Marked, source


def read(text):
    return read_launch_file(source(text))


def problems(text):
    try:
        file = read(text)
    except LaunchError as e:
        return e.diagnostics
    assert file.has_mistakes
    return file.problems


@pytest.mark.parametrize(
    ('text', 'names'),
    [
        ('launch: []', []),
        ('launch: {children: []}', []),
        ('launch:\n- shutdown: {}\n', ['shutdown']),
        ('launch:\n  children:\n  - reset: {}\n', ['reset']),
        (
            'launch:\n- group: [shutdown: {}, reset_env: {}]\n- reset: {}\n',
            ['group', 'shutdown', 'reset_env', 'reset'],
        ),
        (
            'launch:\n- timer: {period: 1, children: [reset: {}]}\n',
            ['timer', 'reset'],
        ),
        (
            'launch:\n- push-ros-namespace: {namespace: a}\n',
            ['push_ros_namespace'],
        ),
        (
            'launch:\n- &x {reset: {}}\n- *x\n',
            ['reset', 'reset'],
        ),
        (
            'launch:\n- log: &l {message: a}\n- log: {<<: *l, level: ERROR}\n',
            ['log', 'log'],
        ),
    ],
)
def test_actions(text, names):
    assert [entity.action.name for entity in read(text).walk()] == names


def test_deprecation():
    text = 'launch:\n  deprecated: use the other\n  children: []\n'
    assert read(text).deprecated == 'use the other'


@pytest.mark.parametrize(
    ('marked', 'message', 'hint'),
    [
        # the root
        ('«', 'the launch file is empty', "starts with 'launch:'"),
        ('«# nothing\n', 'the launch file is empty', "starts with 'launch:'"),
        ('«{}', 'the launch file is empty', "starts with 'launch:'"),
        (
            '«- node: {pkg: a, exec: b}\n',
            "there is no 'launch:' around",
            "starts with 'launch:'",
        ),
        ('«just a text', "there is no 'launch:'", "starts with 'launch:'"),
        ('«lanch»: []', "'lanch' stands where", "did you mean 'launch'?"),
        (
            'launch: []\n«name»: demo\n',
            "'name' stands where only 'launch' is known",
            "starts with 'launch:'",
        ),
        ('«launch:\n', "'launch:' wants a list of actions", "'[]'"),
        ('launch: «5\n', "'launch:' wants a list", 'put "- "'),
        ('launch: «{}\n', 'has no list of actions', '- node:'),
        (
            'launch:\n  «node»: {pkg: a, exec: b}\n',
            "'launch' has no attribute 'node'",
            'put "- " before it',
        ),
        (
            'launch: {«childen»: []}\n',
            "no attribute 'childen'",
            "did you mean 'children'?",
        ),
        (
            '«launch:\n  children:\n  deprecated: old\n',
            "'launch:' wants a list",
            "write '[]'",
        ),
        # actions
        ('launch: [«node]\n', 'a name with attributes', 'for example'),
        ('launch: [«[]]\n', 'a name with attributes', 'for example'),
        ('launch: [«{}]\n', 'a name with attributes', 'for example'),
        (
            'launch: [«~]\n',
            'a name with attributes',
            'for',
        ),
        (
            'launch: [«nod»: {pkg: a, exec: b}]\n',
            "unknown action 'nod'",
            "did you mean 'node'?",
        ),
        (
            'launch: [«push-ros-namespce»: {namespace: a}]\n',
            'unknown action',
            "did you mean 'push_ros_namespace'?",
        ),
        (
            'launch: [«gz_server»: {}]\n',
            "unknown action 'gz_server'",
            'the nearest are log_error, set_parameter, set_remap, set_env, '
            'log_debug',
        ),
        (
            'launch: [«composable_node»: {}]\n',
            'is no action of its own',
            "it stands in 'node_container'",
        ),
        (
            'launch:\n- node:\n  «pkg»: a\n  exec: b\n',
            "'pkg' stands beside 'node' in one list item",
            "indent it deeper than 'node'",
        ),
        (
            'launch:\n- node: {pkg: a, exec: b}\n  «log»: {message: c}\n',
            "'log' stands beside 'node'",
            'put "- " before it',
        ),
        (
            'launch:\n- «node»:\n',
            "'node' wants its attributes",
            'indent them deeper',
        ),
        ('launch: [«node»: a]\n', "'node' wants its attributes", 'indent'),
        ('launch: [«node»: [a]]\n', "'node' wants its attributes", 'indent'),
        # attributes
        (
            'launch: [«node»: {pkg: a}]\n',
            "'node' needs the attribute 'exec'",
            None,
        ),
        (
            'launch: [executable: {«cdm»: a}]\n',
            "'executable' has no attribute 'cdm'",
            "did you mean 'cmd'?",
        ),
        (
            'launch: [node: {pkg: a, exec: b, «ns»: c}]\n',
            "'node' has no attribute 'ns'",
            "did you mean 'namespace'?",
        ),
        (
            'launch: [node: {pkg: a, «type»: b}]\n',
            "'node' has no attribute 'type'",
            "did you mean 'exec'?",
        ),
        (
            'launch: [arg: {name: a, choice: [«b]}]\n',
            "an item of 'choice' is a mapping",
            'write {value: b}',
        ),
        (
            'launch: [«node»: "pkg:\u00a0a"]\n',
            "'node' wants its attributes",
            'a no-break space stands in them',
        ),
        (
            '«/**»: {ros__parameters: {a: 1}}\n',
            "'/**' stands where only 'launch' is known",
            'this is a parameter file',
        ),
        (
            'launch: [«timer»: [reset: {}]]\n',
            "'timer' needs the attribute 'period'",
            None,
        ),
        (
            'launch: [«group»: {scoped: false}]\n',
            "'group' needs the attribute 'children'",
            None,
        ),
        (
            'launch: [node: {pkg: a, exec: b, «nmae»: c}]\n',
            "'node' has no attribute 'nmae'",
            "did you mean 'name'?",
        ),
        (
            'launch: [node: {pkg: a, exec: b, «launch_prefix»: c}]\n',
            "no attribute 'launch_prefix'",
            "did you mean 'launch-prefix'?",
        ),
        (
            'launch: [executable: {cmd: a, «zzz»: c}]\n',
            "'executable' has no attribute 'zzz'",
            'the attributes are cmd, cwd',
        ),
        (
            'launch: [node: {pkg: a, exec: b, args: c, «e f»}]\n',
            "no attribute 'e f'",
            "quote a value that has a ',' in it",
        ),
        (
            'launch: [shutdown: {reason: «[a]}]\n',
            "'reason' is a text",
            'quote a text',
        ),
        (
            'launch: [shutdown: {reason: «~}]\n',
            "'reason' has no value",
            "write '' for an empty text",
        ),
        (
            'launch: [node: {pkg: a, exec: b, name: «on»}]\n',
            'YAML reads on as a boolean',
            "quote it: 'on'",
        ),
        (
            'launch: [executable: {cmd: a, on_exit: «shutdwn»}]\n',
            "'on_exit' cannot be 'shutdwn'",
            "did you mean 'shutdown'?",
        ),
        (
            'launch: [log: {message: a, if: b, unless: «c}]\n',
            "'if' and 'unless' exclude one another",
            'join them',
        ),
        (
            'launch: [executable: {cmd: a, env: «{name: b, value: c}}]\n',
            "'env' is a list",
            'put "- "',
        ),
        ('launch: [reset: {keep: «[]}]\n', "'keep' is a list", 'put "- "'),
        (
            'launch: [executable: {cmd: a, env: [«b]}]\n',
            "an item of 'env' is a mapping",
            'name, value',
        ),
        (
            'launch: [executable: {cmd: a, env: [«{name: b}]}]\n',
            "'env' needs the attribute 'value'",
            None,
        ),
        (
            'launch: [group: {children: «{node: {}}}]\n',
            "'children' wants a list",
            'put "- "',
        ),
        (
            'launch: [group: {«children: }]\n',
            "'children' wants a list",
            "'[]'",
        ),
        (
            'launch: [executable: {cmd: [a, «[b]]}]\n',
            "'cmd' is a text",
            'quote',
        ),
        # parameters
        (
            'launch: [node: {exec: a, param: [«{value: 1}]}]\n',
            "needs 'name', or 'from'",
            'name it',
        ),
        (
            'launch: [node: {exec: a, param: [«{name: b}]}]\n',
            "needs a 'value'",
            "''",
        ),
        (
            'launch:\n- node:\n    exec: a\n    param:\n      «period: 0.5\n',
            "'param' is a list",
            "write '- name: period', and 'value: 0.5' below 'name'",
        ),
        (
            'launch: [node: {exec: a, param: [{«period»: "1"}]}]\n',
            "'param' has no attribute 'period'",
            "write '- name: period', and 'value: \"1\"' below 'name'",
        ),
        (
            'launch: [node: {exec: a, param: [{«frame»: map, b: [1]}]}]\n',
            "'param' has no attribute 'frame'",
            "did you mean 'name'? Or write '- name: frame', and 'value: map' "
            "below 'name', and so for each",
        ),
        (
            'launch: [node: {exec: a, remap: [{«b»: c}]}]\n',
            "'remap' has no attribute 'b'",
            "write '- from: b', and 'to: c' below 'from'",
        ),
        (
            'launch: [node: {exec: a, param: «{name: b, value: 1}}]\n',
            "'param' is a list",
            'put "- " before \'name\', and two spaces before each line below',
        ),
        (
            'launch:\n- node:\n    exec: a\n    param:\n'
            '      - name: b\n    «value»: 1\n',
            "'node' has no attribute 'value'",
            "indent it below 'name'",
        ),
        (
            'launch: [node: {exec: a, param: [{name: b, «vaule»: 1}]}]\n',
            "'param' has no attribute 'vaule'",
            "did you mean 'value'?",
        ),
        (
            'launch: [node: {exec: a, param: [«{name: b, from: c}]}]\n',
            "'from' takes no 'name'",
            'an item of its own',
        ),
        (
            'launch: [node: {exec: a, param:'
            ' [«{name: b, value: 1, param: [{name: c, value: 1}]}]}]\n',
            "either 'value' or 'param'",
            'with a name',
        ),
        (
            'launch: [node: {exec: a, param:'
            ' [«{name: b, value: 1, allow_substs: true}]}]\n',
            "'allow_substs' goes with 'from'",
            'remove it',
        ),
        (
            'launch: [node: {exec: a, param: [{name: b, value: «~}]}]\n',
            'cannot be null',
            "''",
        ),
        (
            'launch: [node: {exec: a, param:'
            ' [{name: b, value: «2020-01-01}]}]',
            'as a date',
            'quote it',
        ),
        (
            'launch: [node: {exec: a, param: [{name: b, value: «{c: 1}}]}]\n',
            'a scalar or a list',
            "'param:' instead of 'value:'",
        ),
        (
            'launch: [node: {exec: a, param:'
            ' [{name: b, value: [1, «[2]]}]}]\n',
            'no lists or mappings',
            None,
        ),
        (
            'launch: [node: {exec: a, param:'
            ' [{name: b, value: 1, type: «integer»}]}]\n',
            "'type' cannot be 'integer'",
            "did you mean 'int'?",
        ),
        # substitutions
        (
            'launch: [let: {name: a, value: «$(find» b)}]\n',
            "unknown substitution 'find'",
            '$(find …) of ROS 1 is $(find-pkg-share package) in ROS 2',
        ),
        (
            'launch: [let: {name: a, value: «$(unit»)}]\n',
            "unknown substitution 'unit'",
            "value of the launch argument 'unit', write $(var unit)",
        ),
        (
            'launch: [let: {name: a, value: «$(unit» b)}]\n',
            "unknown substitution 'unit'",
            'the substitutions are',
        ),
        (
            'launch: [log: {message: a «$(vra» b)}]\n',
            "unknown substitution 'vra'",
            "did you mean 'var'?",
        ),
        (
            'launch: [log: {message: «$(var)»}]\n',
            "'var' takes 1 to 2 arguments, not 0",
            '$(var name [default])',
        ),
        (
            'launch: [log: {message: «$(not a b)»}]\n',
            "'not' takes 1 argument, not 2",
            '$(not condition)',
        ),
        (
            'launch: [log: {message: $(var «$(dirname a)»)}]\n',
            "'dirname' takes 0 arguments, not 1",
            '$(dirname)',
        ),
        (
            'launch: [log: {message: «$(string-join a)»}]\n',
            "'string-join' takes at least 2 arguments, not 1",
            '$(string-join delimiter text …)',
        ),
    ],
)
def test_mistake(marked, message, hint):
    mark = Marked.of(marked)
    (diagnostic,) = problems(mark.text)
    assert message in diagnostic.message
    if hint is None:
        assert diagnostic.hint is None
    else:
        assert hint in diagnostic.hint
    mark.check(diagnostic)


def test_all_mistakes_of_a_file_are_shown():
    found = problems(
        'launch:\n'
        '- nod: {}\n'
        '- node: {pkg: a, nmae: b}\n'
        '- group:\n'
        '  - log: {message: $(nope)}\n'
        '  - executable: {cmd: [a, "$(var"], env: [{name: b}], zzz: c}\n'
        '- let: {name: a, value: b, if: $(x), unless: ""}\n'
    )
    assert [d.position.line for d in found] == [2, 3, 3, 5, 6, 6, 6, 7]


PYTHON = """\
# a comment
from launch import LaunchDescription


def generate_launch_description():
    return LaunchDescription([])
"""


@pytest.mark.parametrize(
    'text',
    [PYTHON, PYTHON.replace('from', 'import launch #'), 'def f():\n  x'],
)
@pytest.mark.parametrize('suffix', ['.yml', '.yaml', '.xml', '.launch'])
def test_a_file_in_python_is_told_as_such(text, suffix):
    with pytest.raises(LaunchError, match='written in Python') as raised:
        read_launch_file(Source(f'x{suffix}', f'/x{suffix}', text))
    (problem,) = raised.value.diagnostics
    assert problem.position.line == text.count('#', 0, 1) + 1
    assert "'.launch.py'" in problem.hint


@pytest.mark.parametrize('start', ['', '# a comment\n', '---\n'])
def test_yaml_by_another_name(start):
    text = f'{start}launch: [shutdown: {{}}]'
    for suffix in ('.xml', '.launch'):
        file = read_launch_file(Source(f'x{suffix}', f'/x{suffix}', text))
        assert [e.action.name for e in file.entities] == ['shutdown']


def test_an_entry_with_mistakes_leaves_the_others_standing():
    file = read(
        'launch:\n'
        '- nod: {}\n'
        '- 5\n'
        '- shutdown: {}\n'
        '- group: {scpoed: true, children: [reset: {}, let: {name: a}]}\n'
        '- reset_env: {}\n'
    )
    names = ['', '', 'shutdown', '', 'reset', '', 'reset_env']
    assert [entity.action.name for entity in file.walk()] == names
    assert [d.position.line for d in file.problems] == [2, 3, 5, 5]
