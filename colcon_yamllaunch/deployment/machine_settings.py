# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""How a deployment file, or `--on`, describes a machine."""

from collections.abc import Callable, Mapping
import os.path
import posixpath
import re
from typing import Any, get_args

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.suggestions import one_of
from colcon_yamllaunch.deployment import values
from colcon_yamllaunch.deployment.deployment import (
    Deployment,
    HERE,
    Kind,
    Machine,
    OnLost,
    Sync,
)
from colcon_yamllaunch.deployment.values import wrong_value
from colcon_yamllaunch.language.syntax import yaml_reader
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.yaml_reader import Scalar, Value

#: Stands before the options of an allocation in `--on`.
SLURM = 'slurm:'

_ENV_HINT = (
    'env: [NAME, …] for the values that they have here, or env: '
    '{NAME: VALUE, …}'
)
KINDS: tuple[Kind, ...] = get_args(Kind)
#: The range of `lost_after` (seconds).
LOST_AFTER = (0.1, 3600.0)
#: The name of a machine, which stands in labels, names of files and on command
#: lines.
NAME = re.compile(r'[A-Za-z0-9][A-Za-z0-9_.-]{0,62}')


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
        return Deployment(
            deployment.machines, everything_on=word, files=deployment.files
        )
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
    """Return why a word cannot be a destination of ssh, or None if it can."""
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


def check_name(name: str, key: Scalar) -> None:
    """Check the name of a machine, and raise LaunchError if it is none."""
    if name == HERE:
        hint = f"'{HERE}' is the computer that the launch is begun on"
        raise error(f"no machine is called '{HERE}'", key, hint=hint)
    if NAME.fullmatch(name) is None:
        raise error(
            f"'{name}' is no name for a machine",
            key,
            hint='it has letters, digits, dots, dashes and underscores, at '
            'most 63, and begins with a letter or digit',
        )


def _workspace(value: Value) -> str:
    hint = 'an absolute path, or one that begins in the home folder: ~/ws'
    text = values.text(value, "'workspace'", hint)
    if text.startswith('~') and not text.startswith('~/') and text != '~':
        message = f"'{text}' begins in the home folder of somebody else"
        raise wrong_value(message, value, hint)
    if not text.startswith(('/', '~')):
        # as scp and rsync read the path behind a colon
        text = f'~/{text}'
    top, below = ('~/', text[2:]) if text.startswith('~') else ('/', text)
    path = posixpath.normpath(below or '.').lstrip('/')
    if path in ('', '.', '..') or path.startswith('../'):
        message = f"'{text}' is no folder for a workspace"
        raise wrong_value(message, value, hint)
    return top + path


def _ssh_words(value: Value) -> tuple[str, ...]:
    hint = 'ssh: USER@HOST, or a Host of ~/.ssh/config'
    text = values.text(value, "'ssh'", hint)
    reason = _wrong_destination(text)
    if reason is not None:
        raise wrong_value(f'it is no destination: {reason}', value, hint)
    return (text,)


def _slurm_words(value: Value) -> tuple[str, ...]:
    hint = 'slurm: [--partition=NAME, --gres=gpu:1], or slurm: []'
    if isinstance(value, yaml_reader.Mapping):
        raise wrong_value("'slurm' is not a list", value, hint)
    if isinstance(value, Scalar) and value.kind == 'null':
        return ()
    found = values.words(value, 'slurm', 'an option', hint)
    if found and not found[0].startswith('-'):
        raise error(f"'{found[0]}' is no option", value.position, hint=hint)
    return found


def _command_words(value: Value) -> tuple[str, ...]:
    hint = 'connect: docker exec -i NAME'
    if not isinstance(value, yaml_reader.Sequence):
        values.text(value, "'connect'", hint)
    found = values.words(value, 'connect', 'a word', hint)
    if not found:
        raise error("'connect' is empty", value.position, hint=hint)
    if found[0].startswith('~/'):
        found = (os.path.expanduser(found[0]), *found[1:])
    return found


_WORDS: Mapping[Kind, Callable[[Value], tuple[str, ...]]] = {
    'ssh': _ssh_words,
    'slurm': _slurm_words,
    'connect': _command_words,
}


def connection_words(kind: Kind, value: Value) -> tuple[str, ...]:
    """
    Return how a machine is reached; see `Machine.words`.

    :raises LaunchError: when the value does not say
    """
    return _WORDS[kind](value)


#: The settings of a machine, or of all machines by default.
MACHINE_SETTINGS: Mapping[str, Callable[[Value], Any]] = {
    'workspace': _workspace,
    'sync': lambda v: values.choice(v, 'sync', get_args(Sync)),
    'on_lost': lambda v: values.choice(v, 'on_lost', get_args(OnLost)),
    'lost_after': lambda v: values.number(
        v, 'lost_after', *LOST_AFTER, what='a number of seconds'
    ),
    'env': lambda v: values.variables(v, _ENV_HINT),
    'setup': lambda v: values.text(v, "'setup'", 'setup: ~/setup.bash'),
    'python': lambda v: values.text(v, "'python'", 'python: /usr/bin/…'),
}
