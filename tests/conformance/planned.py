# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What would come of a launch, told from its plan.

The probe only does what its arguments say, so nothing has to be started.
"""

from collections.abc import Iterator, Mapping
from itertools import takewhile
from pathlib import Path
import shutil
from typing import Any

from colcon_yamllaunch.language.evaluation.request import Request
from colcon_yamllaunch.language.policies.evaluate import evaluate
from colcon_yamllaunch.plan.plan import Entry, Plan, Process, Shutdown
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator
from colcon_yamllaunch.workspace.workspace_session import LaunchPackages

from tests.conformance.case import (
    environment_of,
    Launched,
    lines,
    without_places,
)
from tests.conformance.probe import record_of

#: The cases that a plan cannot tell of: of the command line, and of shells.
ONLY_LAUNCHED = frozenset(
    {'args_malformed', 'executable_shell', 'executable_shell_subst'}
)


def request(name: str, cases: Path, prefix: Path, folder: Path) -> Request:
    """
    Return what a launch of a case would evaluate.

    :param cases: The folder with the cases
    :param prefix: The prefix of the installed packages
    :param folder: The user's current folder
    """
    environment = environment_of(name, cases, prefix, folder)
    locator = PackageLocator((), folder / 'install', False, environment)
    file = str(cases / f'{name}.yaml')
    words = (line.partition(':=') for line in lines(cases / f'{name}.args'))
    return Request(
        file,
        file,
        packages=LaunchPackages(locator, built=True),
        environment=environment,
        arguments={argument: value for argument, _, value in words},
        cwd=str(folder),
        log_folder=str(folder / 'log'),
    )


def plan(name: str, cases: Path, prefix: Path, folder: Path) -> Launched:
    """
    Tell what would come of a launch that nothing stops.

    :param folder: An empty folder for this case alone
    """
    wanted = request(name, cases, prefix, folder)
    evaluation = evaluate(wanted)
    output = '\n'.join(map(str, evaluation.diagnostics))
    refused = Launched(1, output, [], [])
    if evaluation.errors:
        return refused
    records, is_complete = [], True
    entries = takewhile(_goes_on, evaluation.plan.entries)
    for process in Plan(tuple(entries)).processes():
        record = _record(process, wanted.environment, folder)
        if record is None:
            is_complete = False
            continue
        times = 1 + process.respawn * process.respawn_max_retries
        records += [without_places(record, cases, prefix, folder)] * times
    failed = not is_complete or any(
        '--exit' in record['args'] for record in records
    )
    return Launched(int(failed), output, records, [])


def _goes_on(entry: Entry) -> bool:
    return not isinstance(entry, Shutdown)


def _record(
    process: Process, environment: Mapping[str, str], folder: Path
) -> dict[str, Any] | None:
    """Return what a process would write down, None if there is no program."""
    changed = {**environment, **dict(process.environment)}
    variables = {k: v for k, v in changed.items() if v is not None}
    argv = list(_words(process, folder))
    if argv[0] == 'env':
        # the only prefix that the cases have
        argv.pop(0)
        while '=' in argv[0]:
            variable, _, variables[variable] = argv.pop(0).partition('=')
    program = shutil.which(argv[0], path=variables['PATH'])
    if program is None:
        return None
    return record_of(Path(program), argv[1:], process.cwd, variables)


def _words(process: Process, folder: Path) -> Iterator[str]:
    """Return the command line, with the parameter files written."""
    for number, argument in enumerate(process.argv):
        if isinstance(argument, str):
            yield argument
        else:
            file = folder / f'{process.ros_name}.{number}.yaml'
            file.write_text(argument.content, encoding='utf-8')
            yield str(file)
