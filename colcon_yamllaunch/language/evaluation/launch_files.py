# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The launch files of a launch, each of which is read once."""

from colcon_yamllaunch.language.evaluation.request import Exposed, Request
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.launch_tree import (
    LaunchFile,
    read_launch_file,
)
from colcon_yamllaunch.language.syntax.source_text import read_source, Source


class LaunchFiles:
    """
    The launch files that were read.

    :param request: Has what was read for an earlier launch
    """

    def __init__(self, request: Request) -> None:
        self._request = request
        #: Those in YAML and XML by their paths, None where nothing in one can
        #: be read. One in Python is None when nothing is known of it.
        self.trees: dict[str, LaunchFile | None] = {}
        #: All of them, those with mistakes too.
        self.sources: list[Source] = []
        #: Those in Python, in order.
        self.python: dict[str, None] = {}
        #: The errors of those with mistakes, by their paths.
        self.problems: dict[str, LaunchError] = {}
        self._source_paths: dict[str, str] = {}

    def read(self, name: str, path: str) -> LaunchFile | None:
        """
        Read a launch file in YAML or XML, unless it was read before.

        :param name: The path that it goes by
        :return: None when nothing in it can be read
        """
        if path not in self.trees:
            self.trees[path] = None
            try:
                source = read_source(path, name)
                self.sources.append(source)
                self.trees[path] = file = self._tree_of(path, source)
                if file.has_mistakes:
                    self.problems[path] = LaunchError(*file.problems)
            except LaunchError as e:
                self.problems[path] = e
        return self.trees[path]

    def _tree_of(self, path: str, source: Source) -> LaunchFile:
        trees = self._request.trees
        known = trees.get(path)
        if known is not None and known.source == source:
            return known
        has_asked = False

        def exposed() -> Exposed:
            nonlocal has_asked
            has_asked = True
            return self._request.exposed()

        file = read_launch_file(source, exposed)
        if not has_asked:
            # the packages may provide other actions the next time
            trees[path] = file
        return file

    def readable(self) -> list[LaunchFile]:
        """Return those in YAML and XML that could be read."""
        return [file for file in self.trees.values() if file is not None]

    def note_python(self, path: str) -> None:
        """Record a launch file in Python that is read."""
        if path not in self.python:
            self.python[path] = None
            self.sources.append(Source(path, path, ''))

    def source_path(self, path: str) -> str:
        """Return the file in a source that is installed at a path, or it."""
        source = self._source_paths.get(path)
        if source is None:
            located = self._request.packages.locate(path)
            source = path if located is None else located[1]
            self._source_paths[path] = source
        return source
