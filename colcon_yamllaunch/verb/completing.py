# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Completion of the verbs' command lines, by way of argcomplete.

argcomplete runs the command with a variable set. While the parser is made,
each argument gets a `completer`, which is asked for what may stand at the
cursor; then the process ends, before anything is run or written.
"""

import argparse
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
import os
from pathlib import Path
import sys
from types import TracebackType
from typing import Any, TYPE_CHECKING

from colcon_yamllaunch.common.errors import OutputError
from colcon_yamllaunch.common.files import text_of
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.messages import say
from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.verb.command_line import given_options, split_line
from colcon_yamllaunch.verb.options import Option, OPTIONS, REQUESTS, Verb
from colcon_yamllaunch.verb.target import (
    find_target,
    find_workspace,
    PATH_SUFFIXES,
)
from colcon_yamllaunch.workspace.colcon.package_scan import scan_packages
from colcon_yamllaunch.workspace.packages.build_files import source_programs
from colcon_yamllaunch.workspace.packages.launch_files import (
    find_launch_files,
    launch_file_names,
)
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator

if TYPE_CHECKING:
    from colcon_yamllaunch.language.evaluation.findings import DeclaredArgument

#: Each candidate with its description, which zsh shows.
Candidates = Mapping[str, str]


@dataclass(frozen=True, slots=True)
class Cursor:
    """
    Where something is to be completed.

    :param prefix: The word up to the cursor
    :param known: What the parser has made of the words in front
    :param parser: The parser of the verb
    """

    prefix: str
    known: Any
    parser: Any
    environment: Mapping[str, str]

    def given(self, key: str) -> Any:
        """Return what was given for an option in front, or None."""
        return getattr(self.known, key, None)

    def locator(self, words: Sequence[str] = ()) -> PackageLocator:
        """Return the packages; words may have the path of a launch file."""
        root = find_workspace(self.given('workspace') or None, words)
        return scan_packages(root, self.environment)


_Find = Callable[[Cursor], Candidates]


class _Completer:
    """
    Finds candidates for argcomplete.

    :param find: Finds what may stand at the cursor
    :param parser: The parser of the positionals that this is for, if it is
    """

    def __init__(
        self, find: _Find, environment: Mapping[str, str], parser: Any = None
    ) -> None:
        self._find = find
        self._environment = environment
        self._parser = parser

    def __call__(
        self, *, prefix: str, parsed_args: Any, parser: Any, **_: Any
    ) -> Candidates:
        # whatever is broken, Tab offers nothing rather than fail
        with suppress(Exception):
            cursor = Cursor(prefix, parsed_args, parser, self._environment)
            # shells would change words with control characters
            return {
                word: one_line(text)
                for word, text in self._find(cursor).items()
                if one_line(word) == word
            }
        return {}

    def __bool__(self) -> bool:
        # argcomplete asks for the first word, too, where the value of an
        # option is begun (--check=), and would take it for such a value
        word = _word_at_cursor(self._environment)
        known = getattr(self._parser, '_argcomplete_namespace', None)
        is_value = word.startswith('-') and '=' in word
        is_begun = bool(getattr(known, 'positionals', None))
        return self._parser is None or not is_value or is_begun


def complete(verb: Verb, parser: Any, environment: Mapping[str, str]) -> None:
    """
    Register the completers of the arguments of a verb.

    :param environment: The user's environment, with what argcomplete added
    """
    sys.excepthook = _report_output_error
    word = _word_at_cursor(environment)
    options = {option.key: option for option in OPTIONS[verb].all()}
    for action in parser._actions:
        option = options.get(action.dest)
        if option is not None:
            find = partial(_values, option)
            if option.arity == 'choice' and '=' not in word:
                # the next word is the package
                find = partial(_values, None)
            action.completer = _Completer(find, environment)
        if action.dest == 'positionals':
            find = partial(_positionals, verb)
            action.completer = _Completer(find, environment, parser)
        if action.option_strings and not word.startswith('-'):
            # dozens of options would hide the other candidates
            action.help = argparse.SUPPRESS


def _report_output_error(
    kind: type[BaseException],
    error: BaseException,
    trace: TracebackType | None,
) -> None:
    """Report in one line that argcomplete could not write its results."""
    if isinstance(error, OSError):
        say(f'colcon: error: {OutputError(error)}')
    else:
        sys.__excepthook__(kind, error, trace)


def _word_at_cursor(environment: Mapping[str, str]) -> str:
    line = environment.get('COMP_LINE', '')
    point = environment.get('COMP_POINT', '')
    if point.isdecimal():
        line = line[: int(point)]
    return line.rpartition(' ')[2]


def _positionals(verb: Verb, cursor: Cursor) -> Candidates:
    """Find words behind the package, which argparse leaves to the verb."""
    if verb == 'create':
        return paths(cursor.prefix, ()) if cursor.given('example') else {}
    if verb == 'run':
        words = [word for word in cursor.known.positionals if word != '--']
        if not words:
            return packages(cursor)
        return executables(cursor, words[0]) if len(words) == 1 else {}
    prefix = cursor.prefix
    options = OPTIONS[verb].by_flag()
    last = options.get((cursor.known.positionals or [''])[-1])
    name, equals, begun = prefix.partition('=')
    if prefix.startswith('-') and equals:
        found = _values(options[name], replace(cursor, prefix=begun))
        return {f'{name}={value}': text for value, text in found.items()}
    if prefix.startswith('-'):
        return _options(cursor)
    if last and last.value and last.arity in ('one', 'each', 'some'):
        return _values(last, cursor)
    _give_back(cursor.known, OPTIONS[verb].all())
    values, words, arguments = split_line(cursor.known, verb)
    words = [word for word in words if not word.startswith('-')]
    cursor = replace(cursor, known=values)
    given = given_options(values, verb)
    if '--status' in given or '--from-plan' in given:
        return {}
    for request in given.keys() & {*REQUESTS, '--timeline'}:
        return _values(given[request], cursor, words)
    # the package, then its launch file, then launch arguments
    if not words:
        return packages(cursor) or paths(prefix, PATH_SUFFIXES)
    if len(words) == 1 and not os.path.isfile(Path(words[0]).expanduser()):
        return launch_files(cursor, words[0])
    return launch_arguments(cursor, tuple(words), arguments)


def _give_back(known: Any, options: Iterable[Option[Any]]) -> None:
    """Make a positional of the word that argparse took for a choice."""
    for option in options:
        if option.arity == 'choice':
            word = getattr(known, option.key)
            if word not in (None, *option.choices):
                known.positionals = [word, *known.positionals]
                setattr(known, option.key, option.choices[0])


def _options(cursor: Cursor) -> Candidates:
    formatter = cursor.parser._get_formatter()
    return {
        option: formatter._expand_help(action)
        for option, action in cursor.parser._option_string_actions.items()
    }


def _values(
    option: Option[Any] | None, cursor: Cursor, words: Sequence[str] = ()
) -> Candidates:
    """
    Return the values of an option.

    :param words: The words in front that belong to no option
    """
    if option is None or option.value is None:
        return {}
    if option.choices:
        return dict.fromkeys(option.choices, '')
    match option.value.completer:
        case 'nothing':
            return {}
        case 'files':
            return paths(cursor.prefix, ('',))
        case 'folders':
            return paths(cursor.prefix, ())
        case 'hosts':
            return hosts(cursor)
        case 'profiles':
            return profiles(cursor)
        case 'packages':
            return packages(cursor)
        case 'licenses':
            from colcon_yamllaunch.workspace.create import new_package

            return dict.fromkeys(new_package.LICENSES, '')
        case 'places':
            from shutil import which

            return {'slurm:': 'array jobs'} if which('sbatch') else {}
        case completer:
            from colcon_yamllaunch.verb import process_candidates

            return process_candidates.candidates_of(cursor, completer, words)


def packages(cursor: Cursor) -> Candidates:
    """Return the packages whose names start with the word."""
    names = cursor.locator().names()
    return {n: '' for n in names if n.startswith(cursor.prefix)}


def launch_files(cursor: Cursor, package: str) -> Candidates:
    """Return a package's launch files: names, or paths if one is begun."""
    locator = cursor.locator([package])
    own = locator.package(package)
    folder = locator.share(package) if own is None else own.path
    files = () if folder is None else find_launch_files(Path(folder))
    if '/' in cursor.prefix:
        return dict.fromkeys(files, '')
    return dict.fromkeys(launch_file_names(package, files), '')


