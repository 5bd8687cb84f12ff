# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Looking a launch file over without running it."""

from pathlib import Path

from colcon_yamllaunch.language.evaluation.findings import CheckResult
from colcon_yamllaunch.language.policies.check import check
from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic
import pytest
from support.language_fixtures import Launcher, Marked


def checked(
    launcher: Launcher,
    text: str,
    *,
    portable: bool = False,
    **given: str,
) -> CheckResult:
    return check(launcher.request(text, **given), portable=portable)


def found(launcher: Launcher, text: str, **given: str) -> list[str]:
    """Return the problems, without their places."""
    return [
        f'{d.severity}: {d.message}'
        for d in checked(launcher, text, **given).diagnostics
    ]


def only(launcher: Launcher, marked: str, **given: str) -> Diagnostic:
    """Return the one problem, which is where the text marks."""
    mark = Marked.of(f'launch:\n{marked}')
    (diagnostic,) = checked(launcher, mark.text, **given).diagnostics
    mark.check(diagnostic)
    return diagnostic


GOOD = {
    'both branches': """
- arg: {name: flag, default: 'true'}
- node: {pkg: alpha, exec: talker, name: one, if: $(var flag)}
- node: {pkg: alpha, exec: listener, name: one, unless: $(var flag)}
""",
    'alternatives of one argument': """
- arg: {name: mode, default: sim}
- node: {pkg: alpha, exec: talker, name: n, if: $(equals $(var mode) sim)}
- node: {pkg: alpha, exec: talker, name: n, if: $(equals $(var mode) real)}
""",
    'an empty default that a condition asks for': """
- arg: {name: extra, default: ''}
- include: {file: $(var extra), if: "$(not-equals $(var extra) '')"}
""",
    'such a condition behind another name': """
- arg: {name: extra, default: ''}
- let: {name: has_extra, value: "$(not-equals $(var extra) '')"}
- include: {file: $(var extra), if: $(var has_extra)}
""",
    'such a condition in Python': """
- arg: {name: extra, default: ''}
- include:
    file: $(var extra)
    if: $(eval "'$(var extra)' != ''")
""",
    'a name that only some branch sets': """
- arg: {name: flag, default: 'false'}
- let: {name: port, value: /dev/tty0, if: $(var flag)}
- node: {pkg: alpha, exec: talker, args: $(var port), if: $(var flag)}
""",
    'a package that is only known at launch': """
- node: {pkg: $(env PACKAGE x), exec: talker}
- node: {pkg: $(command 'cat /etc/package'), exec: talker}
- include: {file: $(env FOLDER .)/x.yaml}
- node: {pkg: alpha, exec: talker, args: $(var may_come_with_the_include)}
""",
    'names that differ by namespace': """
- group:
  - push_ros_namespace: {namespace: left}
  - node: {pkg: alpha, exec: talker, name: one}
- group:
  - push_ros_namespace: {namespace: right}
  - node: {pkg: alpha, exec: talker, name: one}
- node: {pkg: alpha, exec: talker, name: one}
""",
    'what a group keeps': """
- let: {name: a, value: alpha}
- group:
    forwarding: false
    keep: [{name: b, value: $(var a)}]
    children:
    - node: {pkg: $(var b), exec: talker}
- reset: {keep: [{name: c, value: $(var a)}]}
- node: {pkg: $(var c), exec: talker}
""",
    'a loop': """
- for:
    len: 3
    name: i
    children:
    - node: {pkg: alpha, exec: talker, name: n$(index i)}
- for_each:
    values: '{who: talker}; {who: listener}'
    children:
    - node: {pkg: alpha, exec: $(for-var who)}
- for_each:
    values: $(env ROBOTS '')
    children:
    - node: {pkg: alpha, exec: $(for-var who)}
""",
    'a parameter of the scope': """
- set_parameter: {name: rate, value: '5'}
- node: {pkg: alpha, exec: talker, args: $(param rate)}
""",
    'a process with a PATH of its own': """
- set_env: {name: PATH, value: /my/bin}
- executable: {cmd: my_program}
""",
    'launch arguments that every process heeds': """
- arg: {name: sigterm_timeout, default: '2'}
- arg: {name: launch-prefix, default: nice}
- executable: {cmd: whatever}
""",
    'a program that something else finds': """
- executable: {cmd: whatever, shell: true}
- executable: {cmd: whatever, launch-prefix: find}
""",
    'what a condition declares and uses': """
- arg: {name: mode, default: real}
- arg: {name: world, if: $(equals $(var mode) sim)}
- group:
    scoped: false
    if: $(equals $(var mode) sim)
    children:
    - arg: {name: rate, default: 5, choice: [{value: '5'}]}
- log: {message: $(var world), if: $(equals $(var mode) sim)}
- log: {message: $(var rate), if: $(equals $(var mode) sim)}
""",
    'a file of arguments for others': """
- arg: {name: a, default: 1}
- let: {name: b, value: 1}
- bool_arg: {name: c, default: 'true'}
""",
    'a file that a build may bring': """
- set_parameter: {name: x, value: $(file-content /install/x/share/x/y)}
""",
}


