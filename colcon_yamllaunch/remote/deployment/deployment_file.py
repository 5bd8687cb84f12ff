# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The deployment file of `--deploy`: the machines, and which processes they run.

It is read like a launch file: each problem has its position, and all problems
are reported at once.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
import math
import os.path
import posixpath
import re
import shlex
from typing import Any, get_args

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.suggestions import did_you_mean, one_of
from colcon_yamllaunch.language.syntax import yaml_reader
from colcon_yamllaunch.language.syntax.diagnostics import (
    Diagnostic,
    error,
    LaunchError,
)
from colcon_yamllaunch.language.syntax.source_text import read_source, Source
from colcon_yamllaunch.language.syntax.yaml_reader import Scalar, Value
from colcon_yamllaunch.remote.deployment.deployment import (
    Deployment,
    HERE,
    Kind,
    Machine,
    OnLost,
    PlacementRule,
    Sync,
)

#: Stands before the options of an allocation in `--on`.
SLURM = 'slurm:'

_KINDS: tuple[Kind, ...] = get_args(Kind)
#: The range of `lost_after` (seconds).
_LOST_AFTER = (0.1, 3600.0)
_MATCH_KEYS = ('name', 'package', 'executable')
# it stands in labels, in names of files and on command lines
_NAME = re.compile(r'[A-Za-z0-9][A-Za-z0-9_.-]{0,62}')
_VARIABLE = re.compile(r'[A-Za-z_][A-Za-z0-9_]*')

_Pairs = Mapping[str, tuple[Scalar, Value]]


def read_deployment(path: str) -> Deployment:
    """
    Read a deployment file.

    :raises LaunchError: when it cannot be read, or is wrong
    """
    return deployment_of(read_source(path, path, 'deployment file'))


def deployment_of(source: Source) -> Deployment:
    """
    Return the deployment that a file describes.

    :raises LaunchError: when it is wrong
    """
    return _Reader().read(yaml_reader.read_yaml(source), source)


def deployed_on(word: str, deployment: Deployment | None = None) -> Deployment:
    """
    Return the deployment that runs everything on one machine.

    :param word: What follows `--on`: a destination as ssh takes it,
      `slurm:` with options of an allocation, or the name of a machine of
      `deployment` if there is one
    :raises UserError: when it is none of these
    """
    if deployment is not None:
        if word not in deployment.machines:
            hint = one_of(word, sorted(deployment.machines))
            raise UserError(
                f"--on: there is no machine '{word}' in the deployment file: "
                f'{hint}'
            )
        return Deployment(deployment.machines, everything_on=word)
    if word == SLURM.rstrip(':') or word.startswith(SLURM):
        options = word.removeprefix(SLURM).removeprefix('slurm').split(',')
        words = tuple(f'--{o.lstrip("-")}' for o in options if o)
        return _only(Machine('slurm', 'slurm', words))
    reason = _wrong_destination(word)
    if reason is not None:
        raise UserError(f'--on takes USER@HOST as ssh does: {reason}')
    return _only(Machine(_host_of(word), 'ssh', (word,)))


def _only(machine: Machine) -> Deployment:
    return Deployment({machine.name: machine}, everything_on=machine.name)


def _host_of(destination: str) -> str:
    """Return the host of a destination, fit to be the name of a machine."""
    host = destination.removeprefix('ssh://').rpartition('@')[2]
    if destination.startswith('ssh://'):
        host = re.sub(r':\d+$', '', host.rstrip('/'))
    name = re.sub('[^A-Za-z0-9_.-]', '-', host).strip('-.')
    return name[:63] or 'host'


def _wrong_destination(word: str) -> str | None:
    """Return why a word is no destination of ssh, or None if it is one."""
    if not word.strip():
        return 'this one is empty'
    if word.startswith('-'):
        # ssh would take it for an option, which may run commands here
        return f"'{word}' begins with a dash"
    if any(c.isspace() or not c.isprintable() for c in word):
        return (
            f'{word!r} is more than one word; options such as a port belong '
            'into ~/.ssh/config'
        )
    return None


