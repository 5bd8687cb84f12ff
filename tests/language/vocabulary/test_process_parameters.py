# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The parameters of a process, those in files included."""

import os

from colcon_yamllaunch.language.actions.parameter_files import parameters_of
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.plan.position import Position


def test_a_limit_of_the_files_that_are_read(tmp_path):
    text = '/**: {ros__parameters: {%s: 1}}\n'
    for name in ('one', 'two', 'three'):
        (tmp_path / name).write_text(text % name)
    (tmp_path / 'big').write_text(text % 'big' + ' ' * 99)
    os.mkfifo(tmp_path / 'pipe')
    names = ('pipe', 'one', 'big', 'two', 'none', 'three')
    options = [word for name in names for word in ('--params-file', name)]
    process = Process(
        label='a',
        argv=('a', '--ros-args', *options),
        cwd=str(tmp_path),
        position=Position('/ws/demo.yaml', 1, 1),
    )

    def found(*limit):
        return [p.name for p in parameters_of(process, *limit)]

    assert found() == ['one', 'big', 'two', 'three']
    assert found(2 * len(text % 'two')) == ['one', 'two']