@pytest.mark.parametrize('name', GOOD)
def test_nothing_is_wrong_with(name: str, launcher: Launcher) -> None:
    assert found(launcher, GOOD[name]) == []


@pytest.mark.parametrize('mode', ['sim', 'real'])
def test_nothing_is_wrong_once_the_condition_is_given(
    mode: str, launcher: Launcher
) -> None:
    text = GOOD['what a condition declares and uses']
    assert found(launcher, text, mode=mode, world='w') == []


BAD = {
    'a package': '- node: {pkg: «alhpa», exec: talker}',
    'a package under a condition that does not hold': """
- arg: {name: flag, default: 'false'}
- node: {pkg: «alhpa», exec: talker, if: $(var flag)}
""",
    'a package under a condition that never holds': (
        "- node: {pkg: «alhpa», exec: talker, if: 'false'}"
    ),
    'a package of a default': """
- arg: {name: where, default: alhpa}
- node: {pkg: «$(var where)», exec: talker}
""",
    'a program on the PATH': (
        '- executable: {cmd: «no_such_program» --verbose}'
    ),
    'a launch prefix': (
        '- executable: {cmd: echo, launch-prefix: «no_such_program -e»}'
    ),
    'a program of no package': '- node: {exec: «no_such_program»}',
    'a program by its path': (
        '- executable: {cmd: «$(dirname)/no_such_program»}'
    ),
    'an undefined name': (
        '- node: {pkg: alpha, exec: talker, args: --x «$(var nonesuch)»}'
    ),
    'an undefined name within an eval': """
- let: {name: x, value: "$(eval '«$(var nonesuch)» + 1')"}
""",
    'a name that is set too late': """
- node: {pkg: alpha, exec: talker, args: «$(var late)»}
- let: {name: late, value: x}
""",
    'a name of a scope that has ended': """
- group:
  - let: {name: inner, value: x}
- node: {pkg: alpha, exec: talker, args: «$(var inner)»}
""",
    'a name that a group does not see': """
- let: {name: a, value: alpha}
- group:
    forwarding: false
    children:
    - node: {pkg: «$(var a)», exec: talker}
""",
    'a name that was reset': """
- let: {name: gone, value: x}
- reset: {}
- node: {pkg: alpha, exec: talker, args: «$(var gone)»}
""",
    'a node name made of an argument': """
- arg: {name: robot, default: r-2}
- node: {pkg: alpha, exec: talker, name: «$(var robot)_driver»}
""",
    'a parameter value of an argument': """
- arg: {name: rate, default: fast}
- node:
    pkg: alpha
    exec: talker
    param: [{name: a, value: «$(var rate)», type: int}]
""",
    'an expression': """
- let: {name: x, value: "«$(eval '1 / 0')»"}
""",
    'an expression that is no Python': """
- let: {name: x, value: "«$(eval '1 +')»"}
""",
    'a variable of no loop': '- log: {message: «$(for-var x)»}',
    'a parameter that nothing sets': '- log: {message: «$(param rate)»}',
}


@pytest.mark.parametrize('name', BAD)
def test_an_error_points_at(name: str, launcher: Launcher) -> None:
    assert only(launcher, BAD[name]).severity == 'error'


