# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Prepare a launch: evaluate it, build its packages, check the plan."""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import nullcontext, redirect_stdout
import io
import os
from pathlib import Path
import shutil
import sys
from typing import Literal

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.messages import GiveUpError, say
from colcon_yamllaunch.common.suggestions import way_to_program
from colcon_yamllaunch.control.socket_folder import has_sockets
from colcon_yamllaunch.language.evaluation.findings import (
    ExecutableUse,
    PluginUse,
    ProgramUse,
)
from colcon_yamllaunch.language.evaluation.scope import LeftOpen, ValuePlace
from colcon_yamllaunch.language.policies.evaluate import evaluate, Evaluation
from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic, Severity
from colcon_yamllaunch.plan.plan import Plan, Process
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.verb.context import LaunchContext
from colcon_yamllaunch.verb.target import Target
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator

# what builds, and what explains mistakes, is imported where it is needed


def prepare(context: LaunchContext) -> tuple[Plan, Mapping[str, str]]:
    """
    Evaluate and build until nothing more is needed.

    Return the plan, and the environment for its processes.

    :raises GiveUpError: when there can be no launch, and the user knows why
    :raises UserError: when there can be none
    """
    options, machines = context.options, context.machines
    built: set[str] = set()
    warned: list[Diagnostic] = []
    may_build = not options.no_build and context.workspace.root is not None
    # the machines determine which packages are needed here
    is_final = not may_build and machines is None
    if machines is not None:
        machines.connect_early()
    # it ends, as each round that builds has packages that none before had
    while True:
        target = context.target()
        request = context.request(target, built=is_final)
        evaluation = evaluate(request)
        errors = evaluation.errors
        if not errors:
            # before a build, which may take long
            if context.needs_declarations:
                _refuse_undeclared(context, evaluation)
            warn_of_doubled_nodes(
                context, evaluation.plan, request.environment
            )
            if machines is not None:
                named = _named(context, target, evaluation)
                if options.build_all:
                    named = context.workspace.package_names
                _stop_at_unknown_executables(context, evaluation)
                machines.begin_sync(evaluation.plan, evaluation, named)
            elif (placed := context.placed(evaluation.plan)) is not None:
                check_limits(context, placed.whole)
        if is_final or any(not e.may_pass_after_build for e in errors):
            break
        _stop_at_foreign_plugins(context, evaluation)
        wanted = _wanted(context, target, evaluation)
        is_final = (
            not may_build
            or wanted <= built
            or not _build(context, wanted, target, evaluation, warned)
        )
        built |= wanted
        if is_final and _all_exist(context, context.packages.expected):
            # nothing was built since, so all of it still holds
            break
    context.wanted = _wanted(context, target, evaluation)
    if may_build and not options.quiet:
        context.builds.report()
    elif options.no_build and options.why:
        explain(context, target, evaluation)
    _stop_at_errors(context, target, evaluation)
    context.evaluation = evaluation
    _warn(context, evaluation.diagnostics, warned)
    _check_before_start(context, evaluation)
    plan = evaluation.plan
    if machines is not None:
        plan = machines.finish_sync(plan)
    elif context.deployment is not None:
        plan = _deployed(context, plan)
    warn_of_missing_programs(context, plan, request.environment)
    return plan, request.environment


def _deployed(context: LaunchContext, plan: Plan) -> Plan:
    """
    Return a plan with the settings of a deployment without machines.

    :raises GiveUpError: when they do not fit the plan
    """
    from colcon_yamllaunch.deployment.placement import rules_in_vain

    placed = context.placed(plan)
    assert placed is not None
    assert context.deployment is not None
    context.report(rules_in_vain(placed.whole, context.deployment))
    return placed.whole


def explain(
    context: LaunchContext, target: Target, evaluation: Evaluation
) -> None:
    """Print which packages would be built for the launch, and why."""
    if context.workspace.root is not None:
        wanted = _wanted(context, target, evaluation)
        context.builds.explain(wanted, Path(target.name).name)


def warn_of_doubled_nodes(
    context: LaunchContext, plan: Plan, environment: Mapping[str, str]
) -> None:
    """Warn of nodes that another launch of the user runs already."""
    if context.is_again or not has_sockets(context.environment):
        return
    from colcon_yamllaunch.control import client, doubled_nodes

    file = context.about().file
    for other in client.answering_launches(context.environment):
        nodes = doubled_nodes.doubled_nodes(plan, environment, file, other)
        if nodes and other.pid not in context.known_doubles:
            context.known_doubles.add(other.pid)
            text = doubled_nodes.warning(nodes, other)
            say(f'colcon launch: warning: {text}')


def warn_of_missing_programs(
    context: LaunchContext, plan: Plan, environment: Mapping[str, str]
) -> None:
    """Warn of processes whose programs this machine does not have."""
    if context.machines is not None:
        plan = context.machines.place(plan).local
    uses = {} if context.evaluation is None else context.evaluation.programs
    context.report(
        missing_programs(plan.processes(), uses, context.locator, environment)
    )