class _Reader:
    """A reader of one file, which collects its problems."""

    def __init__(self) -> None:
        self._found: list[Diagnostic] = []

    def read(self, document: Value | None, source: Source) -> Deployment:
        if document is None:
            raise error(
                'the deployment file is empty',
                source.position(0, 0),
                hint='see docs/machines.md for what it says',
            )
        machines: dict[str, Machine] = {}
        rules: list[PlacementRule] = []
        pairs = self._pairs(document, 'the deployment file')
        known = ('machines', 'processes', 'defaults')
        with self._collected():
            self._check_keys(pairs, known, 'the file')
        with self._collected():
            machines = self._machines(pairs, document)
        with self._collected():
            if 'processes' in pairs:
                # also those with problems
                _, listed = pairs.get('machines', (None, None))
                names: list[str] = []
                if isinstance(listed, yaml_reader.Mapping):
                    names = list(listed.pairs)
                rules = self._rules(pairs['processes'][1], names)
        if self._found:
            raise LaunchError(*self._found)
        return Deployment(machines, tuple(rules))

    @contextmanager
    def _collected(self) -> Iterator[None]:
        """Collect the problems of the body, and go on behind it."""
        try:
            yield
        except LaunchError as e:
            self._found.extend(e.diagnostics)

    def _machines(self, pairs: _Pairs, document: Value) -> dict[str, Machine]:
        if 'machines' not in pairs:
            raise error(
                "the deployment file has no 'machines'",
                document.position,
                hint='machines: {arm: {ssh: robot@arm.local}}',
            )
        listed = self._pairs(pairs['machines'][1], "'machines'")
        defaults: dict[str, Any] = {}
        if 'defaults' in pairs:
            with self._collected():
                given = self._pairs(pairs['defaults'][1], "'defaults'")
                defaults = self._given(given)
                self._check_keys(given, tuple(_READERS), "'defaults'")
        machines: dict[str, Machine] = {}
        for name, (key, value) in listed.items():
            with self._collected():
                _check_name(name, key)
                machines[name] = self._machine(name, key, value, defaults)
        return machines

    def _machine(
        self,
        name: str,
        key: Scalar,
        value: Value,
        defaults: Mapping[str, Any],
    ) -> Machine:
        if isinstance(value, Scalar) and value.kind != 'null':
            pairs: _Pairs = {'ssh': (key, value)}
        else:
            pairs = self._pairs(value, f"the machine '{name}'")
        with self._collected():
            self._check_keys(pairs, (*_KINDS, *_READERS), 'a machine')
        kinds = [kind for kind in _KINDS if kind in pairs]
        if not kinds:
            raise error(
                f"it is not said how the machine '{name}' is reached",
                key,
                hint='say how it is reached: ssh: USER@HOST, slurm: '
                '[--partition=NAME], or connect: COMMAND',
            )
        if len(kinds) > 1:
            raise error(
                f"the machine '{name}' has both '{kinds[0]}' and '{kinds[1]}'",
                pairs[kinds[1]][0],
                hint='a machine is reached in one way: remove one',
            )
        kind = kinds[0]
        words: tuple[str, ...] = ()
        with self._collected():
            words = _WORDS[kind](pairs[kind][1])
        given = {**defaults, **self._given(pairs)}
        return Machine(name, kind, words, position=key.position, **given)

    def _given(self, pairs: _Pairs) -> dict[str, Any]:
        """Return the settings of a machine."""
        given: dict[str, Any] = {}
        for field, read in _READERS.items():
            if field in pairs:
                with self._collected():
                    given[field] = read(pairs[field][1])
        if 'env' in given:
            given['env'], given['values'] = given['env']
        return given

    def _rules(
        self, value: Value, names: Sequence[str]
    ) -> list[PlacementRule]:
        hint = 'processes: [{match: NAME, machine: MACHINE}]'
        if not isinstance(value, yaml_reader.Sequence):
            raise error("'processes' is not a list", value.position, hint=hint)
        rules = []
        for item in value.items:
            with self._collected():
                rules.append(self._rule(item, names))
        return rules

    def _rule(self, item: Value, names: Sequence[str]) -> PlacementRule:
        pairs = self._pairs(item, 'a rule')
        self._check_keys(pairs, ('match', 'machine'), 'a rule')
        for field in ('match', 'machine'):
            if field not in pairs:
                hint = '{match: NAME, machine: MACHINE}'
                message = f"this rule has no '{field}'"
                raise error(message, item.position, hint=hint)
        value = pairs['machine'][1]
        machine = _text(value, "'machine'", 'machine: NAME')
        known = [*names, HERE]
        if machine not in known:
            message = f"there is no machine '{machine}'"
            raise _error(message, value, one_of(machine, known))
        value = pairs['match'][1]
        if not isinstance(value, yaml_reader.Mapping):
            name = _pattern(value, "'match'")
            return PlacementRule(
                machine, value.position, name, length=len(name)
            )
        self._check_keys(value.pairs, _MATCH_KEYS, "'match'")
        if not value.pairs:
            hint = 'match: NAME, or match: {package: NAME}'
            raise _error("'match' says nothing to match", value, hint)
        given: dict[str, Any] = {
            field: _pattern(pattern, f"'{field}'")
            for field, (_, pattern) in value.pairs.items()
        }
        return PlacementRule(machine, value.position, **given)

    def _pairs(self, value: Value, what: str) -> _Pairs:
        if not isinstance(value, yaml_reader.Mapping):
            raise error(f'{what} is not a mapping', value.position)
        return value.pairs

    def _check_keys(
        self, pairs: _Pairs, known: Sequence[str], where: str
    ) -> None:
        wrong = [
            Diagnostic(
                'error',
                f"{where} has no key '{name}'",
                key.position,
                did_you_mean(name, known) or f'there are {", ".join(known)}',
                key.length,
            )
            for name, (key, _) in pairs.items()
            if name not in known
        ]
        if wrong:
            raise LaunchError(*wrong)