DOUBTFUL = {
    'the same node twice': """
- node: {pkg: alpha, exec: talker, name: one}
- node: {pkg: alpha, exec: talker, name: «one»}
""",
    'the same node under conditions that have nothing in common': """
- arg: {name: a, default: 'true'}
- arg: {name: b, default: 'false'}
- node: {pkg: alpha, exec: talker, name: one, if: $(var a)}
- node: {pkg: alpha, exec: talker, name: «one», if: $(var b)}
""",
    'the same full name in two ways': """
- node: {pkg: alpha, exec: talker, name: one, namespace: /x}
- push_ros_namespace: {namespace: x}
- node: {pkg: alpha, exec: talker, name: «one»}
""",
    'a node in a loop': """
- for:
    len: 2
    name: i
    children:
    - node: {pkg: alpha, exec: talker, name: «one»}
""",
    'a name that is remapped twice': """
- node:
    pkg: alpha
    exec: talker
    remap: [{from: a, to: b}, {from: «a», to: c}]
""",
    'a name that the scope remaps': """
- set_remap: {from: a, to: b}
- node: {pkg: alpha, exec: talker, remap: [{from: «a», to: c}]}
""",
    'an argument that is not used': """
- arg: {name: «unused», default: x}
- log: {message: hello}
""",
    'a parameter file that is skipped': (
        '- node: {pkg: alpha, exec: talker, param: [{from: «/no/such.yaml»}]}'
    ),
    'an environment variable that is not there': (
        '- log: {message: «$(env NOT_SET)»}'
    ),
    'an empty list': (
        '- node: {pkg: alpha, exec: talker, param: [{name: a, value: «[]}]}'
    ),
}


@pytest.mark.parametrize('name', DOUBTFUL)
def test_a_warning_points_at(name: str, launcher: Launcher) -> None:
    assert only(launcher, DOUBTFUL[name]).severity == 'warning'


def test_that_the_nearest_package_is_named(launcher: Launcher) -> None:
    assert only(launcher, BAD['a package']).hint == "did you mean 'alpha'?"


def test_that_all_mistakes_are_found_at_once(launcher: Launcher) -> None:
    launcher.write('broken.yaml', '- nod: {}\n- grop: []\n')
    text = """
- node: {pkg: alhpa, exec: talker, args: $(var x), output: y, name: 1a}
- include: {file: $(dirname)/broken.yaml}
- node: {pkg: alpha, exec: nonesuch}
"""
    assert len(found(launcher, text)) == 7


def test_that_a_mistake_leaves_the_rest_of_its_file_standing(
    launcher: Launcher,
) -> None:
    launcher.write(
        'sub.yaml',
        'launch: [arg: {name: a}, nod: {}, node: {pkg: alhpa, exec: x}]',
    )
    problems = found(
        launcher,
        """
- include: {file: sub.yaml, arg: [{name: a, value: 1}, {name: b, value: 1}]}
- node: {pkg: alpha, exec: talkr}
""",
    )
    assert problems == [
        "error: unknown action 'nod'",
        "error: there is no package 'alhpa' in the workspace or the sourced "
        'environment',
        "error: package 'alpha' has no executable 'talkr'",
    ]


def test_that_what_a_mistake_may_have_set_is_not_missed(
    launcher: Launcher,
) -> None:
    problems = found(
        launcher,
        """
- arg: {name: used}
- agr: {name: a, default: $(var used)}
- let: {name: b, valeu: 5}
- log: {message: $(var a) $(var b)}
""",
    )
    assert problems == [
        "error: unknown action 'agr'",
        "error: 'let' has no attribute 'valeu'",
    ]


def test_that_a_file_that_cannot_be_read_lacks_no_argument(
    launcher: Launcher,
) -> None:
    launcher.write('sub.yaml', 'launch: [')
    problems = found(
        launcher,
        '- include: {file: sub.yaml, arg: [{name: a, value: 1}]}\n',
    )
    assert len(problems) == 1


def test_that_a_command_is_never_run(launcher: Launcher) -> None:
    witness = launcher.folder / 'witness'
    text = f"""
- let: {{name: x, value: "$(command 'touch {witness}')"}}
- let:
    name: y
    value: $(eval "open('{witness}', 'w')")
- log: {{message: $(var x), if: "$(command 'touch {witness}')"}}
"""
    assert found(launcher, text) == []
    assert not witness.exists()


