# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Each option is described once, and all that is made from that knows it."""

import argparse
from dataclasses import fields
from pathlib import Path
import re
from typing import get_args

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.verb.cli.create_options import CreateOptions
from colcon_yamllaunch.verb.cli.launch_options import LaunchOptions
from colcon_yamllaunch.verb.cli.launch_options import parse_launch_options
from colcon_yamllaunch.verb.cli.option_parser import add_options
from colcon_yamllaunch.verb.cli.option_parser import read_options
from colcon_yamllaunch.verb.cli.option_parser import READERS
from colcon_yamllaunch.verb.cli.option_parser import refuse_unknown
from colcon_yamllaunch.verb.cli.option_table import Completer
from colcon_yamllaunch.verb.cli.option_table import Kind
from colcon_yamllaunch.verb.cli.option_table import Option
from colcon_yamllaunch.verb.cli.option_table import options_of
from colcon_yamllaunch.verb.cli.option_table import SECTIONS
from colcon_yamllaunch.verb.cli.option_table import Verb
from colcon_yamllaunch.verb.cli.sweep_options import SweepOptions
from colcon_yamllaunch.verb.completion.completing import COMPLETERS
from colcon_yamllaunch.verb.launching.run_flow import RunOptions
import pytest
from support.user import User

ROOT = Path(__file__).parents[3]
VERBS: tuple[Verb, ...] = get_args(Verb)
EVERY = [
    pytest.param(section.title, verb, option, id=f'{verb}{option.name}')
    for section in SECTIONS
    for verb in section.verbs
    for option in section.options
]
#: A value of each kind.
VALUES: dict[Kind, str] = {
    'text': 'x',
    'count': '3',
    'file': 'x',
    'metric': 'x=(y)',
    'path': 'x',
    'pattern': 'x',
    'place': 'slurm:time=1',
    'seconds': '1',
    'share': '95%',
    'size': '1MB',
    'words': 'x y',
}


@pytest.fixture(scope='module')
def page() -> dict[str, str]:
    """Return what docs/options.md says of each verb."""
    text = (ROOT / 'docs/options.md').read_text(encoding='utf-8')
    _, *parts = re.split(r'^## colcon (\w+)$', text, flags=re.MULTILINE)
    return dict(zip(parts[::2], parts[1::2], strict=True))


def written(option: Option) -> str:
    """Return how an option may be typed."""
    if option.value is None:
        return option.name
    choices = option.value.choices or (VALUES[option.value.kind],)
    return f'{option.name}={choices[0]}'


def parsed(*words: str) -> LaunchOptions:
    parser = argparse.ArgumentParser()
    parser.add_argument('positionals', nargs=argparse.REMAINDER)
    add_options(parser, 'launch')
    return parse_launch_options(parser.parse_args(words))