def _check_name(name: str, key: Scalar) -> None:
    if name == HERE:
        hint = f"'{HERE}' is the computer that the launch is begun on"
        raise error(f"no machine is called '{HERE}'", key, hint=hint)
    if _NAME.fullmatch(name) is None:
        raise error(
            f"'{name}' is no name for a machine",
            key,
            hint='it has letters, digits, dots, dashes and underscores, at '
            'most 63, and begins with a letter or digit',
        )


def _error(message: str, value: Value, hint: str) -> LaunchError:
    """Return an error that underlines a scalar, or the start of others."""
    span = value if isinstance(value, Scalar) else value.position
    return error(message, span, hint=hint)


def _text(value: Value, what: str, hint: str) -> str:
    """
    Return a text that is not empty, of one line.

    :param what: Names the value in errors
    :raises LaunchError: when it is something else
    """
    if not isinstance(value, Scalar):
        raise _error(f'{what} is not a text', value, hint)
    if value.kind == 'null' or not value.text.strip():
        raise _error(f'{what} is empty', value, hint)
    if not value.text.isprintable():
        raise _error(f'{what} is not a text of one line', value, hint)
    return value.text


def _pattern(value: Value, what: str) -> str:
    return _text(value, what, 'a name, or a pattern with *, ? and […]')


def _choice(value: Value, key: str, choices: Sequence[str]) -> str:
    """Return one of some words."""
    hint = f'it is one of {", ".join(choices)}'
    text = _text(value, f"'{key}'", hint)
    if text not in choices:
        message = f"'{key}' has no value '{text}'"
        raise _error(message, value, did_you_mean(text, choices) or hint)
    return text


def _seconds(value: Value) -> float:
    shortest, longest = _LOST_AFTER
    hint = f'a number of seconds from {shortest:g} to {longest:g}: 0.5'
    text = _text(value, "'lost_after'", hint)
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not shortest <= seconds <= longest:
        raise _error(f"'lost_after' has no value '{text}'", value, hint)
    return seconds


