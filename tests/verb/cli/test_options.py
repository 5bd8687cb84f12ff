# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Each option is described once, and all that is made from that knows it."""

from itertools import combinations
from pathlib import Path
import re
from typing import Any, get_args

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.verb.command_line import refuse_unknown
from colcon_yamllaunch.verb.options import (
    EXCLUSIVE,
    LaunchOptions,
    Option,
    OPTIONS,
    Verb,
)
import pytest
from support.command_lines import launch_options as parsed
from support.user import User

ROOT = Path(__file__).parents[3]
VERBS: tuple[Verb, ...] = get_args(Verb)
EVERY = [
    pytest.param(title, verb, option, id=f'{verb}{option.name}')
    for verb, options in OPTIONS.items()
    for title, section in options.sections()
    for option in section
]
LAUNCH = LaunchOptions.by_flag()


@pytest.fixture(scope='module')
def page() -> dict[str, str]:
    """Return what docs/options.md says of each verb."""
    text = (ROOT / 'docs/options.md').read_text(encoding='utf-8')
    _, *parts = re.split(r'^## colcon (\w+)$', text, flags=re.MULTILINE)
    return dict(zip(parts[::2], parts[1::2], strict=True))


def written(option: Option[Any]) -> str:
    """Return how an option may be typed."""
    if option.value is None:
        return option.name
    words = {'SECONDS': '1', 'SIZE': '1MB'}
    choices = option.choices or (words.get(option.value.name or '', 'x'),)
    return f'{option.name}={choices[0]}'


@pytest.mark.parametrize(('title', 'verb', 'option'), EVERY)
def test_options_are_described(
    title: str, verb: Verb, option: Option[Any], page: dict[str, str]
) -> None:
    assert title
    assert option.help
    assert not option.help.endswith('.')
    (row,) = re.findall(
        rf'^\| [^`]*`[^`]*{option.name}\b(?!-).*$', page[verb], re.M
    )
    assert option.help.split('%')[0][:40] in row


@pytest.mark.parametrize('verb', VERBS)
def test_options_of_a_verb_have_names_of_their_own(verb: Verb) -> None:
    flags = [
        flag
        for _, options in OPTIONS[verb].sections()
        for option in options
        for flag in option.flags
    ]
    assert sorted(flags) == sorted(OPTIONS[verb].by_flag())


@pytest.mark.parametrize(('title', 'verb', 'option'), EVERY)
def test_options_refer_to_options(
    title: str, verb: Verb, option: Option[Any]
) -> None:
    known = {known.name for v in VERBS for known in OPTIONS[v].all()}
    assert {*option.excludes, *option.needs} <= known - {option.name}
    assert {name for group in EXCLUSIVE for name in group} <= known


@pytest.mark.parametrize(
    'option',
    LaunchOptions.all(),
    ids=lambda option: option.name,
)
def test_launch_reads_its_options(option: Option[Any]) -> None:
    words = [written(LAUNCH[n]) for n in (option.name, *option.needs[:1])]
    if option.name == '--lifecycle':
        words.append('activate')
    # these take nothing else to launch
    alone = {
        *('--from-plan', '--demo', '--lifecycle', '--status'),
        '--remove-service',
    }
    if alone.isdisjoint((option.name, *option.needs[:1])):
        words += ['pkg', 'file']
    assert parsed(*words) != parsed('pkg', 'file')


EXCLUDING = [
    *(
        (one.name, other)
        for one in LaunchOptions.all()
        for other in one.excludes
    ),
    *(pair for group in EXCLUSIVE for pair in combinations(group, 2)),
]


@pytest.mark.parametrize(
    'names',
    [pair for pair in EXCLUDING if LAUNCH.keys() >= {*pair}],
    ids=' '.join,
)
def test_excluded_options_are_refused(names: tuple[str, str]) -> None:
    for pair in (names, names[::-1]):
        with pytest.raises(UserError) as caught:
            parsed(*(written(LAUNCH[name]) for name in pair))
        assert names[0] in str(caught.value)


@pytest.mark.parametrize(
    'option',
    [option for option in LaunchOptions.all() if option.needs],
    ids=lambda option: option.name,
)
def test_options_that_need_another_are_refused(option: Option[Any]) -> None:
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
        ('--zzz', "'colcon launch --help-all' lists the options"),
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
    error = f"'colcon {verb}' has no option '--watch': 'colcon launch' has it"
    with pytest.raises(UserError, match=error):
        refuse_unknown(['--watch=bell', 'pkg'], verb)
