# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Inspecting a launch without running it."""

import json
import subprocess

from colcon_yamllaunch.plan.plan import EventHandler, Plan
from colcon_yamllaunch.plan.plan_json import plan_to_json
from colcon_yamllaunch.plan.position import Position
from support.user import built, User

SAY = """\
launch:
  - arg: {name: who, default: nobody}
  - executable: {cmd: $(find-pkg-prefix {name})/lib/{name}/hello.sh $(var who)}
"""


def test_plan_builds_and_runs_nothing(user: User) -> None:
    user.package('one', SAY)
    output = user.launch('one', 'one', '--plan')
    assert 'src/one/launch/one.yaml:3:5' in output
    assert 'hello.sh nobody' in output
    assert 'hello from' not in output
    assert not (user.root / 'build').exists()


def test_commands_of_a_plan_can_be_pasted(user: User) -> None:
    user.package('one', SAY)
    user.launch('one', 'one')
    output = user.launch('--plan', 'one', 'one', "who:=it's")
    first, ready, *_, command = output.splitlines()
    assert first.startswith('before you paste a command')
    done = subprocess.run(
        ['bash', '-c', f'{ready}\n{command}'],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == "hello from one it's\n"


def test_saved_plan_runs_as_it_is(user: User) -> None:
    user.package('one', SAY)
    user.launch('one', 'one')
    plan = user.launch('one', 'one', '--plan=json', 'who:=me')
    assert json.loads(plan)['version'] == 1
    path = user.write('plan.json', plan)
    user.write('src/one/launch/one.yaml', 'launch: []\n')
    output = user.launch('--from-plan', 'plan.json', cwd=path.parent)
    assert 'hello from one me' in output
    assert built(output) == []


def test_file_that_has_no_plan(user: User) -> None:
    user.write('plan.json', '{"version": 1, "entries": 3}')
    output = user.launch('--from-plan', 'plan.json', code=1)
    assert "'plan.json' has no plan: plan.entries is not a list" in output
    output = user.launch('--from-plan', 'plan.jsn', code=1)
    assert "'plan.jsn' has no plan: No such file or directory" in output


def test_saved_plan_that_needs_python_is_not_run(user: User) -> None:
    position = Position(str(user.root / 'a.launch.py'), 7, 5)
    handler = EventHandler('shutdown', (), '', ('call f',), position)
    user.write('plan.json', plan_to_json(Plan(handlers=(handler,))))
    output = user.launch('--from-plan', 'plan.json', code=1)
    assert "'plan.json' cannot be run, as what happens while it" in output
    assert 'up to Python (a.launch.py:7:5): launch that file' in output


def test_drawings(user: User) -> None:
    user.package('one', SAY)
    assert 'flowchart TB' in user.launch('one', 'one', '--plan=mermaid')
    assert 'digraph launch {' in user.launch('one', 'one', '--plan=dot')


def test_mistakes_show_instead_of_a_plan(user: User) -> None:
    user.package('one', SAY.replace('who)', 'woh)'))
    output = user.launch('one', 'one', '--plan', code=1)
    assert "launch configuration 'woh' does not exist" in output
    assert "did you mean 'who'?" in output


def test_schema(user: User) -> None:
    folder = user.package('own')
    (folder / 'setup.cfg').write_text(
        '[options.entry_points]\nlaunch.frontend.launch_extension =\n'
        '  own = own\n'
    )
    (folder / 'own.py').write_text(
        "@expose_action('own_action')\nclass Own(Action):\n"
        '    raise SystemExit\n'
    )
    schema = json.loads(user.launch('--schema'))
    assert 'launch' in schema['properties']
    known = schema['definitions']['action']['properties']
    assert 'of the package own' in known['own_action']['description']


def test_schema_of_deployment_files(user: User) -> None:
    schema = json.loads(user.launch('--schema=deploy'))
    assert 'processes' in schema['properties']
    assert 'ready' in schema['definitions']['rule']['properties']


def test_check_looks_at_every_branch(user: User) -> None:
    user.package('two')
    user.package(
        'one',
        'launch:\n'
        '  - arg: {name: rare, default: "false"}\n'
        '  - include: {file: $(find-pkg-share two)/launch/no.yaml,\n'
        '              if: $(var rare)}\n'
        '  - node: {pkg: neo, exec: x, if: $(var rare)}\n'
        '  - node: {pkg: two, exec: hello.sh}\n'
        '  - node: {pkg: two, exec: helo.sh, if: $(var rare)}\n',
    )
    user.manifest('one')
    output = user.launch('one', 'one', '--check', code=1)
    place = 'src/one/launch/one.yaml'
    assert f'{place}:3:' in output
    assert f'{place}:5:' in output
    assert "did you mean 'one'?" in output
    assert f'{place}:6:' not in output.replace('warning', '')
    assert "error: two has no executable 'helo.sh'\n" in output
    assert '\n  help: it has hello.sh\n' in output
    assert 'add <exec_depend>two</exec_depend>' in output
    assert '3 errors, 1 warning in 1 launch file' in output
    assert not (user.root / 'build').exists()


def test_check_of_what_a_build_will_bring(user: User) -> None:
    user.package('one', SAY.replace('executable: {cmd', 'log: {message'))
    assert 'no problems' in user.launch('one', 'one', '--check')


def test_check_of_a_whole_workspace(user: User) -> None:
    assert 'there are no launch files to check' in user.launch(
        '--check', code=1
    )
    user.package('one', SAY)
    include = '  - include: {file: $(find-pkg-share one)/launch/one.yaml}\n'
    user.package('two', f'launch:\n{include}')
    # no launch file, though it lies among them
    user.write('src/two/launch/settings.yaml', 'a: 1\n')
    assert 'no problems in 2 launch files' in user.launch('--check')
    user.write('src/one/launch/more.launch.xml', '<launch><nod/></launch>')
    user.write('src/one/launch/one.yaml', 'launch:\n  - nod: {}\n')
    output = user.launch('--check', code=1, cwd=user.root / 'src/two')
    folder = user.root / 'src/one/launch'
    assert f'{folder}/more.launch.xml:1:10: error: ' in output
    # once, although another one includes it
    assert output.count(f'{folder}/one.yaml:2:5: error: ') == 1
    assert '2 errors in 3 launch files' in output
    assert 'there is nothing to launch' in user.launch(
        '--check', 'who:=me', code=1
    )
    output = user.launch(code=1)
    assert 'Launch files here:\n' in output
    assert '\n    colcon launch one one.yaml\n' in output
    assert 'settings.yaml' not in output


def test_check_for_programs(user: User) -> None:
    user.package('one', 'launch:\n  - nod: {}\n')
    output = user.launch('one', 'one', '--check=json', code=1)
    assert json.loads(output)['diagnostics'][0]['line'] == 2
    output = user.launch('one', 'one', '--check=github', code=1)
    assert '::error file=src/one/launch/one.yaml,line=2,' in output
    output = user.launch('one', 'one', '--check=sarif', code=1)
    assert json.loads(output)['version'] == '2.1.0'


def test_check_for_other_launchers(user: User) -> None:
    user.package('one', 'launch:\n  - arg: {name: a, default: 5}\n')
    assert user.launch('one', 'one', '--check')
    output = user.launch('one', 'one', '--check', '--portable', code=1)
    assert 'src/one/launch/one.yaml:2:' in output
    assert '--portable goes with --check' in user.launch(
        'one', 'one', '--plan', '--portable', code=1
    )


def test_show_args(user: User) -> None:
    user.package('one', SAY)
    for option in ('--show-args', '-s'):
        output = user.launch('one', 'one', option)
        assert "    'who':" in output
        assert "(default: 'nobody')" in output
        assert 'src/one/launch/one.yaml:2:' in output
    assert not (user.root / 'build').exists()


def test_show_args_of_a_file_with_mistakes(user: User) -> None:
    user.package('one', 'launch:\n  - nod: {}\n')
    # what is asked for is there; it is the launch that would fail
    assert "did you mean 'node'?" in user.launch('one', 'one', '-s')
