# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A launch file in XML comes to the same plan as its twin in YAML."""

from dataclasses import replace
import textwrap
from xml.sax.saxutils import quoteattr

from colcon_yamllaunch.language.policies.evaluate import evaluate
from colcon_yamllaunch.language.vocabulary.actions import ACTIONS
from colcon_yamllaunch.plan.plan import (
    Component,
    ParameterFile,
    Process,
    Timer,
)
from colcon_yamllaunch.plan.position import Position
import pytest
import yaml

NOWHERE = Position('', 1, 1)

TWINS = {
    'process attributes': (
        """
        - executable:
            cmd: "echo a 'b c' $(env SET)"
            name: said
            shell: no
            emulate_tty: "true"
            respawn: true
            respawn_delay: 2
            respawn_max_retries: 3
            sigterm_timeout: 1
            sigkill_timeout: 2.5
            on_exit: shutdown
            launch-prefix: /usr/bin/env -i
        """,
        """
        <executable cmd="echo a &apos;b c&apos; $(env SET)" name="said"
            shell="no" emulate_tty="true" respawn="true" respawn_delay="2"
            respawn_max_retries="3" sigterm_timeout="1" sigkill_timeout="2.5"
            on_exit="shutdown" launch-prefix="/usr/bin/env -i"/>
        """,
    ),
    'param_types': (
        """
        - node:
            pkg: alpha
            exec: talker
            param:
            - {name: i, value: 42}
            - {name: neg, value: -3}
            - {name: f, value: 2.5}
            - {name: exp, value: 1.0e-3}
            - {name: b, value: true}
            - {name: yes_plain, value: yes}
            - {name: iq, value: "42"}
            - {name: s, value: hello}
            - {name: spaces, value: hello world}
            - {name: url, value: "http://x:1/y"}
            - {name: octal, value: 010}
        """,
        """
        <node pkg="alpha" exec="talker">
          <param name="i" value="42"/>
          <param name="neg" value="-3"/>
          <param name="f" value="2.5"/>
          <param name="exp" value="1.0e-3"/>
          <param name="b" value="true"/>
          <param name="yes_plain" value="yes"/>
          <param name="iq" value="'42'"/>
          <param name="s" value="hello"/>
          <param name="spaces" value="hello world"/>
          <param name="url" value="http://x:1/y"/>
          <param name="octal" value="010"/>
        </node>
        """,
    ),
    'typed parameters': (
        """
        - node:
            pkg: alpha
            exec: talker
            param:
            - {name: s, value: "42", type: str}
            - {name: colon, value: "a: b", type: str}
            - {name: empty, value: "", type: str}
            - {name: i, value: 42, type: int}
            - {name: f, value: 42.0, type: float}
            - {name: e, value: 1000.0, type: float}
            - {name: b, value: true, type: bool}
            - {name: y, value: 42, type: yaml}
            - {name: v, value: "$(var five)", type: str}
            - {name: w, value: "$(var five)", type: float}
            - {name: x, value: "$(var five)"}
        """,
        """
        <node pkg="alpha" exec="talker">
          <param name="s" value="42" type="str"/>
          <param name="colon" value="a: b" type="str"/>
          <param name="empty" value="" type="str"/>
          <param name="i" value="42" type="int"/>
          <param name="f" value="42" type="float"/>
          <param name="e" value="1e3" type="float"/>
          <param name="b" value="true" type="bool"/>
          <param name="y" value="42" type="yaml"/>
          <param name="v" value="$(var five)" type="str"/>
          <param name="w" value="$(var five)" type="float"/>
          <param name="x" value="$(var five)"/>
        </node>
        """,
    ),
    'param_lists': (
        """
        - node:
            pkg: alpha
            exec: talker
            param:
            - {name: li, value: [1, 2, 3]}
            - {name: lf, value: [1.0, 2.5]}
            - {name: lb, value: [true, false]}
            - {name: ls, value: [a, "1"]}
            - {name: lv, value: [1, $(var five)]}
            - {name: ts, value: ["1", "2"], type: list_of_str}
            - {name: tf, value: [1.0, 2.0], type: list_of_float}
            - {name: semi, value: [1, 2]}
            - {name: comma, value: ["1", " 2"], type: list_of_str}
            - {name: floats, value: [1.0, 5.0], type: list_of_float}
        """,
        """
        <node pkg="alpha" exec="talker">
          <param name="li" value="[1, 2, 3]"/>
          <param name="lf" value="[1.0, 2.5]"/>
          <param name="lb" value="[true, false]"/>
          <param name="ls" value="[a, '1']"/>
          <param name="lv" value="[1, $(var five)]"/>
          <param name="ts" value="['1', '2']" type="list_of_str"/>
          <param name="tf" value="[1, 2]" type="list_of_float"/>
          <param name="semi" value="1;2" value-sep=";"/>
          <param name="comma" value="1, 2" value-sep="," type="list_of_str"/>
          <param name="floats" value="1, $(var five)" value-sep=", "
                 type="list_of_float"/>
        </node>
        """,
    ),
    'subst_quotes': (
        """
        - executable:
            cmd: >-
              echo $(env UNSET 'with space') $(env 'SET') $(env UNSET "dq")
        - log: {message: '\\$(env SET) a\\\\b $$(env SET) <&>'}
        """,
        """
        <executable cmd='echo $(env UNSET &apos;with space&apos;)
                         $(env &apos;SET&apos;) $(env UNSET "dq")'/>
        <log message="\\$(env SET) a\\\\b $$(env SET) &lt;&#38;>"/>
        """,
    ),
}
#: Launch files in YAML whose twins in XML differ in no value.
ALIKE = {
    'node_full': """
- node:
    pkg: alpha
    exec: talker
    name: my_talker
    namespace: robot
    args: "--flag 'two words' last"
    ros_args: --log-level debug
    exec_name: nice_name
    output: screen
    cwd: /tmp
    env:
    - {name: T_ONE, value: "1"}
    - {name: T_TWO, value: $(env SET)}
    remap:
    - {from: chatter, to: /loud/chatter}
    - {from: a, to: $(env SET)}
    param: [{name: rate, value: 10}]
""",
    'param_nested': """
- node:
    pkg: alpha
    exec: talker
    name: nested
    namespace: /ns
    param:
    - name: outer
      param:
      - {name: a, value: 1}
      - name: inner
        param:
        - {name: deep, value: $(env SET)}
    - {name: flat.dotted, value: x}
    - {from: params.yaml, allow_substs: true}
""",
    'scopes': """
- arg: {name: a, default: "1", choice: [{value: "1"}, {value: "2"}]}
- bool_arg: {name: b, default: "true", description: about}
- let: {name: v, value: before}
- group:
    scoped: no
    if: $(var b)
    keep: [{name: k, value: kept}]
    children:
    - let: {name: v, value: "inside $(var k)"}
    - group: [let: {name: v, value: dropped}]
- log: {message: "$(var v) $(var a)", level: ERROR}
- group: {forwarding: false, children: [log: {message: $(var a x)}]}
- reset: {keep: [{name: a, value: "3"}]}
- log_info: {message: "$(var v gone) $(var a)"}
- reset: {}
- log_warning: {message: $(var a gone)}
- log_error: {message: e, unless: "false"}
- log_debug: {message: d, unless: "true"}
""",
    'env_actions': """
- set_env: {name: T_A, value: one}
- append_env: {name: T_A, value: two}
- append_env: {name: T_A, value: zero, prepend: true, separator: "|"}
- unset_env: {name: SET}
- set_ros_log_dir: {new_log_dir: sub}
- executable: {cmd: echo}
- reset_env: {}
- executable: {cmd: echo}
""",
    'ros settings': """
- push_ros_namespace: {namespace: outer}
- push-ros-namespace: {namespace: inner}
- set_parameter: {name: list, value: "[1, 2]"}
- set_parameter: {name: text, value: $(env SET)}
- set_parameters_from_file: {filename: params.yaml}
- set_remap: {from: a, to: b}
- set_use_sim_time: {value: true}
- node_container:
    pkg: alpha
    exec: talker
    name: box
    namespace: c
    composable_node:
    - pkg: my_pkg
      plugin: my_pkg::Camera
      name: camera
      namespace: d
      if: $(env IF true)
      param:
      - {name: rate, value: 1.0}
      - {from: params.yaml}
      - {name: more, param: [{name: deep, value: [1, 2]}]}
      remap: [{from: a, to: b}, {from: c, to: d}]
      extra_arg: [{name: use_intra_process_comms, value: 'true'}]
    composable_lifecycle_node:
    - {pkg: my_pkg, plugin: 'my_pkg::Viewer', autostart: true}
- load_composable_node:
    target: /outer/inner/c/box
    composable_node:
    - {pkg: my_pkg, plugin: 'my_pkg::Viewer', unless: '1'}
    - {pkg: my_pkg, plugin: 'my_pkg::Viewer', name: second}
- lifecycle_node: {pkg: alpha, exec: talker, name: lc, autostart: true}
""",
    'timer and loops': """
- timer:
    period: 0.5
    cancel_on_shutdown: false
    children: [executable: {cmd: echo late}]
- ros_timer: {period: 1.5, children: [executable: {cmd: echo later}]}
- for: {len: 2, name: i, children: [log: {message: $(index i)}]}
- for_each:
    values: "{a: 1};{a: 2}"
    children: [log: {message: $(for-var a)}]
- group: []
- shutdown: {reason: over}
""",
    'include': """
- include:
    file: inner.launch.xml
    arg: [{name: rate, value: "99"}]
    let: [{name: more, value: ""}]
- include: {file: inner.yaml, arg: [{name: rate, value: "1"}]}
""",
}