CHILD = """
- arg: {name: mode, choice: [{value: fast}, {value: slow}]}
- node: {pkg: alpha, exec: talker, args: $(var mode)}
"""


class TestInclude:
    def test_that_it_is_looked_at(self, launcher: Launcher) -> None:
        launcher.write('child.yaml', '- node: {pkg: no, exec: x}\n')
        text = '- include: {file: $(dirname)/child.yaml}\n'
        (problem,) = checked(launcher, text).diagnostics
        assert problem.position is not None
        assert Path(problem.position.path).name == 'child.yaml'
        (include,) = problem.includes
        assert (include.line, include.column) == (2, 19)

    def test_a_required_argument(self, launcher: Launcher) -> None:
        launcher.write('child.yaml', CHILD)
        problem = only(
            launcher, '- include: {file: «$(dirname)/child.yaml»}\n'
        )
        assert problem.severity == 'error'
        assert "requires the launch argument 'mode'" in problem.message

    def test_an_argument_of_the_scope(self, launcher: Launcher) -> None:
        launcher.write('child.yaml', CHILD)
        text = """
- arg: {name: mode, default: fast}
- include: {file: $(dirname)/child.yaml}
"""
        assert found(launcher, text) == []

    def test_an_unknown_argument(self, launcher: Launcher) -> None:
        launcher.write('child.yaml', CHILD)
        problem = only(
            launcher,
            """
- include:
    file: $(dirname)/child.yaml
    arg: [{name: mode, value: fast}, {name: «mod», value: fast}]
""",
        )
        assert problem.severity == 'warning'
        assert problem.hint == "did you mean 'mode'?"

    def test_arguments_that_others_of_the_include_use(
        self, launcher: Launcher
    ) -> None:
        launcher.write('child.yaml', CHILD)
        launcher.write('other.yaml', '- arg: {name: x, default: 1}')
        text = """
- include:
    file: $(dirname)/child.yaml
    arg: [{name: kind, value: fa}, {name: mode, value: $(var kind)st}]
- include:
    file: $(dirname)/child.yaml
    arg: [{name: own, value: fast}]
    let: [{name: mode, value: $(var own)}]
- include: {file: other.yaml, arg: [{name: behind, value: 5}]}
- log: {message: $(var behind) $(var x)}
"""
        assert found(launcher, text) == []

    def test_an_argument_for_what_it_includes(
        self, launcher: Launcher
    ) -> None:
        launcher.write('grandchild.yaml', CHILD)
        launcher.write('child.yaml', '- include: {file: grandchild.yaml}\n')
        text = """
- include: {file: child.yaml, arg: [{name: mode, value: fast}]}
"""
        assert found(launcher, text) == []

    def test_that_a_value_that_is_no_choice_is_shown_where_it_is_passed(
        self, launcher: Launcher
    ) -> None:
        launcher.write('child.yaml', CHILD)
        problem = only(
            launcher,
            """
- include:
    file: $(dirname)/child.yaml
    arg: [{name: mode, value: «warp»}]
""",
        )
        assert problem.severity == 'error'
        assert problem.includes == ()

    def test_two_times_with_other_values(self, launcher: Launcher) -> None:
        launcher.write(
            'child.yaml',
            """
- arg: {name: robot}
- arg: {name: talks, default: 'true'}
- node: {pkg: alpha, exec: talker, name: $(var robot), if: $(var talks)}
- node: {pkg: alpha, exec: listener, name: ear, unless: $(var talks)}
""",
        )
        text = """
- group:
  - include: {file: child.yaml, arg: [{name: robot, value: a}]}
- group:
  - include: {file: child.yaml, arg: [{name: robot, value: b},
      {name: talks, value: 'true'}]}
"""
        assert found(launcher, text) == []

    def test_that_what_it_sets_is_seen(self, launcher: Launcher) -> None:
        launcher.write('common.yaml', '- arg: {name: x, default: 1}')
        text = """
- include: {file: common.yaml}
- log: {message: $(var x)}
"""
        assert found(launcher, text) == []

    def test_one_that_includes_itself(self, launcher: Launcher) -> None:
        text = '- include: {file: $(dirname)/main.yaml}\n'
        (problem,) = found(launcher, text)
        assert 'include one another' in problem

    def test_one_that_may_include_itself(self, launcher: Launcher) -> None:
        text = """
- arg: {name: depth, default: '0'}
- include:
    file: $(dirname)/main.yaml
    if: $(not-equals $(var depth) 0)
    arg: [{name: depth, value: "$(eval '$(var depth) - 1')"}]
"""
        assert found(launcher, text) == []

    def test_a_tree_of_many_paths(self, launcher: Launcher) -> None:
        for number in range(30):
            text = f'- include: {{file: part{number + 1}.yaml}}\n' * 3
            launcher.write(f'part{number}.yaml', f'launch:\n{text}')
        launcher.write('part30.yaml', 'launch: []\n')
        text = '- include: {file: part0.yaml}\n'
        assert found(launcher, text) == []

    def test_one_in_python(self, launcher: Launcher) -> None:
        launcher.write('child.launch.py', '')
        text = """
- arg: {name: x, default: '1'}
- include: {file: child.launch.py, arg: [{name: y, value: z}]}
- log: {message: $(var set_in_python)}
"""
        assert found(launcher, text) == []


