# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Messages about which packages are built, and why."""

from collections.abc import Iterable, Iterator, Sequence
import os
import re
import time

from colcon_yamllaunch.workspace.freshness.build_record import (
    BuildMode,
    Decision,
)
from colcon_yamllaunch.workspace.packages.package import Package

#: How many different reasons one line tells, and for how many packages each.
SHOWN_REASONS = 4
SHOWN_NAMES = 3
#: How long the reasons of a package may be in such a line (characters).
REASON_LENGTH = 80
#: What many reasons have in common, after the name of a file.
_ENDING = ' changed'
#: How many reasons `--why` tells of one package.
EXPLAINED_REASONS = 8

_MODES = {
    BuildMode.COMPILE: '',
    BuildMode.BUILD: '',
    BuildMode.CONFIGURE: ' [configured anew]',
    BuildMode.REINSTALL: ' [installed anew]',
    BuildMode.CLEAN: ' [from scratch]',
}


def before_build(stale: Sequence[Decision], fresh: int) -> str:
    """Return what is going to be built and why, in one line."""
    return f'building {_packages(len(stale))}{_why(stale)}{_fresh(fresh)}…'


def after_build(built: Sequence[Decision], fresh: int) -> str:
    """
    Return what a launch has built and why, in one line.

    :param fresh: How many others it needs
    """
    if built:
        return f'{_packages(len(built))} built{_why(built)}{_fresh(fresh)}'
    if fresh:
        return f'{_packages(fresh)} up to date'
    return 'no package of the workspace is needed'


def after_failure(
    failed: Sequence[str], built: Sequence[str], unbuilt: Sequence[str]
) -> str:
    """
    Return how far a build came that did not succeed, in one line.

    :param failed: The packages that failed; may be empty after Ctrl-C
    :param built: Those that were built before
    :param unbuilt: Those that were not built in the end
    """
    parts = ['the build was interrupted']
    if failed:
        parts = [f'{_names(failed)} failed to build']
    if built:
        parts.append(f'{_packages(len(built))} built')
    if unbuilt:
        parts.append(f'not built: {_names(unbuilt)}')
    return '; '.join(parts)


def setup_missing(failed: Iterable[Package]) -> Iterator[str]:
    """
    Return which Python packages could not be built for want of a setup.py.

    colcon-ros takes the build type of their manifests for granted, and fails
    with a traceback.
    """
    for package in failed:
        setup = package.path / 'setup.py'
        if package.type == 'ros.ament_python' and not os.path.exists(setup):
            yield (
                f'{package.name} has no setup.py, which colcon runs: make '
                f"{setup} with the lines 'from setuptools import setup' and "
                "'setup()'; the metadata may be in setup.cfg or pyproject.toml"
            )


def explanation(decision: Decision, way: Sequence[str], launch: str) -> str:
    """
    Describe a decision in one line.

    :param way: How the launch comes to need the package, as
      :func:`package.needed_by` returns it
    """
    texts = [reason.text for reason in decision.reasons]
    if not texts:
        verdict = 'up to date'
        if decision.built_at is not None:
            built = time.localtime(decision.built_at / 1_000_000_000)
            verdict += time.strftime(
                ' since its build at %Y-%m-%d %H:%M:%S', built
            )
    else:
        more = len(texts) - EXPLAINED_REASONS
        rest = f', and {_more(more)}' if more > 0 else ''
        verdict = f'to be built, as {", ".join(texts[:EXPLAINED_REASONS])}'
        verdict += rest + _MODES[decision.mode]
    needed_by = ' → '.join([launch, *way[:-1]])
    return f'{decision.name}: {verdict}; needed by {needed_by}'


def _why(decisions: Sequence[Decision]) -> str:
    by_reason: dict[str, list[str]] = {}
    for decision in decisions:
        by_reason.setdefault(_short(decision), []).append(decision.name)
    shown = list(by_reason.items())[:SHOWN_REASONS]
    texts = [f'{_names(names)}: {reason}' for reason, names in shown]
    left = len(decisions) - sum(len(names) for _, names in shown)
    if left:
        texts.append(f'{left} more, which --why tells of')
    return f' ({"; ".join(texts)})'


def _short(decision: Decision) -> str:
    """Return the reasons for a package as far as they fit in a line."""
    first, *others = (reason.text for reason in decision.reasons)
    if len(first) > REASON_LENGTH:
        # the end of a path tells more than its beginning
        half = REASON_LENGTH // 2
        first = f'{first[:half]}…{first[-half:]}'
    shown = [first]
    for text in others:
        if len(_joined([*shown, text])) > REASON_LENGTH:
            break
        shown.append(text)
    text = _joined(shown)
    left = len(decision.reasons) - len(shown)
    return f'{text}, and {_more(left)}' if left else text


def _joined(texts: Sequence[str]) -> str:
    """Join reasons; what several say of files is said once."""
    # the last of those that stand in a row says it
    again = rf'{_ENDING}(?=, [^ ,]+{_ENDING}(,|$))'
    return re.sub(again, '', ', '.join(texts))


def _more(count: int) -> str:
    return '1 more reason' if count == 1 else f'{count} more reasons'


def _names(names: Sequence[str]) -> str:
    left = len(names) - SHOWN_NAMES
    if left > 1:
        return f'{", ".join(names[:SHOWN_NAMES])} and {left} more'
    return ', '.join(names)


def _packages(count: int) -> str:
    return '1 package' if count == 1 else f'{count} packages'


def _fresh(count: int) -> str:
    return f', {count} up to date' if count else ''
