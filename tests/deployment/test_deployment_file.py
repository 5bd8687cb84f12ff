# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The file that says where things run, and `--on`."""

import pickle

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.deployment.deployment import Deployment, Machine
from colcon_yamllaunch.deployment.deployment_file import (
    deployment_of,
    read_deployment,
)
from colcon_yamllaunch.deployment.machine_settings import deployed_on
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError, render
from colcon_yamllaunch.language.syntax.source_text import Source
from hypothesis import given
from hypothesis import strategies as st
import pytest
import yaml

FILE = """\
machines:
  arm:  {ssh: robot@arm.local, workspace: ~/ws, lost_after: 0.5}
  gpu:  {slurm: [--partition=gpu, --gres=gpu:1], sync: none}
  edge: {connect: docker exec -i edge, on_lost: keep, env: [A, B]}
processes:
  - {match: /perception/*, machine: gpu}
  - {match: {package: arm_driver}, machine: arm}
  - {match: rviz2, machine: here}
"""


def read(text):
    return deployment_of(
        Source('robot.yaml', 'robot.yaml', text, 'deployment file')
    )


def problems(text):
    with pytest.raises(LaunchError) as caught:
        read(text)
    return [
        f'{d.position.line}:{d.position.column}+{d.length} {d.message}'
        + (f' ({d.hint})' if d.hint else '')
        for d in caught.value.diagnostics
    ]


def machine(text):
    (found,) = read(f'machines: {{m: {text}}}').machines.values()
    return found


def wrong(text):
    """Return what is wrong with a machine, without the place."""
    (problem,) = problems(f'machines: {{m: {text}}}')
    return problem.partition(' ')[2]


def test_all_keys_are_read():
    found = read(FILE)
    arm, gpu, edge = found.machines.values()
    assert (arm.name, arm.kind, arm.words) == (
        'arm',
        'ssh',
        ('robot@arm.local',),
    )
    assert (arm.workspace, arm.sync, arm.on_lost) == ('~/ws', 'build', 'stop')
    assert (gpu.kind, gpu.sync) == ('slurm', 'none')
    assert gpu.words == ('--partition=gpu', '--gres=gpu:1')
    assert edge.words == ('docker', 'exec', '-i', 'edge')
    assert (edge.on_lost, edge.env) == ('keep', ('A', 'B'))
    assert (arm.lost_after, edge.lost_after) == (0.5, None)
    assert str(arm.position) == 'robot.yaml:2:3'
    assert [(str(r), r.machine) for r in found.rules] == [
        ('/perception/*', 'gpu'),
        ('package: arm_driver', 'arm'),
        ('rviz2', 'here'),
    ]
    assert str(found.rules[0].position) == 'robot.yaml:6:13'
    assert found.rules[0].length == len('/perception/*')


def test_deployment_can_be_pickled():
    assert pickle.loads(pickle.dumps(read(FILE))) == read(FILE)


@pytest.mark.parametrize(
    ('written', 'workspace'),
    [
        ('/srv/ws', '/srv/ws'),
        ('/srv/ws/', '/srv/ws'),
        ('/srv/../ws', '/ws'),
        ('~/ws', '~/ws'),
        # as scp and rsync have it
        ('ws', '~/ws'),
        ('a/b/../ws/', '~/a/ws'),
    ],
)
def test_workspace_is_normalized(written, workspace):
    assert machine(f'{{ssh: h, workspace: {written}}}').workspace == workspace


@pytest.mark.parametrize(
    ('written', 'words'),
    [
        ('{ssh: ssh://me@host:2222}', ('ssh://me@host:2222',)),
        ('{slurm: }', ()),
        ('{slurm: []}', ()),
        ('{slurm: --partition=gpu -n 1}', ('--partition=gpu', '-n', '1')),
        ('{connect: [kubectl, exec, -i, "a b", --]}',
         ('kubectl', 'exec', '-i', 'a b', '--')),
        ("{connect: sh -c 'exec \"$@\"' sh}",
         ('sh', '-c', 'exec "$@"', 'sh')),
    ],
)  # fmt: skip
def test_ways_to_machines_are_read(written, words):
    assert machine(written).words == words