def check_limits(context: LaunchContext, plan: Plan) -> None:
    """
    Check that the processes that run here can have their limits and users.

    :param plan: All of the plan, with the settings of the deployment
    :raises GiveUpError: when some cannot
    """
    limited = [
        process
        for process in plan.processes()
        if process.settings is not None and process.settings.is_restricted
    ]
    if limited and context.machines is not None:
        here = {
            p.label for p in context.machines.place(plan).local.processes()
        }
        limited = [process for process in limited if process.label in here]
    if not limited:
        return
    from colcon_yamllaunch.engine.resource_limits import problems_of

    context.report_or_fail(
        Diagnostic(
            'error',
            found.problem,
            found.position,
            found.hint,
            len(found.key),
        )
        for found in problems_of(limited, context.process_environment())
    )


def _stop_at_unknown_executables(
    context: LaunchContext, evaluation: Evaluation
) -> None:
    """
    Stop at programs that no build brings, as the source tells.

    :raises GiveUpError: when there are some
    """
    uses = evaluation.executables
    context.report_or_fail(
        missing_executables(uses, context.locator, 'certainly')
    )


def _named(
    context: LaunchContext, target: Target, evaluation: Evaluation
) -> set[str]:
    """Return the packages of the workspace that the launch names."""
    names = {target.package, *evaluation.packages}
    return context.workspace.package_names & names


def _wanted(
    context: LaunchContext, target: Target, evaluation: Evaluation
) -> set[str]:
    """Return the packages of the workspace to bring up to date."""
    workspace, options = context.workspace, context.options
    if options.build_all:
        return workspace.package_names - context.remote_only
    if options.paths:
        return set(workspace.select(options.paths, context.cwd))
    return _named(context, target, evaluation) - context.remote_only


def _all_exist(context: LaunchContext, paths: Iterable[str]) -> bool:
    """Return whether all paths exist that need to exist here."""
    missing = (path for path in paths if not os.path.exists(Path(path)))
    owners = map(context.locator.owner, missing)
    return all(owner and owner.name in context.remote_only for owner in owners)


def _warn(
    context: LaunchContext,
    warnings: Iterable[Diagnostic],
    warned: list[Diagnostic],
) -> None:
    """Report those warnings that were not reported before."""
    new = [w for w in warnings if w not in warned]
    warned += new
    context.report(new)


def _refuse_undeclared(context: LaunchContext, evaluation: Evaluation) -> None:
    """Refuse arguments that the launch would warn of."""
    from colcon_yamllaunch.language.policies import cross_checks

    hints = {d.message: d.hint for d in evaluation.diagnostics}
    for name in context.options.arguments:
        problem = cross_checks.undeclared_argument(name, '')
        message = problem.diagnostics[0].message
        if message in hints:
            raise UserError(message, hints[message])


def _stop_at_foreign_plugins(
    context: LaunchContext, evaluation: Evaluation
) -> None:
    """Stop at components that no build of the workspace brings."""
    own = context.workspace.package_names
    uses = [use for use in evaluation.plugins if use.package not in own]
    found = missing_plugins(uses, context.locator, 'built')
    errors = [d for d in found if d.severity == 'error']
    if errors:
        context.fail([*evaluation.diagnostics, *errors])


def _stop_at_errors(
    context: LaunchContext, target: Target, evaluation: Evaluation
) -> None:
    errors = evaluation.errors
    if all(error.may_pass_after_build for error in errors):
        # a package that is not built may be the reason
        needed = _named(context, target, evaluation) - context.remote_only
        context.workspace.check_sourced(
            sorted(needed), may_build=not context.options.no_build
        )
    if errors:
        context.fail(evaluation.diagnostics)


def _check_before_start(
    context: LaunchContext, evaluation: Evaluation
) -> None:
    """
    Stop if something is missing after all builds.

    A program or component that is not there is an error; a file is a warning,
    as the launch may go on without it in ROS 2 too.
    """
    locator, elsewhere = context.locator, context.remote_only
    found = [
        *undeclared_packages(evaluation.packages, locator),
        *missing_executables(
            [u for u in evaluation.executables if u.package not in elsewhere],
            locator,
            'now',
        ),
        *missing_plugins(
            [u for u in evaluation.plugins if u.package not in elsewhere],
            locator,
            'now',
        ),
        *_files_not_installed(context, evaluation),
    ]
    context.report_or_fail(found)


def _files_not_installed(
    context: LaunchContext, evaluation: Evaluation
) -> Iterator[Diagnostic]:
    """Find launch files and files of command lines that only sources have."""
    wanted: dict[str, Position | None] = dict.fromkeys(
        context.packages.not_installed
    )
    for process in evaluation.plan.processes():
        for argument in process.argv:
            if isinstance(argument, str):
                path = argument[argument.find('/') :]
                if path.startswith('/') and not os.path.exists(Path(path)):
                    wanted[path] = wanted.get(path) or process.position
    reported = {d.hint for d in evaluation.diagnostics}
    for path, position in wanted.items():
        owner = context.locator.owner(path)
        if owner is None or owner.name in context.remote_only:
            continue
        from colcon_yamllaunch.workspace.packages import missing_files

        found = missing_files.not_installed(context.locator, path)
        if found is not None and found.hint not in reported:
            reported.add(found.hint)
            yield Diagnostic('warning', found.problem, position, found.hint)