class TestArguments:
    @pytest.mark.parametrize('file', ['$(dirname)/p.yaml', '$(env FILE x)'])
    def test_that_a_parameter_file_may_use_them(
        self, file: str, launcher: Launcher
    ) -> None:
        launcher.write('p.yaml', '/**: {ros__parameters: {a: $(var a)}}')
        launcher.write(
            'child.yaml',
            f"""
- arg: {{name: a, default: '1'}}
- node:
    pkg: alpha
    exec: talker
    param: [{{from: {file}, allow_substs: true}}]
""",
        )
        text = """
- include: {file: child.yaml, arg: [{name: a, value: '2'}]}
"""
        assert found(launcher, text) == []

    REQUIRED = """
- arg: {name: must}
- node: {pkg: $(var must), exec: talker}
"""

    def test_that_they_need_not_be_given(self, launcher: Launcher) -> None:
        assert found(launcher, self.REQUIRED) == []

    def test_that_those_of_an_include_are_not_those_of_its_parent(
        self, launcher: Launcher
    ) -> None:
        launcher.write(
            'child.yaml',
            '- arg: {name: a, default: x}\n- reset_env: {}\n',
        )
        text = """
- arg: {name: a, default: x}
- include: {file: child.yaml, arg: [{name: a, value: $(var a)}]}
"""
        (problem,) = checked(launcher, text).diagnostics
        assert problem.message == "the launch argument 'a' is never used"
        assert problem.position is not None
        assert Path(problem.position.path).name == 'child.yaml'

    def test_that_given_ones_count(self, launcher: Launcher) -> None:
        assert found(launcher, self.REQUIRED, must='alpha') == []
        (problem,) = found(launcher, self.REQUIRED, must='nonesuch')
        assert "no package 'nonesuch'" in problem

    def test_one_that_is_not_declared(self, launcher: Launcher) -> None:
        (problem,) = checked(launcher, self.REQUIRED, mus='x').diagnostics
        assert problem.position is None
        assert problem.hint == "did you mean 'must'?"


def test_that_the_result_names_what_was_seen(launcher: Launcher) -> None:
    launcher.write('child.yaml', 'launch: []\n')
    result = checked(
        launcher,
        """
- include: {file: child.yaml, if: 'false'}
- node: {pkg: alpha, exec: talker}
""",
    )
    names = [Path(source.path).name for source in result.files]
    assert names == ['main.yaml', 'child.yaml']
    assert list(result.packages) == ['alpha']
    assert [use.name for use in result.executables] == ['talker']


def test_a_file_that_cannot_be_read(launcher: Launcher) -> None:
    (problem,) = found(launcher, 'launch: [')
    assert problem.startswith('error: ')


def test_a_launch_file_in_xml(launcher: Launcher) -> None:
    launcher.write(
        'child.launch.xml',
        '<launch><node pkg="alhpa" exec="talker" respawn="true"/></launch>',
    )
    text = '- include: {file: child.launch.xml}\n'
    (problem,) = checked(launcher, text, portable=True).errors[:1]
    assert "no package 'alhpa'" in problem.message


