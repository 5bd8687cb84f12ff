# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The launch arguments that are found without launching anything."""

from pathlib import Path
from textwrap import dedent

from colcon_yamllaunch.language.evaluation.budget import MAXIMUM_INCLUDE_DEPTH
from colcon_yamllaunch.language.evaluation.findings import DeclaredArgument
from colcon_yamllaunch.language.evaluation.request import Request
from colcon_yamllaunch.language.policies.check import (
    Declarations,
    find_declarations,
)
from colcon_yamllaunch.language.reports import show_arguments
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
import pytest
from support.language_fixtures import Launcher, LOG_FOLDER


def find(launcher: Launcher, text: str, **arguments: str) -> Declarations:
    path = str(launcher.write('main.yaml', dedent(text)))
    return find_declarations(
        Request(
            path,
            path,
            packages=launcher.packages,
            environment=launcher.environment,
            arguments=arguments,
            cwd=str(launcher.folder),
            log_folder=LOG_FOLDER,
        ),
    )


def found(
    launcher: Launcher, text: str, **arguments: str
) -> dict[str, DeclaredArgument]:
    """Return the arguments of a launch file whose includes are all known."""
    declarations = find(launcher, text, **arguments)
    assert declarations.not_followed == {}
    assert declarations.mistakes == ()
    return {a.name: a for a in declarations.arguments}


def marked(launcher: Launcher, text: str, **arguments: str) -> list[str]:
    """Return the names in order, those used conditionally with a star."""
    return [
        name + '*' * argument.is_conditional
        for name, argument in found(launcher, text, **arguments).items()
    ]


def show(launcher: Launcher, text: str) -> str:
    return show_arguments(find(launcher, text), str(launcher.folder))


def test_the_layout_is_that_of_ros2_launch(launcher: Launcher) -> None:
    launcher.write('sub.yaml', 'launch:\n- arg: {name: port, default: 1}\n')
    text = """\
        launch:
        - arg: {name: rate, default: 10, description: Messages per second}
        - arg: {name: robot}
        - arg:
            name: mode
            default: $(env HOME)/$(var robot)
            description: How it drives
            choice: [{value: fast}, {value: 'no'}]
        - bool_arg: {name: sim, default: '', if: $(var robot)}
        - include: {file: sub.yaml, arg: [{name: port, value: 2}]}
        - include: {file: $(var robot).yaml}
        """
    assert show(launcher, text) == dedent("""\
        Arguments (pass arguments as '<name>:=<value>'):

            'rate':
                Messages per second
                (default: '10')
                (declared at main.yaml:2:3)

            'robot':
                no description given
                (required)
                (declared at main.yaml:3:3)

            'mode':
                How it drives. Valid choices are: ['fast', 'no']
                (default: '$(env HOME)/$(var robot)')
                (declared at main.yaml:4:3)

            'sim':*
                One of: ['true', 'false', 'True', 'False', 'TRUE', 'FALSE']
                (default: '')
                (declared at main.yaml:9:3)

            'port':
                no description given
                (default: '1')
                (declared at sub.yaml:2:3)
                (always set at main.yaml:10:35)

        * argument(s) which are only used if specific conditions occur

        Includes that may have more arguments:

            main.yaml:11:19:
                its path shows only when it is launched""")


def test_no_arguments(launcher: Launcher) -> None:
    assert show(launcher, 'launch: []') == (
        "Arguments (pass arguments as '<name>:=<value>'):\n\n  No arguments."
    )


def test_texts_of_several_lines_stay_indented(launcher: Launcher) -> None:
    text = show(
        launcher,
        """\
        launch:
        - arg:
            name: a
            description: |
              One.

              Two.
            default: ''
        """,
    )
    assert "    'a':\n        One.\n\n        Two.\n        (default" in text


