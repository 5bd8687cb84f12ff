# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What ROS 2's own launcher does not accept."""

import pytest
from support.language_fixtures import Launcher, Marked

from tests.language.policies.test_check import checked

NODE = 'node: {pkg: alpha, exec: talker, '
BOX = (
    'node_container: {pkg: alpha, exec: talker, name: a, namespace: /, '
    'composable_node: '
)
COMPONENT = BOX + "[{pkg: my_pkg, plugin: 'my_pkg::Camera', "
GOOD = {
    'texts': NODE + "args: '5', if: 'true', respawn: 'true'}",
    'booleans': NODE + 'shell: false}',
    'numbers': NODE + 'respawn_delay: 2.0}',
    'a time of a substitution': "timer: {period: $(env T '1'), children: []}",
    'a boolean of a substitution': (
        'append_env: {name: A, value: b, prepend: $(not false)}'
    ),
    'parameters of all types': (
        NODE + 'param: [{name: a, value: 1}, {name: b, value: [true, false]}]}'
    ),
    'quotes around a text': NODE + 'args: "-x \'a b\' $(env A b)"}',
    'a container': (
        'node_container: {pkg: alpha, exec: talker, name: a, namespace: /}'
    ),
    'a component': COMPONENT + 'name: c, extra_arg: '
    "[{name: a, value: 'true'}], if: 'true', param: [{name: b, value: 1}]}]}",
    'a timer of ROS time': 'ros_timer: {period: 1.0, children: []}',
}


@pytest.mark.parametrize('name', GOOD)
def test_what_ros_2_accepts(name: str, launcher: Launcher) -> None:
    text = f'launch:\n- {GOOD[name]}\n'
    assert checked(launcher, text, portable=True).diagnostics == ()


# the place, and what the way out has in it
BAD = {
    'an extra argument': (
        COMPONENT + 'name: c, extra_arg: [{name: a, value: «true»}]}]}',
        "'true'",
    ),
    'a list as extra argument': (
        COMPONENT + 'name: c, extra_arg: [{name: a, value: «[1]}]}]}',
        'quote the whole list',
    ),
    'a boolean as condition of a component': (
        COMPONENT + 'name: c, if: «true»}]}',
        "'true'",
    ),
    'a component without a name': (
        BOX + "[«{»pkg: my_pkg, plugin: 'my_pkg::Camera'}]}",
        'add it',
    ),
    'a boolean as condition': (NODE + 'if: «true»}', "'true'"),
    'a boolean as respawn': (NODE + 'respawn: «true»}', "'true'"),
    'a number as text': ('let: {name: a, value: «5»}', "'5'"),
    'a date as text': ('let: {name: a, value: «2020-01-01»}', "'2020-01-01'"),
    'a number as message': ('log: {message: «5», level: INFO}', "'5'"),
    'a number as parameter of the scope': (
        'set_parameter: {name: a, value: «5»}',
        "'5'",
    ),
    'a list as parameter of the scope': (
        'set_parameter: {name: a, value: «[1, 2]}',
        'quote',
    ),
    'a boolean for simulated time': (
        'set_use_sim_time: {value: «true»}',
        "'true'",
    ),
    'a list of arguments': (NODE + 'args: [«a», b c]}', "a 'b c'"),
    'a whole number of seconds': (NODE + 'respawn_delay: «2»}', '2.0'),
    'a whole number as period': ('timer: {period: «1», children: []}', '1.0'),
    'a text of seconds': (NODE + "respawn_delay: «'2.0'»}", '2.0'),
    'a text of a number': (NODE + "respawn_max_retries: «'2'»}", 'quotes'),
    'a text as boolean': (
        "group: {scoped: «'false'», children: []}",
        'without quotes',
    ),
    'a substitution as boolean': (NODE + 'shell: «$(env S no)»}', "'unless'"),
    'a text that prepends': (
        "append_env: {name: A, value: b, prepend: «'true'»}",
        'without quotes',
    ),
    'a quote over a substitution': (
        NODE + "args: «-c 'a $(env B c)'»}",
        'remove the quotes',
    ),
}


