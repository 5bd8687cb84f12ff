# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What launch files are evaluated in."""

from collections.abc import Iterator
from contextlib import contextmanager
import os

from colcon_yamllaunch.common.suggestions import did_you_mean
from colcon_yamllaunch.common.suggestions import no_package
from colcon_yamllaunch.language.evaluation.request import Request
from colcon_yamllaunch.language.evaluation.scope import Scope
from colcon_yamllaunch.language.evaluation.values import known
from colcon_yamllaunch.language.evaluation.values import unknown
from colcon_yamllaunch.language.evaluation.values import UNSET
from colcon_yamllaunch.language.evaluation.values import Value


class Surroundings:
    """
    The packages, the environment, and the scope that changes on the way.

    :param request: What is to be launched
    """

    #: Whether the environment is that of the launch.
    has_environment = True

    def __init__(self, request: Request) -> None:
        self.packages = request.packages
        self.exposed = request.exposed
        self.environment = dict(request.environment)
        self.cwd = request.cwd
        self.log_folder: str | None = request.log_folder
        self.scope = Scope()
        #: The launch arguments that were given.
        self.given = {n: known(v) for n, v in request.arguments.items()}
        #: Those of them that were read.
        self.given_read: set[str] = set()
        for name, value in self.given.items():
            self.scope.configurations.set(name, value)

    @contextmanager
    def within_scope(self, scope: Scope) -> Iterator[None]:
        """Go on in another scope for the time of the context."""
        outer, self.scope = self.scope, scope
        try:
            yield
        finally:
            self.scope = outer

    def variable(self, name: str) -> Value | None:
        """Return an environment variable, None when there is none."""
        value = self.scope.environment.get(name)
        if value is not None and value is not UNSET:
            return value
        if self.has_environment:
            if value is None and name in self.environment:
                return known(self.environment[name])
            if not self.scope.environment.may_have_others():
                return None
        elif value is None and name not in self.environment:
            return None
        source = f'$(env {name})'
        return unknown(source, (source,))

    def search_path(self) -> str | None:
        """Return where programs are looked for, None when not known."""
        if self.has_environment:
            value = self.variable('PATH')
            return os.defpath if value is None else value.text
        if self.scope.environment.get('PATH') is not None:
            return None
        return self.environment.get('PATH', os.defpath)

    def scope_environment(self) -> dict[str, str]:
        """Return the environment with all that launch files changed."""
        environment = dict(self.environment)
        for name, value in self.scope.environment.all().items():
            if value.text is None:
                environment.pop(name, None)
            else:
                environment[name] = value.text
        return environment

    def absolute(self, path: str) -> str:
        """Return the path that a relative one means."""
        return os.path.normpath(os.path.join(self.cwd, path))

    def no_package(self, name: str) -> tuple[str, str | None]:
        """Return what to say of a package that is not there: and the hint."""
        return no_package(name, self.packages.names(), self.environment)

    def no_launch_file(
        self, written: str, path: str
    ) -> tuple[str, str | None]:
        """
        Return what to say of a launch file that is not there: and the hint.

        :param written: What the launch file says
        :param path: The path that this means
        """
        return (
            f"the launch file '{written}' does not exist",
            did_you_mean(
                os.path.basename(written), self.packages.similar(path)
            ),
        )

    def no_program(self, name: str) -> str:
        """Return what to say of a program that is not there."""
        where = '' if '/' in name else ' on the PATH'
        return f"there is no executable '{name}'{where}"
