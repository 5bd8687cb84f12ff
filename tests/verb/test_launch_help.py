# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""`colcon launch --help` on a terminal of 80 columns."""

import re

from support.user import User


def test_help_fits_and_has_the_common_options_first(user: User) -> None:
    user.environment['COLUMNS'] = '80'
    text = user.launch('--help')
    assert max(map(len, text.splitlines())) <= 80
    groups = re.findall(r'^(\w.*):$', text, re.MULTILINE)
    known = [
        'positional arguments',
        'options',
        'Looking without running',
        'Building',
        'What is shown and kept',
        'Running',
        'Watching files',
        'Other machines',
        'Ending by itself, as in CI',
        'Running launches',
    ]
    assert groups[: len(known)] == known
    assert groups[-1] == 'examples'
    examples = text.partition('examples:\n')[2].splitlines()
    assert examples[0] == '  colcon launch my_pkg demo.yaml'
    assert all(line.startswith('  colcon launch ') for line in examples)