def test_merged_keys_of_yaml_are_read():
    found = read(
        'machines:\n'
        '  a: &common {ssh: a, env: [X]}\n'
        '  b: {<<: *common, ssh: b}\n'
    )
    assert found.machines['b'].words == ('b',)
    assert found.machines['b'].env == ('X',)


@pytest.mark.parametrize(
    ('text', 'problem'),
    [
        ('', 'the deployment file is empty'),
        ('[]', 'the deployment file is not a mapping'),
        ('{}', 'the deployment file sets nothing'),
        ('machines: []', "'machines' is not a mapping"),
        ('machines: {}\nprocesses: {}', "'processes' is not a list"),
        ('machines: {}\nproceses: []', "the file has no key 'proceses' (did "
         "you mean 'processes'?)"),
        ('machines: {}\n---\n', 'a deployment file has one YAML document'),
        ('machines: {a: {ssh: h}, a: {ssh: h}}', "the key 'a' stands twice"),
        ('machines: {here: {ssh: h}}', "no machine is called 'here'"),
        ('machines: {a/b: {ssh: h}}', "'a/b' is no name for a machine"),
        ('machines: {-a: {ssh: h}}', "'-a' is no name for a machine"),
        ('machines: {a: [h]}', "the machine 'a' is not a mapping"),
        ('machines: {}\nprocesses: [a]', 'a rule is not a mapping'),
        ('machines: {}\nprocesses: [{match: a}]',
         'this rule sets nothing'),
        ('machines: {}\nprocesses: [{machine: here}]',
         "this rule has no 'match'"),
        ('machines: {}\nprocesses: [{match: [], machine: here}]',
         "'match' is not a text"),
        ('machines: {}\nprocesses: [{match: {}, machine: here}]',
         "'match' says nothing to match"),
        ('machines: {}\nprocesses: [{match: {pakage: a}, machine: here}]',
         "'match' has no key 'pakage' (did you mean 'package'?)"),
        ('machines: {arm: {ssh: h}}\nprocesses: [{match: a, machine: amr}]',
         "there is no machine 'amr' (did you mean 'arm'?)"),
        ('machines: {arm: {ssh: h}}\nprocesses: [{match: a, machine: zzz}]',
         "there is no machine 'zzz' (it is one of arm, here)"),
    ],
)  # fmt: skip
def test_wrong_file_is_an_error(text, problem):
    (found,) = problems(text)
    assert problem in found