def _workspace(value: Value) -> str:
    hint = 'an absolute path, or one that begins in the home folder: ~/ws'
    text = _text(value, "'workspace'", hint)
    if text.startswith('~') and not text.startswith('~/') and text != '~':
        message = f"'{text}' begins in the home folder of somebody else"
        raise _error(message, value, hint)
    if not text.startswith(('/', '~')):
        # as scp and rsync read the path behind a colon
        text = f'~/{text}'
    top, below = ('~/', text[2:]) if text.startswith('~') else ('/', text)
    path = posixpath.normpath(below or '.').lstrip('/')
    if path in ('', '.', '..') or path.startswith('../'):
        message = f"'{text}' is no folder for a workspace"
        raise _error(message, value, hint)
    return top + path


def _variables(
    value: Value,
) -> tuple[tuple[str, ...], tuple[tuple[str, str], ...]]:
    """Return the names of variables to send, and those with values."""
    hint = (
        'env: [NAME, …] for the values that they have here, or env: '
        '{NAME: VALUE, …}'
    )
    given: list[tuple[Value, Value | None]] = [(value, None)]
    if isinstance(value, yaml_reader.Sequence):
        given = [(item, None) for item in value.items]
    elif isinstance(value, yaml_reader.Mapping):
        given = list(value.pairs.values())
    names: dict[str, None] = {}
    values = []
    for item, content in given:
        name = _text(item, "a name in 'env'", hint)
        if _VARIABLE.fullmatch(name) is None:
            raise _error(f"'{name}' is no name of a variable", item, hint)
        if content is not None and not isinstance(content, Scalar):
            raise _error(f"the value of '{name}' is not a text", content, hint)
        if content is None or content.kind == 'null':
            names[name] = None
        elif '\0' in content.text:
            raise error(f"the value of '{name}' has a null character", content)
        else:
            values.append((name, content.text))
    return tuple(names), tuple(values)


def _ssh_words(value: Value) -> tuple[str, ...]:
    hint = 'ssh: USER@HOST, or a Host of ~/.ssh/config'
    text = _text(value, "'ssh'", hint)
    reason = _wrong_destination(text)
    if reason is not None:
        raise _error(f'it is no destination: {reason}', value, hint)
    return (text,)


def _slurm_words(value: Value) -> tuple[str, ...]:
    hint = 'slurm: [--partition=NAME, --gres=gpu:1], or slurm: []'
    if isinstance(value, yaml_reader.Mapping):
        raise _error("'slurm' is not a list", value, hint)
    if isinstance(value, Scalar) and value.kind == 'null':
        return ()
    words = _words(value, 'slurm', 'an option', hint)
    if words and not words[0].startswith('-'):
        raise error(f"'{words[0]}' is no option", value.position, hint=hint)
    return words


def _command_words(value: Value) -> tuple[str, ...]:
    hint = 'connect: docker exec -i NAME'
    if not isinstance(value, yaml_reader.Sequence):
        _text(value, "'connect'", hint)
    words = _words(value, 'connect', 'a word', hint)
    if not words:
        raise error("'connect' is empty", value.position, hint=hint)
    if words[0].startswith('~/'):
        words = (os.path.expanduser(words[0]), *words[1:])
    return words


def _words(value: Value, key: str, item: str, hint: str) -> tuple[str, ...]:
    """Return a list of words, or a text split into words."""
    if isinstance(value, yaml_reader.Sequence):
        what = f"{item} of '{key}'"
        return tuple(_text(v, what, hint) for v in value.items)
    assert isinstance(value, Scalar)
    try:
        return tuple(shlex.split(value.text))
    except ValueError as e:
        raise error(f"'{key}' has an open quote: {e}", value) from e


_WORDS: Mapping[Kind, Callable[[Value], tuple[str, ...]]] = {
    'ssh': _ssh_words,
    'slurm': _slurm_words,
    'connect': _command_words,
}
#: The settings of a machine, or of all machines by default.
_READERS: Mapping[str, Callable[[Value], Any]] = {
    'workspace': _workspace,
    'sync': lambda v: _choice(v, 'sync', get_args(Sync)),
    'on_lost': lambda v: _choice(v, 'on_lost', get_args(OnLost)),
    'lost_after': _seconds,
    'env': _variables,
    'setup': lambda v: _text(v, "'setup'", 'setup: ~/setup.bash'),
    'python': lambda v: _text(v, "'python'", 'python: /usr/bin/…'),
}
