# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The words that are about running launches, read as colcon reads them."""

import argparse
import re

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.verb.command_line import parse_launch_options
from colcon_yamllaunch.verb.options import LaunchOptions
import pytest
from support import command_lines
from support.command_lines import launch_options


def known(key: str, words: list[str], *options: str) -> argparse.Namespace:
    """Return what colcon's parser leaves, with some words for an option."""
    values = command_lines.known('launch', *options)
    setattr(values, key, words)
    return values


def parsed(line: str) -> LaunchOptions:
    return launch_options(*line.split())


@pytest.mark.parametrize(
    ('line', 'expected'),
    [
        ('--status', {'status': 'text'}),
        ('--status=json', {'status': 'json'}),
        ('--status --of my_pkg', {'status': 'text', 'of': 'my_pkg'}),
        ('--stop', {}),
        ('--stop a b*', {'names': ('a', 'b*')}),
        ('--of 12 --stop a', {'names': ('a',), 'of': '12'}),
        ('--stop a --of 12', {'names': ('a',), 'of': '12'}),
        ('--restart a', {'names': ('a',)}),
        ('--logs', {'follow': False}),
        ('--logs a b', {'names': ('a', 'b')}),
        ('--logs -f a', {'names': ('a',), 'follow': True}),
        ('--logs a -f', {'names': ('a',), 'follow': True}),
        ('-f --logs a', {'names': ('a',), 'follow': True}),
        ('--attach a', {'names': ('a',)}),
        (
            '--lifecycle a activate',
            {'names': ('a',), 'transition': 'activate'},
        ),
        (
            '--lifecycle a b --of 12 cleanup',
            {'names': ('a', 'b'), 'of': '12', 'transition': 'cleanup'},
        ),
        ('--attach=a --of 12', {'names': ('a',), 'of': '12'}),
    ],
)
def test_requests_to_running_launches(
    line: str, expected: dict[str, object]
) -> None:
    options = parsed(line)
    (request,) = re.findall('--(?!of)([a-z]+)', line)
    assert options.request == request
    default = {'names': (), 'of': None, 'follow': False, 'transition': ''}
    for name, value in (default | expected).items():
        assert getattr(options, name) == value


@pytest.mark.parametrize(
    'line',
    [
        '--attach a pkg file',
        '--attach=a pkg file x:=1',
        'pkg file --attach a',
        '--attach a file.yaml',
        '--attach a --from-plan plan.json',
    ],
)
def test_attach_with_something_to_launch_launches(line: str) -> None:
    options = parsed(line)
    assert options.request is None
    assert options.attach == 'a'
    assert options.positionals or options.from_plan


@pytest.mark.parametrize(
    ('line', 'text'),
    [
        ('--status pkg', "--status has no format 'pkg'"),
        ('--of 1 --status=text pkg', "--status takes no 'pkg'"),
        ('--status=xml', "no format 'xml'"),
        ('--restart', '--restart needs the NAME'),
        ('--lifecycle', '--lifecycle needs the NAME .* configure, activate'),
        ('--lifecycle a', '--lifecycle needs the NAME'),
        ('--lifecycle activate', '--lifecycle needs the NAME'),
        ('--lifecycle a activte', "no transition 'activte': .* 'activate'"),
        ('--lifecycle a b', "no transition 'b': it is one of configure, "),
        ('--lifecycle a shutdown --stop b', '--stop and --lifecycle exclude'),
        ('--stop a --restart b', '--stop and --restart exclude'),
        ('--stop a --attach b', '--stop and --attach exclude'),
        ('pkg file -f', '-f goes with --logs'),
        ('--stop a -f', '-f goes with --logs'),
        ('pkg file --of 12', '--of LAUNCH goes with'),
        ('--from-plan p --launch-prefix gdb', '--launch-prefix goes with'),
        (
            'a.yaml --until a(',
            r"--until: 'a\(' is no regular expression: miss",
        ),
        ('a.yaml --until=', '--until needs a regular expression'),
        ('a.yaml --timeout 5m', "seconds above 0, not '5m'"),
        ('a.yaml --for 0', "--for needs a number of seconds above 0, not '0'"),
        ('a.yaml --for inf', "seconds above 0, not 'inf'"),
        ('a.yaml --for 1 --timeout 2', '--for and --timeout exclude'),
        ('a.yaml --log-limit huge', "such as 500MB or 2GB, .* not 'huge'"),
        ('a.yaml --plan=xml', "--plan has no format 'xml'"),
    ],
)
def test_what_makes_no_sense_is_refused(line: str, text: str) -> None:
    with pytest.raises(UserError, match=text):
        parsed(line)


@pytest.mark.parametrize(
    ('asked', 'word', 'text'),
    [
        ('stop', '--all', r"--stop --of '\*' means all launches"),
        ('restart', '--all', r"--restart '\*' means all of a launch"),
        ('stop', '--forse', "no option '--forse': did you mean '--force'"),
        ('logs', '--folow', "no option '--folow': did you mean '--follow'"),
    ],
)
def test_an_option_that_does_not_exist_is_no_name(
    asked: str, word: str, text: str
) -> None:
    # colcon's parser takes them for names
    with pytest.raises(UserError, match=text):
        parse_launch_options(known(asked, [word]))
    with pytest.raises(UserError, match=r"--status --of '\*' means all"):
        parse_launch_options(known('positionals', ['--all'], '--status'))


def test_prefix_options_win_over_launch_arguments() -> None:
    options = parsed(
        'pkg file launch-prefix:=nice --launch-prefix gdb '
        '--launch-prefix-filter count.* x:=1'
    )
    assert options.arguments == {
        'launch-prefix': 'gdb',
        'launch-prefix-filter': 'count.*',
        'x': '1',
    }