LOAD = """
- arg: {name: flag, default: 'true'}
- node_container:
    {pkg: alpha, exec: talker, name: box, if: $(var flag), composable_node:
     [{pkg: my_pkg, plugin: 'my_pkg::Camera', name: a, unless: $(var flag)}]}
- load_composable_node:
    target: %s
    composable_node:
    - {pkg: my_pkg, plugin: 'my_pkg::Viewer', name: b, if: $(var flag)}
    - {pkg: my_pkg, plugin: 'my_pkg::Viewer', name: b, unless: $(var flag)}
"""


@pytest.mark.parametrize('target', ['box', '$(var flag)', '$(env UNKNOWN x)'])
def test_good_components(launcher: Launcher, target: str) -> None:
    result = checked(launcher, LOAD % target)
    assert result.diagnostics == ()
    assert [use.plugin for use in result.plugins] == [
        'my_pkg::Camera',
        'my_pkg::Viewer',
        'my_pkg::Viewer',
    ]
    assert list(result.packages) == ['alpha', 'my_pkg']


@pytest.mark.parametrize(
    ('default', 'name', 'severity'),
    [
        ('false', 'model', 'warning'),
        ('maybe', 'model', 'error'),
        ('true', 'model', 'error'),
        # a slip of the pen
        ('false', 'falg', 'error'),
        ('false', 'flagg', 'error'),
    ],
)
def test_configurations_that_are_only_read_under_a_condition(
    launcher: Launcher, default: str, name: str, severity: str
) -> None:
    read = f'$(var {name})'
    text = (
        f"launch:\n- arg: {{name: flag, default: '{default}'}}\n"
        '- group:\n  - node: {pkg: alpha, exec: talker, '
        f'args: {read}, if: $(var flag)}}\n'
    )
    if default == 'maybe':
        # not under the condition
        text = text.replace('if: $(var flag)', 'name: $(var flag)')
    message = f"{severity}: launch configuration '{name}' does not exist"
    assert message in found(launcher, text)


def test_a_given_argument_makes_a_condition_certain(
    launcher: Launcher,
) -> None:
    text = (
        "launch:\n- arg: {name: flag, default: 'false'}\n"
        '- log: {level: INFO, message: $(var model), if: $(var flag)}\n'
    )
    message = "error: launch configuration 'model' does not exist"
    assert found(launcher, text, flag='true') == [message]


def test_a_container_in_a_file_that_cannot_be_looked_at(
    launcher: Launcher,
) -> None:
    launcher.write('box.launch.py', '')
    include = '- include: {file: box.launch.py}\n'
    assert found(launcher, LOAD % 'other' + include) == []


def test_sections_for_nodes_that_are_not_there(launcher: Launcher) -> None:
    launcher.write(
        'p.yaml',
        ''.join(f'{n}: {{ros__parameters: {{a: 1}}}}\n' for n in 'abc'),
    )
    node = '- node: {pkg: alpha, exec: talker%s, param: [{from: p.yaml}]}\n'
    named = f'launch:\n{node % ", name: a"}'
    (problem,) = checked(launcher, named).diagnostics
    assert problem.severity == 'warning'
    assert "gets 'p.yaml' is '/b', '/c'" in problem.message
    assert problem.position is not None
    assert problem.position.line == 2
    # it may be one of them
    assert found(launcher, named + node % '') == []
    unsure = node % ', name: $(env NAME b)'
    assert found(launcher, named + unsure) == []


def test_sections_of_a_file_for_all_of_a_scope(launcher: Launcher) -> None:
    launcher.write(
        'p.yaml',
        ''.join(f'{n}: {{ros__parameters: {{a: 1}}}}\n' for n in 'ab'),
    )
    text = """
- set_parameters_from_file: {filename: «p.yaml»}
- node: {pkg: alpha, exec: talker, name: a}
- node: {pkg: alpha, exec: talker, name: c}
- node: {pkg: alpha, exec: talker, name: b, namespace: ns}
"""
    problem = only(launcher, text)
    assert "section '/b' of 'p.yaml' is not for the node '/ns/b'" in (
        problem.message
    )
    assert found(launcher, Marked.of(text).text.replace('ns}', '/}')) == []
