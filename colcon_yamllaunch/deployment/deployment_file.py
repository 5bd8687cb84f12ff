# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The deployment file of `--deploy`.

It is read like a launch file: each problem has its position, and all problems
are reported at once. A file that includes another, and the profile that is
chosen, are layers over it: a rule, machine or argument of an upper layer
comes before those of a lower one.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
import os.path
from typing import Any

from colcon_yamllaunch.common.suggestions import one_of
from colcon_yamllaunch.deployment import values
from colcon_yamllaunch.deployment.deployment import (
    Deployment,
    HERE,
    Machine,
    ProcessRule,
    Setting,
)
from colcon_yamllaunch.deployment.machine_settings import (
    check_name,
    connection_words,
    KINDS,
    MACHINE_SETTINGS,
)
from colcon_yamllaunch.deployment.process_settings import SETTINGS
from colcon_yamllaunch.deployment.values import (
    check_keys,
    Pairs,
    pairs_of,
    wrong_value,
)
from colcon_yamllaunch.language.syntax import yaml_reader
from colcon_yamllaunch.language.syntax.diagnostics import (
    Diagnostic,
    error,
    LaunchError,
)
from colcon_yamllaunch.language.syntax.source_text import read_source, Source
from colcon_yamllaunch.language.syntax.yaml_reader import Scalar, Value

#: The keys of a file and of each profile, and those of a file besides.
LAYER_KEYS = ('machines', 'defaults', 'processes', 'args')
FILE_KEYS = (*LAYER_KEYS, 'profiles', 'include')
#: The keys of `match` if it is a mapping.
MATCH_KEYS = ('name', 'package', 'executable')
_RULE_HINT = '{match: NAME, machine: MACHINE}, or {match: NAME, nice: 5}'


def read_deployment(path: str, profile: str | None = None) -> Deployment:
    """
    Read a deployment file, with the files that it includes.

    :param profile: The name of one of its profiles
    :raises LaunchError: when it cannot be read, or is wrong
    """
    return deployment_of(read_source(path, path, 'deployment file'), profile)


def deployment_of(source: Source, profile: str | None = None) -> Deployment:
    """
    Return the deployment that a file describes.

    :raises LaunchError: when it is wrong
    """
    return _Reader(profile).read(source)