@pytest.mark.parametrize('word', ['--stop=--', '--check=--', '--for=--'])
def test_separator_is_no_value(
    word: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr('sys.argv', ['colcon', 'launch', 'a.yaml', word])
    with pytest.raises(UserError, match="takes no value '--'"):
        read_options(argparse.Namespace(), 'launch')
    monkeypatch.setattr('sys.argv', ['colcon', 'run', 'p', 'x', word])
    assert read_options(argparse.Namespace(), 'run') == {}


@pytest.mark.parametrize(('title', 'verb', 'option'), EVERY)
def test_options_are_described(
    title: str, verb: Verb, option: Option, page: dict[str, str]
) -> None:
    assert title
    assert option.help
    assert not option.help.endswith('.')
    assert option.name.startswith('--')
    assert option.value is None or option.value.completer in get_args(
        Completer
    )
    (row,) = re.findall(
        rf'^\| `[^`]*{option.name}\b(?!-).*$', page[verb], re.M
    )
    assert option.help.split('%')[0][:40] in row


@pytest.mark.parametrize('verb', VERBS)
def test_options_of_a_verb_have_names_of_their_own(verb: Verb) -> None:
    flags = [
        flag
        for section in SECTIONS
        if verb in section.verbs
        for option in section.options
        for flag in (option.short, option.name)
        if flag is not None
    ]
    assert sorted(flags) == sorted(options_of(verb))


@pytest.mark.parametrize(('title', 'verb', 'option'), EVERY)
def test_options_refer_to_options(
    title: str, verb: Verb, option: Option
) -> None:
    known = {known.name for v in VERBS for known in options_of(v).values()}
    assert {*option.excludes, *option.needs} <= known - {option.name}


def test_completers_and_kinds_are_all_there() -> None:
    assert {*COMPLETERS, 'choices'} == set(get_args(Completer))
    assert set(READERS) == set(get_args(Kind)) == set(VALUES)


@pytest.mark.parametrize('verb', ['run', 'create', 'sweep'])
def test_verbs_read_their_options(verb: Verb) -> None:
    read = {
        'run': RunOptions,
        'create': CreateOptions,
        'sweep': SweepOptions,
    }[verb]
    # the arguments that these stand for are among the others
    prefixes = {'launch_prefix', 'launch_prefix_filter', 'version'}
    keys = {option.key for option in options_of(verb).values()}
    assert keys - {field.name for field in fields(read)} <= prefixes


@pytest.mark.parametrize(
    'option',
    list(options_of('launch').values()),
    ids=lambda option: option.name,
)
def test_launch_reads_its_options(option: Option) -> None:
    """A field of another name would be an unexpected argument."""
    options = options_of('launch')
    words = [written(options[n]) for n in (option.name, *option.needs[:1])]
    if option.name == '--lifecycle':
        words.append('activate')
    # these take nothing else to launch
    if {'--from-plan', '--lifecycle', '--status'}.isdisjoint(
        (option.name, *option.needs)
    ):
        words += ['pkg', 'file']
    assert parsed(*words) != parsed('pkg', 'file')


@pytest.mark.parametrize(
    ('one', 'other'),
    [
        pytest.param(one, other, id=f'{one.name} {name}')
        for one in options_of('launch').values()
        for name in one.excludes
        for other in (options_of('launch')[name],)
    ],
)
def test_excluded_options_are_refused(one: Option, other: Option) -> None:
    for pair in ((one, other), (other, one)):
        with pytest.raises(UserError) as caught:
            parsed(*map(written, pair))
        assert one.name in str(caught.value)


@pytest.mark.parametrize(
    'option',
    [option for option in options_of('launch').values() if option.needs],
    ids=lambda option: option.name,
)
def test_options_that_need_another_are_refused(option: Option) -> None:
    with pytest.raises(UserError, match='goes with'):
        parsed('pkg', 'file', written(option))


@pytest.mark.parametrize(
    'words',
    [
        ['launch', '--version'],
        ['launch', 'pkg', 'file', '--version'],
        ['run', '--version'],
        ['create', '--version'],
        ['sweep', 'pkg', 'file', '--version'],
    ],
)
def test_version_is_shown_alone(user: User, words: list[str]) -> None:
    before = list(user.root.iterdir())
    shown = user.start('colcon', *words)
    assert shown.end() == 0
    assert re.fullmatch(
        r'colcon-yamllaunch [\d.]+, colcon-core [\d.]+\n', shown.output
    )
    assert list(user.root.iterdir()) == before


@pytest.mark.parametrize(
    ('words', 'hint'),
    [
        ('--unit fahrenheit', "did you mean 'unit:=fahrenheit' or '--junit'?"),
        ('--chekc', "did you mean '--check'?"),
        ('--zzz', "'colcon launch --help' lists the options"),
    ],
)
def test_an_unknown_option_may_be_meant_as_an_argument(
    words: str, hint: str
) -> None:
    with pytest.raises(UserError) as error:
        parsed('pkg', 'file.yaml', *words.split())
    assert str(error.value).endswith(hint)


@pytest.mark.parametrize('verb', ['run', 'create', 'sweep'])
def test_an_option_of_a_launch_is_none_of_other_verbs(verb: Verb) -> None:
    error = f"'colcon {verb}' has no option '--watch': it is one of 'colcon l"
    with pytest.raises(UserError, match=error):
        refuse_unknown(['--watch=bell', 'pkg'], verb)