def element(name, attributes):
    """Return the XML of an action, or of an item in one of its lists."""
    texts, inside = '', ''
    if isinstance(attributes, list):
        attributes = {'children': attributes}
    for key, value in attributes.items():
        if key == 'children':
            inside += ''.join(
                element(*pair) for a in value for pair in a.items()
            )
        elif isinstance(value, list) and isinstance(value[0], dict):
            inside += ''.join(element(key, item) for item in value)
        else:
            text = value if isinstance(value, str) else f'[{", ".join(value)}]'
            texts += f' {key}={quoteattr(text)}'
    return f'<{name}{texts}>{inside}</{name}>'


def neutral(entry):
    """Return an entry of a plan without what tells the twins apart."""
    if isinstance(entry, Timer):
        return replace(entry, entries=tuple(map(neutral, entry.entries)))
    if isinstance(entry, Component):
        values = [
            (p.name, p.value)
            for p in (*entry.parameters, *entry.extra_arguments)
        ]
        bare = replace(
            entry, position=NOWHERE, parameters=(), extra_arguments=()
        )
        return bare, values
    if not isinstance(entry, Process):
        return entry
    argv = tuple(
        replace(a, parameters=()) if isinstance(a, ParameterFile) else a
        for a in entry.argv
    )
    parameters = [(p.name, p.value) for p in entry.parameters]
    return (
        replace(entry, argv=argv, position=NOWHERE, parameters=()),
        parameters,
    )