@pytest.mark.parametrize(
    ('text', 'problem'),
    [
        ('{}', "it is not said how the machine 'm' is reached (say how"),
        ('{ssh: h, slurm: []}', "has both 'ssh' and 'slurm'"),
        ('{ssh: }', "'ssh' is empty"),
        ('{ssh: [a]}', "'ssh' is not a text"),
        ('{ssh: -oProxyCommand=x}', "'-oProxyCommand=x' begins with a dash"),
        ('{ssh: h -p 22}', "'h -p 22' is more than one word; options such as "
         'a port belong into ~/.ssh/config'),
        ('{slurm: gpu}', "'gpu' is no option"),
        ('{slurm: {a: b}}', "'slurm' is not a list"),
        ('{connect: ""}', "'connect' is empty"),
        ('{connect: []}', "'connect' is empty"),
        ("{connect: \"a 'b\"}", "'connect' has an open quote"),
        ('{ssh: h, workspace: ~}', "'workspace' is empty"),
        ('{ssh: h, workspace: /}', "'/' is no folder for a workspace"),
        ('{ssh: h, workspace: ../ws}', 'is no folder for a workspace'),
        ('{ssh: h, workspace: ~you/ws}', 'the home folder of somebody else'),
        ('{ssh: h, sync: biuld}', "'sync' has no value 'biuld' (did you mean "
         "'build'?)"),
        ('{ssh: h, on_lost: go}', "'on_lost' has no value 'go' (it is one of "
         'stop, restart, keep)'),
        ('{ssh: h, lost_after: 0}', "'lost_after' has no value '0' (a number "
         'of seconds from 0.1 to 3600)'),
        ('{ssh: h, lost_after: soon}', "'lost_after' has no value 'soon'"),
        ('{ssh: h, lost_after: [1]}', "'lost_after' is not a text"),
        ('{ssh: h, env: {A: [b]}}', "the value of 'A' is not a text"),
        ('{ssh: h, env: {A-B: c}}', "'A-B' is no name of a variable"),
        ('{ssh: h, env: [{A: b}]}', "a name in 'env' is not a text"),
        ('{ssh: h, setup: []}', "'setup' is not a text"),
        ('-oProxyCommand=x', "'-oProxyCommand=x' begins with a dash"),
        ('{ssh: h, env: [A B]}', "'A B' is no name of a variable"),
        ('{ssh: h, env: [A=b]}', "'A=b' is no name of a variable"),
        ('{ssh: h, workspce: /ws}', "a machine has no key 'workspce' (did you "
         "mean 'workspace'?)"),
        ('{ssh: h, "a\\nb": 1}', 'a machine has no key'),
    ],
)  # fmt: skip
def test_wrong_machine_is_an_error(text, problem):
    assert problem in wrong(text)


def test_all_problems_are_reported_at_once():
    text = (
        'machines:\n'
        '  arm: {ssh: h, sync: never, on_lost: go}\n'
        '  b?: {ssh: h}\n'
        'processes:\n'
        '  - {match: a}\n'
        '  - {match: a, machine: arm}\n'
        '  - {match: a, machine: leg}\n'
    )
    assert [p.partition(' ')[0] for p in problems(text)] == [
        '2:23+5',
        '2:39+2',
        '3:3+2',
        '5:5+1',
        '7:25+3',
    ]


def test_problem_is_rendered_like_one_of_a_launch_file(tmp_path):
    path = tmp_path / 'robot.yaml'
    path.write_text('machines:\n  arm: {shh: h}\n')
    with pytest.raises(LaunchError) as caught:
        read_deployment(str(path))
    assert render(caught.value.diagnostics, str(tmp_path)).splitlines() == [
        "robot.yaml:2:9: error: a machine has no key 'shh'",
        '  2 |   arm: {shh: h}',
        '    |         ^^^',
        "  help: did you mean 'ssh'?",
        "robot.yaml:2:3: error: it is not said how the machine 'arm' is "
        'reached',
        '  2 |   arm: {shh: h}',
        '    |   ^^^',
        '  help: say how it is reached: ssh: USER@HOST, slurm: '
        '[--partition=NAME], or connect: COMMAND',
    ]


def test_missing_file_is_an_error(tmp_path):
    with pytest.raises(LaunchError, match=r"cannot read deployment file '.*'"):
        read_deployment(str(tmp_path / 'robot.yaml'))


@pytest.mark.parametrize(
    ('word', 'found'),
    [
        ('robot@arm.local', Machine('arm.local', 'ssh', ('robot@arm.local',))),
        ('arm', Machine('arm', 'ssh', ('arm',))),
        ('ssh://me@arm:22', Machine('arm', 'ssh', ('ssh://me@arm:22',))),
        ('me@[fe80::1%eth0]', Machine('fe80--1-eth0', 'ssh',
                                      ('me@[fe80::1%eth0]',))),
        ('slurm:', Machine('slurm', 'slurm', ())),
        ('slurm:partition=cpu,time=10',
         Machine('slurm', 'slurm', ('--partition=cpu', '--time=10'))),
    ],
)  # fmt: skip
def test_on_takes_a_destination_or_slurm(word, found):
    assert deployed_on(word) == Deployment(
        {found.name: found}, everything_on=found.name
    )


