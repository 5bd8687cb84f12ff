# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Which words of `colcon run` are ours, read by colcon's own parser."""

from collections.abc import Callable, Iterator
import os
from pathlib import Path
from typing import Any

from colcon_core import location
from colcon_core.argument_parser import SuppressUsageOutput
from colcon_core.command import (
    add_parser_arguments,
    add_parsers_without_arguments,
    create_parser,
    create_subparser,
)
from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.verb import argv
from colcon_yamllaunch.verb.argv import rewritten
from colcon_yamllaunch.verb.command_line import (
    parse_run_options,
    program_index,
)
from colcon_yamllaunch.verb.options import RunOptions
from colcon_yamllaunch.verb.run import RunVerb
from hypothesis import example, given
from hypothesis import strategies as st
import pytest

Parse = Callable[..., RunOptions]


def parser_of(verb: RunVerb) -> tuple[Any, Any]:
    """Make colcon's parser for the verb alone, and that of the verb."""
    parser = create_parser('colcon_core.environment_variable')
    verbs = {'run': verb}
    subparser = create_subparser(
        parser, 'colcon', verbs, attribute='verb_name'
    )
    parsers = add_parsers_without_arguments(
        parser, subparser, verbs, attribute='verb_name'
    )
    return parser, parsers['run']


@pytest.fixture(scope='module')
def parse() -> Iterator[Parse]:
    """Parse a command line in the two steps that colcon does it in."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv('COLCON_LOG_PATH', os.devnull)
        patch.setenv('COLCON_DEFAULTS_FILE', os.devnull)
        # where colcon-mixin looks; the command sets it first of all
        patch.setattr(location, '_config_path', Path(os.devnull))
        verb = RunVerb()
        verb.VERB_NAME = 'run'
        first, nested = parser_of(verb)
        second, own = parser_of(verb)
        add_parser_arguments(own, verb)

        def parse_words(*words: str) -> RunOptions:
            with SuppressUsageOutput([first, nested]):
                first.parse_known_args(args=['run', *words])
            return parse_run_options(second.parse_args(args=['run', *words]))

        yield parse_words


def error_of(parse: Parse, *words: str) -> str:
    with pytest.raises(UserError) as caught:
        parse(*words)
    return str(caught.value)


WORDS = st.lists(
    st.text(st.characters(blacklist_characters='\0', blacklist_categories='C'))
    | st.sampled_from(
        ['--', '-h', '--help', '--log', '--prefix', '--build', '', '-p', '-']
    ),
    max_size=6,
)


@given(arguments=WORDS)
@example(arguments=['-height', '5'])
@example(arguments=['--log=x', '--help=y', '--', '--'])
@example(arguments=['--ros-args', '-p', 'my_array:=[1.0,2.0]'])
def test_words_of_the_program_arrive_as_given(
    parse: Parse, arguments: list[str]
) -> None:
    options = parse('--no-build', 'my_pkg', 'node', *arguments)
    assert options.arguments == tuple(arguments)
    assert (options.package, options.executable) == ('my_pkg', 'node')
    assert options.no_build
    assert options.prefix == ()


def test_options_stand_in_front_of_the_package(parse: Parse) -> None:
    options = parse(
        *('--prefix', 'gdb -ex "run now" --args', '--build-args'),
        *(
            '--merge-install',
            '--workspace=/ws',
            'my_pkg',
            'node',
            '--no-build',
        ),
    )
    assert options.prefix == ('gdb', '-ex', 'run now', '--args')
    assert options.build_args == ('--merge-install',)
    assert str(options.workspace) == '/ws'
    assert not options.no_build
    assert options.arguments == ('--no-build',)


def test_paths_end_at_two_dashes(parse: Parse) -> None:
    options = parse('--paths', 'src/a', 'src/b', '--', 'my_pkg', 'node', '--')
    assert options.paths == ('src/a', 'src/b')
    assert options.arguments == ('--',)
    message = error_of(parse, '--paths', 'src/a', 'my_pkg', 'node')
    assert "put '--' after the paths" in message


def test_executable_may_be_left_out(parse: Parse) -> None:
    assert parse('my_pkg').executable is None


@pytest.mark.parametrize(
    ('words', 'message'),
    [
        ([], 'there is nothing to run'),
        (['--nobuild', 'a', 'b'], "did you mean '--no-build'?"),
        (['a', '--no-build', 'b'], 'options stand in front of the package'),
        (['--prefix', '"gdb', 'a', 'b'], '--prefix has an open quote'),
        (['--no-build', '--build-all', 'a', 'b'], 'exclude one another'),
    ],
)
def test_wrong_words_are_refused(
    parse: Parse, words: list[str], message: str
) -> None:
    assert message in error_of(parse, *words)


@pytest.mark.parametrize(
    'words',
    [
        ['launch', 'a', 'run', 'b', '-x'],
        ['--log-base', 'run', 'build', '--paths', 'a'],
        ['--help'],
        [],
        ['run'],
        ['run', '--', 'a', 'b', '-x'],
    ],
)
def test_other_command_lines_stay_as_they_are(words: list[str]) -> None:
    assert rewritten(words) == words


def test_separation_is_done_once() -> None:
    words = ['--log-level', 'info', 'run', '--prefix', 'a', 'b', 'c', '-x']
    once = rewritten(words)
    assert once == [*words[:5], '--', 'b', 'c', '-x']
    assert rewritten(once) == once
    assert program_index(words[3:]) == 2


def test_parsers_that_others_decorate_are_real_ones() -> None:
    # colcon-argcomplete hands what it decorates to argcomplete
    parser = create_parser('colcon_core.environment_variable')
    assert type(parser).__module__ == argv.__name__
    inner = parser._parser
    while hasattr(inner, '_decoree'):
        assert type(inner).__module__ != argv.__name__
        inner = inner._decoree
