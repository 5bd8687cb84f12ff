# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launches whose files use actions and substitutions of other packages."""

from pathlib import Path

from support.user import User

MODULE = """\
from launch.actions import ExecuteProcess
from launch.frontend import expose_action
from launch.frontend import expose_substitution
from launch.substitution import Substitution
from launch.utilities import normalize_to_list_of_substitutions
from launch.utilities import perform_substitutions


@expose_action('say')
class Say(ExecuteProcess):
    @classmethod
    def parse(cls, entity, parser):
        text = parser.parse_substitution(entity.get_attr('text'))
        return cls, {'cmd': ['echo', text], 'output': 'screen'}


@expose_substitution('upper')
class Upper(Substitution):
    def __init__(self, text):
        super().__init__()
        self.text = normalize_to_list_of_substitutions(text)

    @classmethod
    def parse(cls, data):
        return cls, {'text': data[0]}

    def perform(self, context):
        return perform_substitutions(context, self.text).upper()
"""
LAUNCH = """\
launch:
- arg: {name: who, default: me}
- group:
  - let: {name: greeting, value: $(upper hello)}
  - say: {text: $(var greeting) $(var who)}
- say: {text: never, if: $(equals $(var who) nobody)}
"""


def install(user: User) -> Path:
    """Install a package that has them, as it is sourced."""
    entry = '[launch.frontend.launch_extension]\nsaying = saying\n'
    user.write('site/saying.py', MODULE)
    user.write('site/saying-1.0.dist-info/entry_points.txt', entry)
    metadata = 'Metadata-Version: 2.1\nName: saying\nVersion: 1.0\n'
    user.write('site/saying-1.0.dist-info/METADATA', metadata)
    before = user.environment.get('PYTHONPATH', '')
    user.environment['PYTHONPATH'] = f'{user.root}/site:{before}'
    return user.write('said.launch.yaml', LAUNCH)


def test_they_are_a_part_of_the_plan(ros_user: User) -> None:
    path = str(install(ros_user))
    assert '] HELLO you\n' in ros_user.launch(path, 'who:=you')
    assert 'no problems' in ros_user.launch(path, '--check')
    plan = ros_user.launch(path, '--plan')
    assert 'said.launch.yaml:5:5' in plan
    assert "echo 'HELLO me'" in plan
    assert 'never' not in plan


def test_without_ros_the_package_is_named(user: User) -> None:
    path = str(install(user))
    output = user.launch(path, code=1)
    assert "the substitution 'upper' of the package 'saying'" in output
    assert "the action 'say' of the package 'saying'" in output
    assert output.count(' error: ') == 2
    output = user.launch(path, '--check')
    assert output.count(' warning: this cannot be checked: ') > 1
