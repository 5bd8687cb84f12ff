# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launch files in Python that a played worker reads."""

from collections.abc import Callable
from dataclasses import replace

from colcon_yamllaunch.language.evaluation.findings import CheckResult
from colcon_yamllaunch.language.policies.check import (
    check,
    Declarations,
    find_declarations,
)
from colcon_yamllaunch.language.policies.evaluate import evaluate, Evaluation
import pytest
from support.language_fixtures import Launcher
from support.played_worker import Message, Play, PlayedWorker

#: Includes the launch file in Python.
INCLUDE = 'launch: [include: {file: robot.launch.py}]\n'


class Played:
    """
    A launch file in Python, which is played, and others that include it.

    :param plays: What the file does, by its path
    """

    def __init__(self, launcher: Launcher) -> None:
        self.launcher = launcher
        self.plays: dict[str, Callable[[Message], Play]] = {}
        self.worker = PlayedWorker(self._play)
        self.path = self.file('robot.launch.py')

    def file(self, name: str, text: str = '# made up\n') -> str:
        """Write a launch file in Python."""
        return str(self.launcher.write(name, text))

    def does(self, play: Callable[[Message], Play], path: str = '') -> None:
        """Let a launch file do something."""
        self.plays[path or self.path] = play

    def says(self, *messages: Message, end: Message | None = None) -> None:
        """Let the launch file say the same each time."""

        def play(_request: Message) -> Play:
            yield from messages
            return end

        self.does(play)

    def _play(self, request: Message) -> Play:
        play = self.plays.get(request.get('path', request['do']), _nothing)
        return play(request)

    def evaluate(self, text: str = INCLUDE, **arguments: str) -> Evaluation:
        """Evaluate a launch file in YAML."""
        request = self.launcher.request(text, **arguments)
        return evaluate(replace(request, open_worker=lambda: self.worker))

    def evaluate_itself(self, **arguments: str) -> Evaluation:
        """Evaluate the launch file in Python."""
        request = self.launcher.request('launch: []', **arguments)
        request = replace(request, name=self.path, path=self.path)
        return evaluate(replace(request, open_worker=lambda: self.worker))

    def good(self, text: str = INCLUDE, **arguments: str) -> Evaluation:
        """Evaluate a launch file that has nothing wrong with it."""
        evaluation = self.evaluate(text, **arguments)
        assert evaluation.diagnostics == ()
        return evaluation

    def check(self, text: str = INCLUDE) -> CheckResult:
        """Check a launch file in YAML."""
        request = self.launcher.request(text)
        request = replace(request, open_worker=lambda: self.worker)
        return check(request, portable=False)

    def check_itself(self) -> CheckResult:
        """Check the launch file in Python."""
        request = self.launcher.request('launch: []')
        request = replace(request, name=self.path, path=self.path)
        request = replace(request, open_worker=lambda: self.worker)
        return check(request, portable=False)

    def declared(self, text: str = INCLUDE) -> Declarations:
        """Return the launch arguments of a launch file in YAML."""
        request = self.launcher.request(text)
        return find_declarations(
            replace(request, open_worker=lambda: self.worker)
        )


def _nothing(_request: Message) -> Play:
    yield from ()
    return None


@pytest.fixture
def played(launcher: Launcher) -> Played:
    return Played(launcher)