def _build(
    context: LaunchContext,
    wanted: set[str],
    target: Target,
    evaluation: Evaluation,
    warned: list[Diagnostic],
) -> bool:
    """Build what is stale, and return whether that changed anything."""

    def look_first() -> None:
        _stop_at_unknown_executables(context, evaluation)
        if not evaluation.errors:
            # files that the build may install are no problem yet
            certain = [
                d for d in evaluation.diagnostics if not d.may_pass_after_build
            ]
            _warn(context, certain, warned)

    if evaluation.growing is None:
        # processes that a build leaves are those that were not there before
        context.release_worker()
    quiet = context.options.quiet
    output = io.StringIO()
    with redirect_stdout(output) if quiet else nullcontext():
        update = context.builds.update(
            wanted, Path(target.name).name, look_first
        )
    if update.returncode:
        say(update.failure())
        if quiet:
            # as without --quiet, with the colours of the compiler
            print(output.getvalue().rstrip(), file=sys.stderr, flush=True)
        raise GiveUpError(update.returncode, is_build=True)
    if update.changed:
        # it may have imported modules that were built again
        context.end_worker()
    return update.changed


def undeclared_packages(
    packages: Mapping[str, Position], locator: PackageLocator
) -> Iterator[Diagnostic]:
    """
    Find packages that a launch file uses, but its package does not declare.

    They are built all the same; but other tools would not know of them.

    :param packages: The packages that are used, and where first
    """
    for name, position in packages.items():
        owner = locator.package_of(position.path)
        if owner is None or owner.name == name:
            continue
        # only these have a manifest to declare anything in
        is_ros = owner.type.startswith('ros.')
        if is_ros and name not in owner.build_depends | owner.run_depends:
            yield Diagnostic(
                'warning',
                f"{owner.name} uses the package '{name}' here, but its "
                'package.xml does not declare it',
                position,
                f'add <exec_depend>{name}</exec_depend>',
                len(name),
            )


def missing_executables(
    uses: Iterable[ExecutableUse],
    locator: PackageLocator,
    when: Literal['now', 'built', 'certainly'],
) -> Iterator[Diagnostic]:
    """
    Find programs that packages do not have.

    :param when: `now`, after a build if that would not bring them either
      (`built`), or only those of which the source tells so (`certainly`)
    """
    for use in uses:
        from colcon_yamllaunch.workspace.packages import missing_files

        explain = {
            'now': missing_files.missing_executable,
            'built': missing_files.unknown_executable,
            'certainly': missing_files.certainly_unknown_executable,
        }[when]
        found = explain(locator, use.package, use.name)
        if found is not None:
            yield _error(found, use.position, use.name)


def _error(found: UserError, at: Position, name: str) -> Diagnostic:
    """Return an error about a name in a launch file."""
    return Diagnostic('error', found.problem, at, found.hint, len(name))


def missing_plugins(
    uses: Iterable[PluginUse],
    locator: PackageLocator,
    when: Literal['now', 'built'],
) -> Iterator[Diagnostic]:
    """
    Find components that packages do not have.

    :param when: `now`, or after a build if that would not bring them either
    """
    for use in uses:
        from colcon_yamllaunch.workspace.packages import missing_files

        explain = missing_files.missing_plugin
        if when == 'built':
            explain = missing_files.unknown_plugin
        if locator.prefix(use.package) is None:
            found = locator.no_package(use.package)
            yield _error(found, use.package_position, use.package)
        elif use.plugin is not None:
            missing = explain(locator, use.package, use.plugin)
            if missing is not None:
                yield Diagnostic(
                    'error' if missing.is_certain else 'warning',
                    missing.reason,
                    use.position,
                    length=len(use.plugin),
                )


def missing_programs(
    processes: Iterable[Process],
    uses: Mapping[str, ProgramUse],
    locator: PackageLocator,
    environment: Mapping[str, str],
    severity: Severity = 'warning',
) -> Iterator[Diagnostic]:
    """
    Find processes whose program this machine lacks, and not a package.

    The launch goes on without them, as in ROS 2.

    :param processes: Those that run on this machine
    :param uses: Where launch files name their programs, if that is known
    :param environment: The environment of the launch, for its `PATH`
    """
    for process in processes:
        name = process.argv[0]
        if not isinstance(name, str) or isinstance(name, LeftOpen):
            continue
        variables = {**environment, **dict(process.environment)}
        path = variables.get('PATH') or os.defpath
        file = os.path.join(process.cwd, name) if '/' in name else name
        if shutil.which(file, path=path) or locator.owner(file):
            continue
        use = uses.get(process.ros_name)
        place = use.place if use else ValuePlace(process.position, 1, ())
        where = '' if '/' in name else ' on the PATH'
        yield Diagnostic(
            severity,
            f"there is no executable '{name}'{where}, so {process.label} "
            'cannot be started',
            place.position,
            (use and use.hint) or way_to_program(name, process.cwd),
            place.length,
            place.includes,
        )