def test_the_first_declaration_counts(launcher: Launcher) -> None:
    launcher.write('sub.yaml', 'launch: [arg: {name: a, default: sub}]')
    arguments = found(
        launcher,
        """\
        launch:
        - arg: {name: a, default: first}
        - arg: {name: a, default: second}
        - include: {file: sub.yaml, arg: [{name: a, value: third}]}
        """,
    )
    (argument,) = arguments.values()
    assert argument.default == 'first'
    assert argument.position.line == 2
    assert argument.set_at is None


@pytest.mark.parametrize(
    ('text', 'names'),
    [
        ("- arg: {name: a, if: 'true'}", ['a*']),
        ("- arg: {name: a, unless: 'true'}", ['a*']),
        ('- group: [arg: {name: a}]', ['a']),
        ("- group: {if: 'false', children: [arg: {name: a}]}", ['a*']),
        (
            '- group: {if: true, children: [group: [arg: {name: a}]]}',
            ['a*'],
        ),
        ('- timer: {period: 1, children: [arg: {name: a}]}', ['a*']),
        ('- for: {len: 0, name: i, children: [arg: {name: a}]}', ['a*']),
        ("- for_each: {values: '', children: [arg: {name: a}]}", ['a*']),
        ('- include: {file: sub.yaml, if: $(var x)}', ['sub*']),
        (
            '- group: {unless: 0, children: [include: {file: sub.yaml}]}',
            ['sub*'],
        ),
        ('- group: {if: 0, children: []}\n- arg: {name: a}', ['a']),
    ],
)
def test_conditional_arguments_are_marked(
    text: str, names: list[str], launcher: Launcher
) -> None:
    launcher.write('sub.yaml', 'launch: [arg: {name: sub}]')
    assert marked(launcher, f'launch:\n{text}\n') == names


@pytest.mark.parametrize(
    ('text', 'names'),
    [
        ('- reset: {}\n- arg: {name: a}', []),
        ('- group: [reset: {}, arg: {name: a}]\n- arg: {name: b}', ['b']),
        (
            '- group: {scoped: false, children: [reset: {}]}\n'
            '- arg: {name: a}',
            [],
        ),
        ('- include: {file: reset.yaml}\n- arg: {name: a}', []),
        (
            '- timer: {period: 1, children: [reset: {}]}\n- arg: {name: a}',
            ['a'],
        ),
        ('- reset: {if: $(var x)}\n- arg: {name: a}', ['a*']),
        (
            '- group: [reset: {if: $(var x)}, arg: {name: a}]\n'
            '- arg: {name: b}',
            ['a*', 'b'],
        ),
    ],
)
def test_nothing_counts_behind_a_reset(
    text: str, names: list[str], launcher: Launcher
) -> None:
    launcher.write('reset.yaml', 'launch: [reset: {}, arg: {name: sub}]')
    assert marked(launcher, f'launch:\n{text}\n') == names


@pytest.mark.parametrize(
    'text',
    [
        '- include: {file: folder/sub.yaml}',
        '- include: {file: $(dirname)/folder/sub.yaml}',
        '- include: {file: $(env FOLDER)/sub.yaml}',
        '- include: {file: $(path-join $(var where folder) sub.yaml)}',
        '- include: {file: "$(if true folder $(env FOLDER))/sub.yaml"}',
        '- arg: {name: given}\n- include: {file: $(var given)/sub.yaml}',
        '- arg: {name: f, default: $(env FOLDER)}\n'
        '- include: {file: $(var f)/sub.yaml}',
        '- let: {name: f, value: folder}\n'
        '- group: [let: {name: f, value: other}]\n'
        '- include: {file: $(var f)/sub.yaml}',
        '- set_env: {name: F, value: folder}\n'
        '- include: {file: $(env F)/sub.yaml}',
        '- include: {file: between.yaml, arg: [{name: f, value: folder}]}',
        '- group: {keep: [{name: f, value: folder}], forwarding: false, '
        'children: [include: {file: $(var f)/sub.yaml}]}',
        '- group: [let: {name: f, value: $(command never)}]\n'
        '- arg: {name: f, default: folder}\n'
        '- include: {file: $(var f)/sub.yaml}',
        '- let: {name: f, value: $(command never)}\n'
        '- let: {name: f, value: folder}\n'
        '- include: {file: $(var f)/sub.yaml}',
        '- include: {file: "$(if true folder $(command never))/sub.yaml"}',
    ],
)
def test_an_include_is_followed(text: str, launcher: Launcher) -> None:
    launcher.environment['FOLDER'] = 'folder'
    launcher.write('folder/sub.yaml', 'launch: [arg: {name: sub}]')
    launcher.write(
        'between.yaml', 'launch: [include: {file: $(var f)/sub.yaml}]'
    )
    text = f'launch:\n{text}\n'
    assert 'sub' in found(launcher, text, given='folder')


