# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What follows when processes on another machine do something."""

import json
from pathlib import Path
import re
from xml.etree import ElementTree

from support.deployer import Deployer
from support.sshd import Sshd

_DEPLOYMENT = """\
machines: {arm: {ssh: arm}}
processes:
  - {match: 'a_*', machine: arm}
"""


def _writes(deployer: Deployer, launch: str) -> None:
    deployer.write('robot.yaml', _DEPLOYMENT)
    deployer.write('plain.yaml', launch)


def _events(deployer: Deployer) -> list[dict[str, object]]:
    lines = (deployer.log_folder / 'events.jsonl').read_text().splitlines()
    return [json.loads(line) for line in lines]


def test_what_must_run_ends_the_launch(deployer: Deployer, sshd: Sshd) -> None:
    _writes(
        deployer,
        """\
launch:
  - executable: {cmd: sleep 1000, name: here}
  - executable: {cmd: sleep 1000, name: a_other}
  - executable:
      cmd: sh -c 'printf last; exit 3'
      name: a_must
      on_exit: shutdown
  - log: {message: it begins}
""",
    )
    launch = deployer.deploys()
    assert launch.end() == 1
    output = launch.output
    assert output.count('stopping: ') == 1
    assert 'it begins' in output
    assert re.search(r'\[arm│a_must\S*\] +last\n', output)
    assert 'Traceback' not in output
    happened = _events(deployer)
    exited = {e['label']: e for e in happened if e['event'] == 'exited'}
    (must,) = (e for label, e in exited.items() if 'a_must' in str(label))
    assert (must['exit_code'], must['failed']) == (3, True)
    assert len(exited) == 3
    assert sum(not e['asked'] for e in exited.values()) == 1
    assert [e['event'] for e in happened].count('shutdown') == 1
    sshd.wait_until_empty()
    deployer.wait_until_empty()


def test_respawned_failure_there_is_counted_as_here(
    deployer: Deployer, sshd: Sshd
) -> None:
    deployer.write(
        'plain.yaml',
        "launch: [executable: {cmd: sh -c 'exit 3', respawn: 'true'}]",
    )
    for words in ((), ('--on', 'arm')):
        output = deployer.launch(*words, '--for', '60', 'plain.yaml', code=1)
        assert re.search(r'failed: sh-1 exited with code 3', output)
    sshd.wait_until_empty()


def test_a_launch_ends_when_nothing_is_left_anywhere(
    deployer: Deployer, sshd: Sshd
) -> None:
    _writes(
        deployer,
        """\
launch:
  - executable: {cmd: echo here, name: here}
  - timer:
      period: 0.5
      children:
        - executable: {cmd: echo later, name: a_late}
        - log: {message: said later}
""",
    )
    launch = deployer.deploys()
    assert launch.end() == 0
    assert re.search(r'\[arm│a_late\S*\] +later\n', launch.output)
    assert 'said later' in launch.output
    sshd.wait_until_empty()


def test_what_is_awaited_may_come_from_there(
    deployer: Deployer, sshd: Sshd, tmp_path: Path
) -> None:
    _writes(
        deployer,
        """\
launch:
  - executable: {cmd: sleep 1000, name: here}
  - executable: {cmd: sh -c 'echo ready; exec sleep 1000', name: a_node}
""",
    )
    report = tmp_path / 'report.xml'
    launch = deployer.deploys('--until', 'ready', '--junit', str(report))
    assert launch.end() == 0
    root = ElementTree.parse(report).getroot()
    names = {str(case.get('name')) for case in root.iter('testcase')}
    assert any('arm│a_node' in name for name in names), names
    assert next(iter(root)).get('failures') == '0'
    text = deployer.logged('a_node')
    assert text == 'ready\n'
    sshd.wait_until_empty()


def test_logs_of_another_machine_are_shown(
    deployer: Deployer, sshd: Sshd
) -> None:
    _writes(
        deployer,
        """\
launch:
  - executable: {cmd: sh -c 'echo hello; exec sleep 1000', name: a_node}
""",
    )
    launch = deployer.deploys()
    launch.wait_for('hello')
    assert 'hello' in deployer.launch('--logs', 'arm/a_node*')
    deployer.launch('--stop')
    assert launch.end() == 0
    sshd.wait_until_empty()