def entries(launcher, name, text):
    path = str(launcher.write(name, text))
    request = launcher.request('', five='5')
    evaluation = evaluate(replace(request, name=path, path=path))
    assert evaluation.errors == ()
    assert evaluation.plan.entries
    return [neutral(entry) for entry in evaluation.plan.entries]


@pytest.mark.parametrize('name', [*TWINS, *ALIKE])
def test_twins(launcher, name):
    launcher.write('params.yaml', '/**: {ros__parameters: {a: $(env SET)}}')
    launcher.write(
        'inner.launch.xml',
        '<launch deprecated="use a"><arg name="rate"/>'
        '<log message="$(var rate)$(var more)"/></launch>',
    )
    launcher.write(
        'inner.yaml',
        'launch: [arg: {name: rate}, log: {message: $(var rate)$(var more)}]',
    )
    if name in TWINS:
        text, xml = (textwrap.dedent(text) for text in TWINS[name])
        xml = f'<launch>{xml}</launch>'
    else:
        text = ALIKE[name]
        xml = element('launch', yaml.load(text, yaml.BaseLoader))
    expected = entries(launcher, 'twin.yaml', text)
    assert entries(launcher, 'twin.xml', xml) == expected


def test_that_every_action_has_a_twin():
    text = ''.join(ALIKE.values()) + ''.join(
        text for text, _ in TWINS.values()
    )
    assert [name for name in ACTIONS if f'{name}:' not in text] == []


def test_what_a_schema_needs_at_the_root_is_ignored(launcher):
    text = (
        '<launch version="0.1.1" xmlns="a" xmlns:xsi="b" xsi:c="d">'
        '<log message="a"/></launch>'
    )
    assert len(entries(launcher, 'a.launch', text)) == 1