def test_an_include_of_a_package_is_followed(launcher: Launcher) -> None:
    class Packages(type(launcher.packages)):  # type: ignore[misc]
        def locate(self, path: str) -> tuple[str, str] | None:
            share = '/install/my_pkg/share/my_pkg/'
            source = str(launcher.folder / path.removeprefix(share))
            return (path, source) if path.startswith(share) else None

    launcher.packages = Packages({'my_pkg': []})
    launcher.write('launch/sub.yaml', 'launch: [arg: {name: sub}]')
    text = (
        'launch:\n'
        '- include: {file: $(find-pkg-share my_pkg)/launch/sub.yaml}\n'
    )
    argument = found(launcher, text)['sub']
    assert argument.position.path == str(launcher.folder / 'launch/sub.yaml')


@pytest.mark.parametrize(
    ('text', 'reason'),
    [
        ('- include: {file: $(command «»)}', 'only when it is launched'),
        ('- include: {file: "$(if true $(command «»))"}', 'only when it is'),
        ("- include:\n    file: $(eval '«»')", 'only when it is launched'),
        (
            '- let: {name: f, value: $(command «»)}\n'
            '- include: {file: $(var f)}',
            'only when it is launched',
        ),
        (
            '- arg: {name: f, default: $(command «»)}\n'
            '- include: {file: $(var f)}',
            'only when it is launched',
        ),
        (
            '- let: {name: f, value: sub.yaml}\n'
            '- let: {name: f, value: other.yaml, if: $(command «»)}\n'
            '- include: {file: $(var f)}',
            'only when it is launched',
        ),
        (
            '- set_env: {name: F, value: sub.yaml}\n'
            '- set_env: {name: F, value: $(command «»)}\n'
            '- include: {file: $(env F)}',
            'only when it is launched',
        ),
        (
            "- set_env: {name: F, value: sub.yaml, if: 'true'}\n"
            '- include: {file: $(env F other.yaml)}',
            'only when it is launched',
        ),
        (
            '- arg: {name: needed}\n- include: {file: $(var needed)}',
            'only when it is launched',
        ),
        ('- include: {file: $(var x)}', "'x' does not exist"),
        ('- include: {file: nonesuch.yaml}', 'does not exist'),
        ('- include: {file: $(find-pkg-share p)/a.yaml}', "no package 'p'"),
        ("- include: {if: 'false', file: broken.yaml}", 'unknown action'),
        ('- include: {file: sub.launch.py}', 'written in Python'),
    ],
)
def test_an_include_that_cannot_be_followed_is_named(
    text: str, reason: str, launcher: Launcher, tmp_path: Path
) -> None:
    launcher.write('sub.yaml', 'launch: [arg: {name: sub}]')
    launcher.write('broken.yaml', 'launch: [nonesuch: {}]')
    launcher.write('sub.launch.py', '')
    ran = tmp_path / 'ran'
    text = text.replace('command «»', f"command 'touch {ran}'")
    text = text.replace('«»', f'open("{ran}", "w")')

    declarations = find(launcher, f'launch:\n{text}\n- arg: {{name: last}}\n')

    assert declarations.arguments[-1].name == 'last'
    assert 'sub' not in {a.name for a in declarations.arguments}
    ((position, message),) = declarations.not_followed.items()
    assert reason in message
    assert position.path == str(tmp_path / 'main.yaml')
    assert not ran.exists()


