# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a launch needs before it runs: a plan, and all that it names."""

from collections.abc import Iterable
from collections.abc import Mapping
from contextlib import nullcontext
from contextlib import redirect_stdout
import io
import os
from pathlib import Path
import sys

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.control.socket_folder import has_sockets
from colcon_yamllaunch.language.policies.evaluate import evaluate
from colcon_yamllaunch.language.policies.evaluate import Evaluation
from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.verb import preflight
from colcon_yamllaunch.verb.context import GiveUpError
from colcon_yamllaunch.verb.context import LaunchContext
from colcon_yamllaunch.verb.messages import say
from colcon_yamllaunch.verb.target import Target

#: How often what a build brought may make more packages necessary.
MAXIMUM_ROUNDS = 5


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
    # what need not be here is known once it is known what runs here
    is_final = not may_build and machines is None
    if machines is not None:
        machines.expect()
    for _ in range(MAXIMUM_ROUNDS):
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
                machines.bring_code(evaluation, named)
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
        if is_final and all(
            _exists(context, path) for path in context.packages.expected
        ):
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
        plan = machines.settled(plan)
    warn_of_missing_programs(context, plan, request.environment)
    return plan, request.environment


def explain(
    context: LaunchContext, target: Target, evaluation: Evaluation
) -> None:
    """Say what would be built for the launch, and why."""
    if context.workspace.root is not None:
        wanted = _wanted(context, target, evaluation)
        context.builds.explain(wanted, Path(target.name).name)


def warn_of_doubled_nodes(
    context: LaunchContext, plan: Plan, environment: Mapping[str, str]
) -> None:
    """Warn of nodes that another launch of the user runs already."""
    if context.is_again or not has_sockets(context.environment):
        return
    from colcon_yamllaunch.verb import doubled_nodes

    file = context.about().file
    for other in doubled_nodes.running(context.environment):
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
        preflight.missing_programs(
            plan.processes(), uses, context.locator, environment
        )
    )


def stop_at_unknown_executables(
    context: LaunchContext, evaluation: Evaluation
) -> None:
    """
    Stop at programs that no build brings, as the source tells.

    :raises GiveUpError: when there are some
    """
    found = preflight.missing_executables(
        evaluation.executables, context.locator, 'certainly'
    )
    if errors := list(found):
        context.fail(errors)


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
        return workspace.package_names - context.only_there
    if options.paths:
        return set(workspace.select(options.paths, context.cwd))
    return _named(context, target, evaluation) - context.only_there


def _exists(context: LaunchContext, path: str) -> bool:
    """Return whether a path exists, or need not exist here."""
    if os.path.exists(Path(path)):
        return True
    owner = context.locator.owner(path)
    return owner is not None and owner.name in context.only_there


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
    found = preflight.missing_plugins(uses, context.locator, 'built')
    errors = [d for d in found if d.severity == 'error']
    if errors:
        context.fail([*evaluation.diagnostics, *errors])


def _stop_at_errors(
    context: LaunchContext, target: Target, evaluation: Evaluation
) -> None:
    errors = evaluation.errors
    if all(error.may_pass_after_build for error in errors):
        # what is missing may be missing for this reason
        needed = _named(context, target, evaluation) - context.only_there
        context.workspace.check_sourced(
            sorted(needed), may_build=not context.options.no_build
        )
    if errors:
        context.fail(evaluation.diagnostics)


def _check_before_start(
    context: LaunchContext, evaluation: Evaluation
) -> None:
    """Stop at what is missing though all has been built."""
    locator = context.locator
    found = [
        *preflight.undeclared_packages(evaluation.packages, locator),
        *preflight.preflight(
            evaluation,
            context.packages.not_installed,
            locator,
            context.only_there,
        ),
    ]
    if any(d.severity == 'error' for d in found):
        context.fail(found)
    context.report(found)


def _build(
    context: LaunchContext,
    wanted: set[str],
    target: Target,
    evaluation: Evaluation,
    warned: list[Diagnostic],
) -> bool:
    """Build what is stale, and return whether that changed anything."""
    from colcon_yamllaunch.verb.builds import failure

    def look_first() -> None:
        stop_at_unknown_executables(context, evaluation)
        if not evaluation.errors:
            # what a build brings is missing in vain only after it
            certain = [
                d for d in evaluation.diagnostics if not d.may_pass_after_build
            ]
            _warn(context, certain, warned)

    if evaluation.growing is None:
        # what builds leave running is told apart by what was there before
        context.release_worker()
    quiet = context.options.quiet
    output = io.StringIO()
    with redirect_stdout(output) if quiet else nullcontext():
        update = context.builds.update(
            wanted, Path(target.name).name, look_first
        )
    if update.returncode:
        say(failure(update))
        if quiet:
            # as without --quiet, with the colours of the compiler
            print(output.getvalue().rstrip(), file=sys.stderr, flush=True)
        raise GiveUpError(update.returncode, is_build=True)
    if update.changed:
        # it may have imported what is another now
        context.end_worker()
    return update.changed