@pytest.mark.parametrize('word', ['', ' ', '-oProxyCommand=x', 'a b', 'a\nb'])
def test_on_refuses_other_words(word):
    with pytest.raises(UserError, match=r'^--on takes USER@HOST as ssh does'):
        deployed_on(word)


def test_on_takes_a_machine_of_the_file():
    file = read(FILE)
    found = deployed_on('arm', file)
    assert found.machines == file.machines
    assert (found.everything_on, found.rules) == ('arm', ())
    with pytest.raises(
        UserError, match=r"no machine 'amr'.*did you mean 'arm'"
    ):
        deployed_on('amr', file)


def test_variables_may_have_values():
    found = machine("{ssh: h, env: {A: 7, B: '', C: , D: 'a b'}}")
    assert found.env == ('C',)
    assert found.values == (('A', '7'), ('B', ''), ('D', 'a b'))


def test_destination_alone_is_reached_by_ssh():
    assert machine('robot@arm') == machine('{ssh: robot@arm}')


def test_defaults_hold_for_all_machines():
    found = read(
        'defaults: {sync: none, setup: ~/a.bash, env: {A: 1}}\n'
        'machines:\n'
        '  arm: robot@arm\n'
        '  base: {ssh: base, sync: install, env: [B]}\n'
    ).machines
    arm, base = found['arm'], found['base']
    assert (arm.sync, arm.setup, arm.values) == (
        'none',
        '~/a.bash',
        (('A', '1'),),
    )
    assert (base.sync, base.setup) == ('install', '~/a.bash')
    assert (base.env, base.values) == (('B',), ())


def test_wrong_defaults_are_reported_once():
    text = 'defaults: {ssh: a, synk: none, sync: no}\nmachines: {a: b, c: d}\n'
    assert sorted(problems(text)) == [
        "1:12+3 'defaults' has no key 'ssh' (there are workspace, sync, "
        'on_lost, lost_after, env, setup, python)',
        "1:20+4 'defaults' has no key 'synk' (did you mean 'sync'?)",
        "1:38+2 'sync' has no value 'no' (did you mean 'none'?)",
    ]


_WORDS = st.sampled_from(
    ['machines', 'processes', 'ssh', 'slurm', 'connect', 'workspace', 'sync',
     'on_lost', 'lost_after', 'env', 'python', 'setup', 'defaults', 'match',
     'machine', 'name', 'package', 'executable', 'arm', 'here', 'build',
     'keep', '~/ws', '/ws', 'a b', '-x', '', '~', '*', "a 'b"]
)  # fmt: skip
_SCALARS = _WORDS | st.text(max_size=5) | st.integers() | st.none()
_VALUES = st.recursive(
    _SCALARS,
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(_WORDS, inner, max_size=5)
    ),
    max_leaves=20,
)
_MACHINES = st.dictionaries(
    _WORDS, st.dictionaries(_WORDS, _VALUES, max_size=4), max_size=3
)
_RULES = st.lists(
    st.fixed_dictionaries({'match': _VALUES, 'machine': _SCALARS}), max_size=3
)


@given(
    _VALUES
    | st.fixed_dictionaries({'machines': _MACHINES, 'processes': _RULES})
)
def test_any_yaml_is_read_or_refused(value):
    text = yaml.safe_dump(value, allow_unicode=True)
    try:
        found = read(text)
    except LaunchError as e:
        assert e.diagnostics
        assert all(d.position.path == 'robot.yaml' for d in e.diagnostics)
        return
    for name, one in found.machines.items():
        assert one.name == name
        assert all(isinstance(word, str) for word in one.words)
        assert one.kind == 'slurm' or one.words
        assert not one.workspace or one.workspace.startswith(('/', '~/'))
    for rule in found.rules:
        assert rule.machine in (*found.machines, 'here')
        assert str(rule)