def executables(cursor: Cursor, package: str) -> Candidates:
    """Return the programs that a package has installed, or will install."""
    locator = cursor.locator()
    names = set(locator.executables(package))
    own = locator.package(package)
    if own is not None:
        names |= source_programs(own.path).names
    return dict.fromkeys(sorted(names), '')


def paths(prefix: str, suffixes: Sequence[str]) -> Candidates:
    """
    Return folders, and files with given endings.

    :raises OSError: when the folder cannot be read
    """
    head = prefix[: prefix.rfind('/') + 1]
    begun = prefix[len(head) :]
    found = []
    with os.scandir(Path(head or '.').expanduser()) as entries:
        for entry in entries:
            name = entry.name
            if name.startswith('.') and not begun:
                continue
            if entry.is_dir():
                found.append(f'{head}{name}/')
            elif name.endswith(tuple(suffixes)):
                found.append(head + name)
    return dict.fromkeys(sorted(found), '')


def hosts(cursor: Cursor) -> Candidates:
    """Return the hosts that ssh knows, or the machines of `--deploy`."""
    deployment = cursor.given('deploy')
    if deployment:
        # it is read for this only
        from colcon_yamllaunch.deployment.deployment_file import (
            read_deployment,
        )

        return dict.fromkeys(read_deployment(deployment).machines, '')
    # there may be a user in front of the host
    user, at, _ = cursor.prefix.rpartition('@')
    return {f'{user}{at}{name}': '' for name in sorted({*_ssh_hosts()})}