@pytest.mark.parametrize('name', BAD)
def test_what_ros_2_rejects(name: str, launcher: Launcher) -> None:
    marked, hint = BAD[name]
    mark = Marked.of(f'launch:\n- {marked}\n')
    assert checked(launcher, mark.text).diagnostics == ()
    (problem,) = checked(launcher, mark.text, portable=True).errors
    mark.check(problem)
    assert hint in str(problem.hint)


NEWER = {
    'a lifecycle node': (
        '«lifecycle_node»: {pkg: alpha, exec: talker, name: a, '
        'namespace: /, respawn_max_retries: 2}',
        'Lyrical',
    ),
    'a component that is a lifecycle node': (
        BOX.replace('composable_node', 'composable_lifecycle_node')
        + "[«{»pkg: my_pkg, plugin: 'my_pkg::Camera', name: c, "
        'autostart: true}]}',
        'Lyrical',
    ),
    'an action': ('«log_info»: {message: x}', 'Lyrical'),
    'an attribute': (NODE + 'emulate_tty: «true»}', 'Iron'),
    'a substitution': ('let: {name: a, value: "«$(string-strip x)»"}', ''),
    'a nested substitution': (
        'let: {name: a, value: "$(not «$(equals a b)»)"}',
        'Iron',
    ),
}


@pytest.mark.parametrize('name', NEWER)
def test_what_older_releases_do_not_have(
    name: str, launcher: Launcher
) -> None:
    marked, release = NEWER[name]
    mark = Marked.of(f'launch:\n- {marked}\n')
    assert checked(launcher, mark.text).diagnostics == ()
    (problem,) = checked(launcher, mark.text, portable=True).diagnostics
    assert problem.severity == 'warning'
    mark.check(problem)
    assert release in problem.message


def test_a_container_without_name(launcher: Launcher) -> None:
    text = 'launch:\n- node_container: {pkg: alpha, exec: talker}\n'
    problems = checked(launcher, text, portable=True).errors
    assert [p.message.split()[4] for p in problems] == [
        "'name'",
        "'namespace'",
    ]


def test_a_path_relative_to_the_launch_file(launcher: Launcher) -> None:
    launcher.write('parts/a.yaml', 'launch:\n- include: {file: b.yaml}\n')
    launcher.write('parts/b.yaml', 'launch: []\n')
    text = 'launch:\n- include: {file: $(dirname)/parts/a.yaml}\n'
    assert checked(launcher, text).diagnostics == ()
    (problem,) = checked(launcher, text, portable=True).errors
    assert problem.hint == 'write $(dirname)/b.yaml'


def test_dirname_behind_an_include(launcher: Launcher) -> None:
    launcher.write('other/a.yaml', 'launch: []\n')
    launcher.write('b.yaml', 'launch: []\n')
    text = (
        'launch:\n- include: {{file: $(dirname)/{}}}\n- log: {{message: {}}}'
    )
    (problem,) = checked(
        launcher, text.format('other/a.yaml', '$(dirname)'), portable=True
    ).diagnostics
    assert 'before Lyrical' in problem.message
    # the other file is in the same folder
    same = text.format('b.yaml', '$(dirname)')
    assert checked(launcher, same, portable=True).diagnostics == ()


def test_a_boolean_for_set_parameter_in_xml(launcher: Launcher) -> None:
    text = '<launch><set_parameter name="use_sim_time" value="true"/></launch>'
    assert not checked(launcher, text, portable=True).diagnostics


def test_that_types_do_not_matter_in_xml(launcher: Launcher) -> None:
    launcher.write(
        'child.launch.xml',
        '<launch><let name="a" value="5"/>'
        '<timer period="1"><log message="x"/></timer></launch>',
    )
    text = 'launch:\n- include: {file: $(dirname)/child.launch.xml}\n'
    assert checked(launcher, text, portable=True).diagnostics == ()
