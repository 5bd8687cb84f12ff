# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Which version of the code the runs of a sweep use."""

from collections.abc import Collection, Iterable, Iterator, Mapping
import json
import os
from pathlib import Path
import re
import time

from colcon_yamllaunch.common.fingerprint import (
    digest,
    Fingerprint,
    fingerprint,
    with_content,
)
from colcon_yamllaunch.language.policies.evaluate import Evaluation
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.sweep.results import Code
from colcon_yamllaunch.verb.git import git_output
from colcon_yamllaunch.workspace.freshness.source_changes import snapshot
from colcon_yamllaunch.workspace.packages.build_files import is_document

#: Seconds between two looks for edits.
_INTERVAL = 1.0
#: Tracked files that are compared; a larger repository is no package.
_MOST_TRACKED = 10_000
#: Programs whose first argument is the program that matters.
_INTERPRETERS = re.compile(r'(bash|dash|sh|zsh|python|perl|ruby|node)[\d.]*')


class CodeState:
    """
    The files that runs use: launch files, programs and package sources.

    :param environment: That of git
    """

    def __init__(self, environment: Mapping[str, str]) -> None:
        self._environment = environment
        # the fingerprints of each file or folder at the last check
        self._known: dict[str, dict[str, Fingerprint]] = {}
        self._found = Code('', {})
        self._next = 0.0

    def missing(self, uses: Iterable[str]) -> list[str]:
        """Return the files and folders in `uses` that are not known yet."""
        return [path for path in uses if path not in self._known]

    def add(self, uses: Iterable[str]) -> None:
        """Include files and folders."""
        for path in self.missing(uses):
            self._known[path] = {}
            self._next = 0.0

    def add_tracked(self, folder: Path) -> None:
        """Include the files below a folder that git tracks, if not many."""
        names = self._git(folder, 'ls-files', '-z').split('\0')[:-1]
        if len(names) <= _MOST_TRACKED:
            self.add(str(folder / n) for n in names if not is_document(n))

    def look(self, uses: Collection[str] = ()) -> Code:
        """Return the version now; at most one second old."""
        self.add(uses)
        if time.monotonic() < self._next:
            return self._found
        parts = {}
        for path, before in self._known.items():
            now = self._known[path] = _files(path, before)
            if now:
                # times differ after a checkout there and back
                content = [
                    (name, f.size, f.executable, f.digest)
                    for name, f in sorted(now.items())
                ]
                parts[path] = digest(json.dumps(content).encode())
        if parts != self._found.parts:
            self._found = Code(self._commit(), parts)
        self._next = time.monotonic() + _INTERVAL
        return self._found

    def _commit(self) -> str:
        """Return the commit, with `-dirty` if modified; '' without git."""
        tops = sorted({top for path in self._known for top in _top(path)})
        words = ['--always', '--dirty', '--exclude=*', '--abbrev=10']
        found = {}
        for top in tops:
            if commit := self._git(top, 'describe', *words).strip():
                found[top.name] = commit
        if len(found) == 1:
            return next(iter(found.values()))
        return ' '.join(f'{name}={commit}' for name, commit in found.items())

    def _git(self, folder: Path, *words: str) -> str:
        options = '--no-optional-locks'
        return git_output(folder, self._environment, options, *words)


def files_of(plan: Plan, evaluation: Evaluation) -> set[str]:
    """Return the files that a plan was made from, and its programs."""
    found = {file.path for file in evaluation.files}
    found.update(evaluation.inputs)
    for process in plan.processes():
        words = [word for word in process.argv[:2] if isinstance(word, str)]
        if words and not _INTERPRETERS.fullmatch(os.path.basename(words[0])):
            del words[1:]
        for word in words:
            path = os.path.join(process.cwd, word)
            if os.path.isfile(path):
                found.add(path)
    return {os.path.abspath(path) for path in found}


def _files(
    path: str, before: Mapping[str, Fingerprint]
) -> dict[str, Fingerprint]:
    if os.path.isdir(path):
        found = snapshot(Path(path), before)
        return {n: f for n, f in found.items() if not is_document(n)}
    now = fingerprint(path)
    if now is None:
        return {}
    return {'': with_content(Path(path), now, before.get(''))}


def _top(path: str) -> Iterator[Path]:
    """Yield the root of the git repository that a path is in, if any."""
    for folder in (Path(path), *Path(path).parents):
        if (folder / '.git').exists():
            yield folder
            return