def profiles(cursor: Cursor) -> Candidates:
    """Return the profiles of the file of `--deploy`."""
    deployment = cursor.given('deploy')
    if not deployment:
        return {}
    from colcon_yamllaunch.deployment.deployment_file import read_deployment

    return dict.fromkeys(read_deployment(deployment).profiles, '')


def _ssh_hosts() -> Iterator[str]:
    """Return the hosts of the configuration of ssh, and those it knows."""
    folder = Path.home() / '.ssh'
    for line in text_of(folder / 'config').splitlines():
        # ssh_config(5)
        key, *names = line.replace('=', ' ', 1).split() or ['']
        if key.lower() == 'host':
            yield from (n for n in names if not set(n) & set('*?!"'))
    for line in text_of(folder / 'known_hosts').splitlines():
        known, *_ = line.split() or ['']
        # some are hashed
        if not known.startswith(('#', '|', '@')):
            # hosts with a port stand in brackets
            yield from (n for n in known.split(',') if n and n[0] not in '[!*')


def launch_arguments(
    cursor: Cursor, positionals: tuple[str, ...], given: Sequence[str]
) -> Candidates:
    """
    Return the launch arguments, or the values of the one that is begun.

    :param positionals: A package and a launch file, or the path of one
    :param given: The launch arguments in front
    :raises UserError: when there is no such launch file
    :raises LaunchError: when a launch file has mistakes
    """
    # reading launch files takes longer to import than all else
    from colcon_yamllaunch.language.actions.handlers import BOOLEAN_CHOICES
    from colcon_yamllaunch.language.evaluation.request import Request
    from colcon_yamllaunch.language.policies.check import find_declarations
    from colcon_yamllaunch.workspace.workspace_session import LaunchPackages

    locator = cursor.locator(positionals)
    cwd = Path.cwd()
    target = find_target(positionals, cwd, locator)
    values = dict(word.split(':=', 1) for word in given)
    known = LaunchPackages(locator, built=False)
    located = known.locate(target.name)
    request = Request(
        target.path if located is None else located[0],
        target.path,
        packages=known,
        environment=cursor.environment,
        arguments=values,
        cwd=str(cwd),
        exposed=lambda: locator.exposed,
    )
    arguments = find_declarations(request).arguments
    name, is_begun, _ = cursor.prefix.partition(':=')
    if is_begun:
        return {
            f'{name}:={choice}': ''
            for argument in arguments
            if argument.name == name
            for choice in argument.choices
            # of the ways to write a boolean, two will do
            if argument.choices != BOOLEAN_CHOICES
            or choice in ('true', 'false')
        }
    return {
        f'{argument.name}:=': _described(argument)
        for argument in arguments
        # where the launch file sets it, the command line does not count
        if argument.name not in values and argument.set_at is None
    }


def _described(argument: 'DeclaredArgument') -> str:
    default = argument.default
    value = 'required' if default is None else f"default: '{default}'"
    text = f'{argument.description or ""} ({value})'
    return ' '.join(text.split())
