# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Problems as GitHub's workflow commands.

See "Workflow commands for GitHub Actions" in its documentation.
"""

from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic
from colcon_yamllaunch.plan.position import shown_path


def annotation(diagnostic: Diagnostic, root: str) -> str:
    """
    Return the line that makes GitHub show a problem beside its source.

    :param diagnostic: The problem
    :param root: The root of the repository, which paths are relative to
    """
    properties = []
    position = diagnostic.position
    if position is not None:
        path = shown_path(position.path, root)
        properties = [
            f'file={_escape_property(path)}',
            f'line={position.line}',
            f'col={position.column}',
            f'endColumn={position.column + diagnostic.length}',
        ]
    command = f'{diagnostic.severity} {",".join(properties)}'.rstrip()
    return f'::{command}::{_escape_data(with_hint(diagnostic))}'


def with_hint(diagnostic: Diagnostic) -> str:
    """Return what is wrong and, in a second line, the way out."""
    if diagnostic.hint is None:
        return diagnostic.message
    return f'{diagnostic.message}\nhelp: {diagnostic.hint}'


def _escape_data(text: str) -> str:
    # as the toolkit of GitHub Actions does (escapeData in its command.ts)
    return text.replace('%', '%25').replace('\r', '%0D').replace('\n', '%0A')


def _escape_property(text: str) -> str:
    return _escape_data(text).replace(':', '%3A').replace(',', '%2C')