class _Reader:
    """
    A reader of one file, which collects its problems.

    :param profile: The name of the chosen profile
    """

    def __init__(self, profile: str | None) -> None:
        self._profile = profile
        self._profiles: dict[str, None] = {}
        self._files: list[str] = []
        self._is_profile_found = False
        self._found: list[Diagnostic] = []

    def read(self, source: Source) -> Deployment:
        layers = list(self._layers(source, ()))
        machines: dict[str, Machine] = {}
        names: dict[str, None] = {}
        for layer in layers:
            with self._collected():
                # also those with problems
                names |= dict.fromkeys(_names_in(layer))
                machines = {**self._machines(layer), **machines}
        rules: list[ProcessRule] = []
        arguments: dict[str, str] = {}
        for layer in layers:
            with self._collected():
                rules += self._rules(layer, list(names))
            with self._collected():
                arguments = {**_arguments(layer), **arguments}
        if self._found:
            raise LaunchError(*self._found)
        self._check_profile()
        return Deployment(
            machines,
            tuple(rules),
            arguments=arguments,
            profiles=tuple(self._profiles),
            files=tuple(self._files),
        )

    @contextmanager
    def _collected(self) -> Iterator[None]:
        """Collect the problems of the body, and go on behind it."""
        try:
            yield
        except LaunchError as e:
            self._found.extend(e.diagnostics)

    def _layers(
        self, source: Source, including: Sequence[str]
    ) -> Iterator[Pairs]:
        """Iterate over the layers of a file, the uppermost first."""
        self._files.append(source.path)
        document = yaml_reader.read_yaml(source)
        if document is None:
            raise error(
                'the deployment file is empty',
                source.position(0, 0),
                hint='see docs/machines.md for what it says',
            )
        pairs = pairs_of(document, 'the deployment file')
        if not pairs:
            raise error(
                'the deployment file sets nothing',
                document.position,
                hint=f'processes: [{_RULE_HINT}]',
            )
        with self._collected():
            check_keys(pairs, FILE_KEYS, 'the file')
        with self._collected():
            yield from self._chosen_profile(pairs)
        yield pairs
        if 'include' in pairs:
            with self._collected():
                value = pairs['include'][1]
                included = self._included(value, (*including, source.path))
                yield from self._layers(included, (*including, source.path))

    def _included(self, value: Value, including: Sequence[str]) -> Source:
        hint = 'include: base.yaml'
        text = values.text(value, "'include'", hint)
        folder = os.path.dirname(including[-1])
        path = os.path.join(folder, os.path.expanduser(text))
        if any(
            os.path.realpath(path) == os.path.realpath(p) for p in including
        ):
            message = f"'{text}' includes itself"
            raise wrong_value(message, value, 'remove one of the includes')
        try:
            return read_source(path, path, 'deployment file')
        except LaunchError as e:
            message = e.diagnostics[0].message
            raise wrong_value(message, value, hint) from e

    def _chosen_profile(self, pairs: Pairs) -> Iterator[Pairs]:
        if 'profiles' not in pairs:
            return
        profiles = pairs_of(pairs['profiles'][1], "'profiles'")
        self._profiles |= dict.fromkeys(profiles)
        for name, (_, value) in profiles.items():
            with self._collected():
                layer = pairs_of(value, f"the profile '{name}'")
                check_keys(layer, LAYER_KEYS, 'a profile')
                if name == self._profile:
                    self._is_profile_found = True
                    yield layer

    def _check_profile(self) -> None:
        name = self._profile
        if name is None or self._is_profile_found:
            return
        hint = (
            one_of(name, sorted(self._profiles))
            if self._profiles
            else ('it has no profiles')
        )
        raise error(
            f"--profile: the deployment file has no profile '{name}'",
            hint=hint,
        )

    def _machines(self, layer: Pairs) -> dict[str, Machine]:
        if 'machines' not in layer:
            return {}
        hint = 'machines: {arm: {ssh: robot@arm.local}}'
        listed = pairs_of(layer['machines'][1], "'machines'", hint)
        defaults: dict[str, Any] = {}
        if 'defaults' in layer:
            with self._collected():
                given = pairs_of(layer['defaults'][1], "'defaults'")
                defaults = self._settings_of_machine(given)
                check_keys(given, tuple(MACHINE_SETTINGS), "'defaults'")
        machines: dict[str, Machine] = {}
        for name, (key, value) in listed.items():
            with self._collected():
                check_name(name, key)
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
            pairs: Pairs = {'ssh': (key, value)}
        else:
            pairs = pairs_of(value, f"the machine '{name}'")
        with self._collected():
            check_keys(pairs, (*KINDS, *MACHINE_SETTINGS), 'a machine')
        kinds = [kind for kind in KINDS if kind in pairs]
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
            words = connection_words(kind, pairs[kind][1])
        given = {**defaults, **self._settings_of_machine(pairs)}
        return Machine(name, kind, words, position=key.position, **given)

    def _settings_of_machine(self, pairs: Pairs) -> dict[str, Any]:
        given: dict[str, Any] = {}
        for field, read in MACHINE_SETTINGS.items():
            if field in pairs:
                with self._collected():
                    given[field] = read(pairs[field][1])
        if 'env' in given:
            given['env'], given['values'] = given['env']
        return given

    def _rules(
        self, layer: Pairs, machines: Sequence[str]
    ) -> list[ProcessRule]:
        if 'processes' not in layer:
            return []
        value = layer['processes'][1]
        hint = f'processes: [{_RULE_HINT}]'
        if not isinstance(value, yaml_reader.Sequence):
            raise error("'processes' is not a list", value.position, hint=hint)
        rules = []
        for item in value.items:
            with self._collected():
                rules.append(self._rule(item, machines))
        return rules

    def _rule(self, item: Value, machines: Sequence[str]) -> ProcessRule:
        pairs = pairs_of(item, 'a rule', _RULE_HINT)
        with self._collected():
            check_keys(pairs, ('match', 'machine', *SETTINGS), 'a rule')
        if 'match' not in pairs:
            message = "this rule has no 'match'"
            raise error(message, item.position, hint=_RULE_HINT)
        if len(pairs) == 1:
            message = 'this rule sets nothing'
            raise error(message, item.position, hint=_RULE_HINT)
        machine = None
        if 'machine' in pairs:
            machine = _machine_name(pairs['machine'][1], [*machines, HERE])
        settings: dict[str, Setting] = {}
        for name, read in SETTINGS.items():
            if name in pairs:
                with self._collected():
                    key, value = pairs[name]
                    settings[name] = Setting(
                        read(value), key.position, key.length
                    )
        value = pairs['match'][1]
        if not isinstance(value, yaml_reader.Mapping):
            name = values.pattern(value, "'match'")
            return ProcessRule(
                value.position, machine, settings, name, length=len(name)
            )
        check_keys(value.pairs, MATCH_KEYS, "'match'")
        if not value.pairs:
            hint = 'match: NAME, or match: {package: NAME}'
            raise wrong_value("'match' says nothing to match", value, hint)
        given: dict[str, Any] = {
            field: values.pattern(pattern, f"'{field}'")
            for field, (_, pattern) in value.pairs.items()
        }
        return ProcessRule(value.position, machine, settings, **given)


def _names_in(layer: Pairs) -> Sequence[str]:
    """Return the names of the machines of a layer."""
    _, listed = layer.get('machines', (None, None))
    return (
        list(listed.pairs) if isinstance(listed, yaml_reader.Mapping) else []
    )


def _machine_name(value: Value, known: Sequence[str]) -> str:
    name = values.text(value, "'machine'", 'machine: NAME')
    if name not in known:
        message = f"there is no machine '{name}'"
        raise wrong_value(message, value, one_of(name, known))
    return name


def _arguments(layer: Pairs) -> dict[str, str]:
    """Return the launch arguments that a layer gives."""
    if 'args' not in layer:
        return {}
    hint = 'args: {NAME: VALUE, …}'
    found = {}
    for name, (_, value) in pairs_of(layer['args'][1], "'args'", hint).items():
        if not isinstance(value, Scalar):
            message = f"the value of '{name}' is not a text"
            raise wrong_value(message, value, hint)
        found[name] = value.text
    return found