def test_an_include_in_xml_is_followed(launcher: Launcher) -> None:
    launcher.write(
        'sub.launch.xml',
        '<launch><arg name="sub" default="$(env SET)" if="true"/></launch>',
    )
    text = 'launch: [include: {file: sub.launch.xml}]'
    argument = found(launcher, text)['sub']
    assert argument.default == '$(env SET)'
    assert argument.is_conditional


def test_an_argument_that_an_include_always_gives(launcher: Launcher) -> None:
    launcher.write('sub.yaml', 'launch: [arg: {name: a}, arg: {name: b}]')
    arguments = found(
        launcher,
        """\
        launch:
        - include:
            file: sub.yaml
            arg:
            - {name: a, value: 5}
        """,
    )
    set_at = arguments['a'].set_at
    assert set_at is not None
    assert set_at.line == 5
    assert arguments['b'].set_at is None


def test_a_file_that_includes_itself(launcher: Launcher) -> None:
    text = """\
        launch:
        - arg: {name: a}
        - include: {file: main.yaml}
        - include: {file: main.yaml, if: $(var a)}
        - arg: {name: b}
        """
    assert marked(launcher, text) == ['a', 'b']


def test_a_chain_of_too_many_includes(launcher: Launcher) -> None:
    for number in range(MAXIMUM_INCLUDE_DEPTH + 1):
        launcher.write(
            f'{number}.yaml',
            f'launch: [arg: {{name: a{number}}}, '
            f'include: {{file: {number + 1}.yaml}}]',
        )
    declarations = find(launcher, 'launch: [include: {file: 0.yaml}]')
    assert len(declarations.arguments) == MAXIMUM_INCLUDE_DEPTH - 1
    (message,) = declarations.not_followed.values()
    assert 'include one another' in message


@pytest.mark.full
def test_includes_that_multiply_end(launcher: Launcher) -> None:
    for number in range(30):
        twice = f'include: {{file: {number + 1}.yaml}}'
        launcher.write(f'{number}.yaml', f'launch: [{twice}, {twice}]')
    launcher.write('30.yaml', 'launch: [arg: {name: a}]')
    assert marked(launcher, 'launch: [include: {file: 0.yaml}]') == ['a']


def test_all_mistakes_of_the_files_are_reported(launcher: Launcher) -> None:
    launcher.write('sub.yaml', 'launch: [nod: {}, shutdwn: {}]')
    launcher.write('other.yaml', 'launch: [include: {file: sub.yaml}]')
    problems = find(
        launcher,
        """\
        launch:
        - include: {file: other.yaml}
        """,
    ).mistakes
    assert [p.message for p in problems] == [
        "unknown action 'nod'",
        "unknown action 'shutdwn'",
    ]
    assert [Path(i.path).name for i in problems[0].includes] == [
        'other.yaml',
        'main.yaml',
    ]


def test_mistakes_hide_no_other_arguments(launcher: Launcher) -> None:
    launcher.write(
        'sub.yaml', 'launch: [arg: {name: b}, nod: {}, arg: {name: c}]'
    )
    text = """\
        launch:
        - arg: {name: a}
        - include: {file: sub.yaml}
        - include: {file: sub.yaml}
        - group: {scpoed: true, children: [arg: {name: d}]}
        - nod: {children: [arg: {name: e}]}
        - arg: {name: z}
        """
    declarations = find(launcher, text)
    names = [argument.name for argument in declarations.arguments]
    assert names == ['a', 'b', 'c', 'd', 'z']
    assert [m.message for m in declarations.mistakes] == [
        "'group' has no attribute 'scpoed'",
        "unknown action 'nod'",
        "unknown action 'nod'",
    ]


def test_a_launch_file_that_cannot_be_read(launcher: Launcher) -> None:
    with pytest.raises(LaunchError, match='empty'):
        find(launcher, '')
