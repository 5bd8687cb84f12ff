# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The launch arguments that may stand on the command line, for completion."""

from collections.abc import Mapping
from collections.abc import Sequence
from pathlib import Path

from colcon_yamllaunch.language.actions.scope_actions import BOOLEAN_CHOICES
from colcon_yamllaunch.language.evaluation.declared_argument import (
    DeclaredArgument,
)
from colcon_yamllaunch.language.evaluation.request import Request
from colcon_yamllaunch.language.policies.declared import find_declarations
from colcon_yamllaunch.verb.cli.target import package_target
from colcon_yamllaunch.verb.cli.target import path_target
from colcon_yamllaunch.verb.completion.candidates import Candidates
from colcon_yamllaunch.verb.launching.launch_packages import (
    exposed_by_packages,
)
from colcon_yamllaunch.verb.launching.launch_packages import LaunchPackages
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator


def launch_arguments(
    positionals: Sequence[str],
    locator: PackageLocator,
    given: Sequence[str],
    environment: Mapping[str, str],
    prefix: str,
) -> Candidates:
    """
    Return the launch arguments, or the values of the one that is begun.

    :param positionals: A package and a launch file, or the path of one
    :raises UserError: when there is no such launch file
    :raises LaunchError: when a launch file has mistakes
    """
    cwd = Path.cwd()
    target = path_target(tuple(positionals), cwd, locator) or package_target(
        tuple(positionals), locator, tuple
    )
    values = dict(word.split(':=', 1) for word in given)
    known = LaunchPackages(locator, built=False)
    located = known.locate(target.name)
    request = Request(
        target.path if located is None else located[0],
        target.path,
        packages=known,
        environment=environment,
        arguments=values,
        cwd=str(cwd),
        exposed=exposed_by_packages(locator, environment),
    )
    arguments = find_declarations(request).arguments
    name, found, _ = prefix.partition(':=')
    if found:
        choices = (_choices(a) for a in arguments if a.name == name)
        return {f'{name}:={c}': '' for c in next(choices, ())}
    return {
        f'{argument.name}:=': _described(argument)
        for argument in arguments
        # where the launch file sets it, the command line does not count
        if argument.name not in values and argument.set_at is None
    }


def _choices(argument: DeclaredArgument) -> tuple[str, ...]:
    # of the ways to write a boolean, one will do
    is_boolean = argument.choices == BOOLEAN_CHOICES
    return ('true', 'false') if is_boolean else argument.choices


def _described(argument: DeclaredArgument) -> str:
    default = argument.default
    value = 'required' if default is None else f"default: '{default}'"
    text = f'{argument.description or ""} ({value})'
    return ' '.join(text.split())
