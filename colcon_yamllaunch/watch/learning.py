# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a launch uses, learnt from its plan and from what was built."""

from collections.abc import Iterable
from collections.abc import Mapping
from dataclasses import replace
import os
from pathlib import Path

from colcon_yamllaunch.language.policies.evaluate import Evaluation
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.watch.knowledge import Knowledge
from colcon_yamllaunch.watch.knowledge import RunsThere
from colcon_yamllaunch.watch.package_uses import package_use
from colcon_yamllaunch.watch.package_uses import Workspace
from colcon_yamllaunch.watch.process_uses import ProcessUses
from colcon_yamllaunch.workspace.packages.closure import closure
from colcon_yamllaunch.workspace.packages.package import Package


def knowledge_of(
    plan: Plan,
    evaluation: Evaluation,
    workspace: Workspace,
    wanted: Iterable[str],
    libraries: Mapping[str, frozenset[str] | None],
    environment: Mapping[str, str],
    there: RunsThere | None = None,
) -> Knowledge:
    """
    Return what a launch uses.

    :param plan: Its plan, with the labels that are in use
    :param evaluation: What the plan was made from
    :param wanted: The packages of the workspace that it names
    :param libraries: What is known of the files mapped into processes
    :param environment: The environment of the processes
    :param there: What of it runs on other machines
    """
    there = there or RunsThere()
    packages: list[Package] = []
    products: set[str] = set()
    folders: list[Path] = []
    install = os.sep
    if workspace.root is not None:
        for base in (
            workspace.colcon.build_base,
            workspace.colcon.install_base,
        ):
            products |= {str(base), os.path.realpath(base)}
        by_name = {p.name: p for p in workspace.locator.packages()}
        install = f'{workspace.colcon.install_base}{os.sep}'
        needed = frozenset(wanted).union(*there.packages.values())
        names = closure(by_name.values(), needed)
        packages = [by_name[name] for name in names]
        folders = [workspace.root, *(package.path for package in packages)]
    own = tuple(f'{os.path.realpath(p)}{os.sep}' for p in folders)
    uses = ProcessUses(
        plan, packages, libraries, environment, install, own, there
    )
    read = [*(file.path for file in evaluation.files), *evaluation.inputs]
    return Knowledge(
        tuple(uses.all()),
        tuple(
            replace(
                package_use(package, workspace),
                machines=tuple(
                    machine
                    for machine, names in there.packages.items()
                    if package.name in names
                ),
                share=workspace.locator.share(package.name) or '',
            )
            for package in packages
        ),
        frozenset(map(os.path.realpath, read)),
        reads_more=evaluation.has_run_programs,
        is_plan_broken=bool(evaluation.errors),
        products=tuple(sorted(products)),
        files_there=frozenset[str]().union(*there.files.values()),
        kept=there.kept,
    )
