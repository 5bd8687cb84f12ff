# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Problems beside the lines of launch files, in a workflow of GitHub."""

from collections.abc import Iterable
from collections.abc import Iterator
from collections.abc import Mapping
from dataclasses import replace
import os

from colcon_yamllaunch.engine.events import Ended
from colcon_yamllaunch.language.reports.github_annotations import annotation
from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic
from colcon_yamllaunch.verb.cli.messages import show


def annotate(
    diagnostics: Iterable[Diagnostic], environment: Mapping[str, str]
) -> None:
    """
    Have GitHub show problems; elsewhere do nothing.

    :param environment: The user's; `GITHUB_ACTIONS` says whether this is a
      workflow, and `GITHUB_WORKSPACE` where the repository is
    """
    if environment.get('GITHUB_ACTIONS') != 'true':
        return
    root = environment.get('GITHUB_WORKSPACE') or os.getcwd()
    for diagnostic in diagnostics:
        position = diagnostic.position
        if position is not None:
            # from an installed launch file to that in the repository
            source = replace(position, path=os.path.realpath(position.path))
            diagnostic = replace(diagnostic, position=source)
        show(annotation(diagnostic, os.path.realpath(root)))


def failures_of(ended: Ended) -> Iterator[Diagnostic]:
    """Return what failed in a launch as problems of its launch files."""
    for failure in ended.failures:
        text = '\n'.join((failure.text, *failure.tail))
        process = failure.process
        position = None if process is None else process.position
        yield Diagnostic('error', text, position)
    for verdict in ended.verdicts:
        if verdict.failure is not None:
            yield Diagnostic('error', verdict.failure)
