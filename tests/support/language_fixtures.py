# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launch files as texts, and the packages that they name."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
import os
from pathlib import Path

from colcon_yamllaunch.language.evaluation.request import Request
from colcon_yamllaunch.language.evaluation.scope import ValuePlace
from colcon_yamllaunch.language.policies.check import check
from colcon_yamllaunch.language.policies.evaluate import evaluate, Evaluation
from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic
from colcon_yamllaunch.language.syntax.source_text import Source
from colcon_yamllaunch.plan.plan import Process
import pytest

#: The environment that the launch files are evaluated in.
ENVIRONMENT = {'PATH': '/usr/bin:/bin', 'SET': 'value'}
LOG_FOLDER = '/logs'
#: What is evaluated by a launch only.
ONLY_LAUNCHED = ('$(env', '$(command', '$(eval')


class FakePackages:
    """Packages that are built already, each in a prefix of its own."""

    def __init__(self, programs: Mapping[str, Iterable[str]]) -> None:
        self.programs = {name: set(them) for name, them in programs.items()}

    def prefix(self, name: str) -> str | None:
        return f'/install/{name}' if name in self.programs else None

    def names(self) -> Iterable[str]:
        return self.programs

    def own_names(self) -> Iterable[str]:
        return self.programs

    def executable(self, package: str, name: str) -> str | None:
        if name not in self.programs.get(package, ()):
            return None
        return f'/install/{package}/lib/{package}/{name}'

    def explain_executable(self, package: str, name: str) -> str:
        return f'{package} has {", ".join(sorted(self.programs[package]))}'

    def locate(self, path: str) -> tuple[str, str] | None:
        return (path, path) if os.path.isfile(path) else None

    def may_appear(self, path: str) -> bool:
        return path.startswith('/install/')

    def rule_for(self, path: str) -> str | None:
        return None

    def similar(self, path: str) -> Iterable[str]:
        folder = os.path.dirname(path)
        return sorted(os.listdir(folder)) if os.path.isdir(folder) else ()


@dataclass(frozen=True)
class Marked:
    """
    A text in which `«…»` marks what a caret has to underline.

    :param text: The text without the marks
    :param line: Where the mark is, counted from 1
    :param column: Where the mark is, counted from 1
    :param length: How many characters are marked, None when it has no end
    """

    text: str
    line: int
    column: int
    length: int | None

    @classmethod
    def of(cls, marked: str) -> 'Marked':
        before, mark, after = marked.partition('«')
        assert mark, 'nothing is marked'
        inside, end, rest = after.partition('»')
        return cls(
            before + inside + rest,
            before.count('\n') + 1,
            len(before) - (before.rfind('\n') + 1) + 1,
            len(inside) if end else None,
        )

    def check(self, diagnostic: Diagnostic | ValuePlace) -> None:
        position = diagnostic.position
        assert position is not None, diagnostic
        place = (position.line, position.column)
        assert place == (self.line, self.column), diagnostic
        assert self.length in (None, diagnostic.length), diagnostic


class Launcher:
    """Evaluates texts as launch files, all in one folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.packages = FakePackages(
            {'alpha': ['talker', 'listener'], 'my_pkg': ['my_node']}
        )
        self.environment = dict(ENVIRONMENT)

    def write(self, name: str, text: str | bytes) -> Path:
        """Write a file into the folder; a launch file may lack its root."""
        if isinstance(text, str) and text.lstrip('\n').startswith('- '):
            text = f'launch:\n{text}'
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        data = text.encode() if isinstance(text, str) else text
        path.write_bytes(data)
        return path

    def evaluate(self, text: str | bytes, **arguments: str) -> Evaluation:
        """Evaluate a launch file, whatever comes of it."""
        return evaluate(self.request(text, **arguments))

    def request(self, text: str | bytes, **arguments: str) -> Request:
        """Write a launch file, and return what to evaluate."""
        path = str(self.write('main.yaml', text))
        return Request(
            path,
            path,
            packages=self.packages,
            environment=self.environment,
            arguments={k.replace('__', '-'): v for k, v in arguments.items()},
            cwd=str(self.folder),
            log_folder=LOG_FOLDER,
        )

    def good(self, text: str, **arguments: str) -> Evaluation:
        """Evaluate a launch file that has nothing wrong with it."""
        evaluation = self.evaluate(text, **arguments)
        assert evaluation.diagnostics == ()
        return evaluation

    def processes(self, text: str, **arguments: str) -> list[Process]:
        """Return the processes of a good launch file."""
        return list(self.good(text, **arguments).plan.processes())

    def process(self, text: str, **arguments: str) -> Process:
        """Return the one process of a good launch file."""
        (process,) = self.processes(text, **arguments)
        return process

    def value(self, text: str, before: str = '', **arguments: str) -> str:
        """Return what a text with substitutions comes to."""
        argv = self.process(
            f'launch:\n{before}\n- executable:\n    cmd:\n    - echo\n'
            f'    - {text}\n',
            **arguments,
        ).argv
        assert len(argv) == 2
        assert isinstance(argv[1], str)
        return argv[1]

    def errors(self, text: str, **arguments: str) -> tuple[Diagnostic, ...]:
        """Return the errors of a launch file, at least one."""
        errors = self.evaluate(text, **arguments).errors
        assert errors
        return errors

    def error(self, marked: str, **arguments: str) -> Diagnostic:
        """
        Return the one error of a launch file, which is where it marks.

        A check finds it, too, if it does not need what only a launch knows.
        """
        mark = Marked.of(marked)
        (error,) = self.errors(mark.text, **arguments)
        mark.check(error)
        if not any(word in marked for word in ONLY_LAUNCHED):
            request = self.request(mark.text, **arguments)
            found = check(request, portable=False).diagnostics
            places = [(d.message, d.position) for d in found]
            assert (error.message, error.position) in places, found
        return error

    def warning(self, marked: str, **arguments: str) -> Diagnostic:
        """Return the one warning of a launch file, where it marks."""
        mark = Marked.of(marked)
        (warning,) = self.evaluate(mark.text, **arguments).diagnostics
        assert warning.severity == 'warning', warning
        mark.check(warning)
        return warning


@pytest.fixture
def launcher(tmp_path: Path) -> Launcher:
    return Launcher(tmp_path)


@pytest.fixture(scope='session')
def shared_launcher(tmp_path_factory: pytest.TempPathFactory) -> Launcher:
    """Give a launcher to the many examples of one property."""
    return Launcher(tmp_path_factory.mktemp('launcher'))


def source(text: str) -> Source:
    return Source('launch.yaml', '/share/launch.yaml', text)
