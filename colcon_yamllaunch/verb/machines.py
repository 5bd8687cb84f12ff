# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The machines of a launch, from the first connection to the running parts.

For each machine: connect, send code while this computer builds its own part,
check that the files of the plan exist, start the part. All machines do so at
once, each in a thread. When the launch runs, all threads have ended.
"""

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import replace
from functools import cached_property
import hashlib
from importlib import import_module
import threading
from typing import Generic, TypeVar

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.deployment.deployment import Deployment
from colcon_yamllaunch.deployment.placement import (
    PlacedPlan,
    Placer,
    rules_in_vain,
)
from colcon_yamllaunch.engine.readiness import needs_readiness
from colcon_yamllaunch.language.policies.evaluate import Evaluation
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.plan.plan import Entry, Plan
from colcon_yamllaunch.plan.start_order import dependencies_of
from colcon_yamllaunch.remote.connection.machine_connection import MachineFacts
from colcon_yamllaunch.remote.launch_machine import Launcher, LaunchMachine
from colcon_yamllaunch.remote.part_protocol import PartSettings
from colcon_yamllaunch.remote.plan_references import files_of, packages_of
from colcon_yamllaunch.remote.remote_parts import RemoteParts
from colcon_yamllaunch.remote.sync.code_sync import Code, Synced
from colcon_yamllaunch.verb.context import LaunchContext
from colcon_yamllaunch.verb.log_folders import log_store_of
from colcon_yamllaunch.watch.dependencies import Products, RemoteDependencies
from colcon_yamllaunch.workspace.packages.package import closure

#: Seconds that a thread may take to end once its connection is closed.
CLOSE_TIMEOUT = 15.0

_Result = TypeVar('_Result')


class Tasks(Generic[_Result]):
    """
    A function that is called for several machines at once, in threads.

    :param function: What to call with each machine; it begins at once
    """

    def __init__(
        self,
        machines: Iterable[LaunchMachine],
        function: Callable[[LaunchMachine], _Result],
    ) -> None:
        #: The results by machine, and the errors of the others.
        self.results: dict[str, _Result] = {}
        self.errors: dict[str, Exception] = {}
        self._function = function
        self._threads = {
            machine.name: threading.Thread(
                target=self._run, args=(machine,), daemon=True
            )
            for machine in machines
        }
        for thread in self._threads.values():
            thread.start()

    def wait(self, seconds: float | None = None) -> None:
        """
        Wait until all is done; a signal may end that.

        :param seconds: How long for each at most, None for ever
        """
        for thread in self._threads.values():
            thread.join(seconds)

    def check(self) -> dict[str, _Result]:
        """
        Wait, and return the results.

        :raises UserError: when any task failed, with all that went wrong
        """
        self.wait()
        for error in self.errors.values():
            if not isinstance(error, UserError):
                raise error
        # in the order of the machines
        found = [self.errors[n] for n in self._threads if n in self.errors]
        if found:
            raise UserError('\n'.join(dict.fromkeys(map(str, found))))
        return self.results

    def _run(self, machine: LaunchMachine) -> None:
        try:
            self.results[machine.name] = self._function(machine)
        except Exception as e:  # noqa: BLE001
            # for the main thread
            self.errors[machine.name] = e


class Machines:
    """
    The machines that parts of a launch run on.

    :param deployment: Which machines there are, and what runs on them
    """

    def __init__(self, context: LaunchContext, deployment: Deployment) -> None:
        self._context = context
        self._session = context.workspace
        self._launcher = Launcher(
            context.workspace,
            context.environment,
            context.cwd,
            context.log_folder,
            builds=not context.options.no_build,
            quiet=context.options.quiet,
        )
        self._deployment = deployment
        # the machines that are connected, or about to be
        self._machines: dict[str, LaunchMachine] = {}
        # connects with the machines that are probably needed
        self._early: Tasks[MachineFacts] = Tasks((), LaunchMachine.connect)
        # sends code
        self._syncing: Tasks[Synced] | None = None
        # the packages that each machine needs, and those to send when they
        # are built here
        self._needed: Mapping[str, frozenset[str]] = {}
        self._late: dict[str, frozenset[str]] = {}
        self._placer = Placer(deployment)
        self._parts: RemoteParts | None = None
        #: The packages that are not built here, as nothing here needs them.
        self.remote_only: frozenset[str] = frozenset()
        #: The packages that were built there.
        self.built: frozenset[str] = frozenset()
        #: The machines that parts of it run on.
        self.used: frozenset[str] = frozenset()
        #: What runs there, and the code that is there, with `--watch`.
        self.dependencies: RemoteDependencies | None = None
        self.records: Products = {}

    def place(self, plan: Plan) -> PlacedPlan:
        """
        Cut a plan, and forget what was placed before.

        :raises GiveUpError: when the deployment does not fit the plan
        """
        self._placer = Placer(self._deployment)
        try:
            return self._placer.place(plan)
        except LaunchError as e:
            self._context.fail(e.diagnostics)

    def check_more(self, entries: Iterable[Entry]) -> None:
        """
        Check that entries that are added later fit the deployment.

        :raises LaunchError: when they do not
        """
        self._placer.place_more(entries)

    def connect_early(self) -> None:
        """
        Begin to connect with the machines that the launch probably needs.

        Errors are reported only for machines that it really needs. Slurm is
        not asked, as it may have to make room first.
        """
        self._early = self._begin_to_connect(
            [
                name
                for name in self._meant_machines()
                if self._deployment.machines[name].kind != 'slurm'
            ]
        )

    def begin_sync(
        self,
        plan: Plan,
        evaluation: Evaluation | None = None,
        named: Collection[str] | None = None,
    ) -> None:
        """
        Connect with the machines of a launch, and begin to send code to them.

        What was begun before goes on.

        :param evaluation: The evaluation that the plan is of; None for a
          saved plan
        :param named: The packages of the workspace that the launch names; by
          default those that the plan names
        :raises UserError: when a machine cannot be reached
        """
        placed = self.place(plan)
        packages = frozenset(
            self._packages_of(plan) if named is None else named
        )
        needed = {n: self._packages_of(p) for n, p in placed.parts.items()}
        if evaluation is not None and evaluation.growing is not None:
            # more may be started on machines that have nothing yet
            needed = dict.fromkeys(self._meant_machines(), packages)
        elif self._deployment.everything_on is not None:
            needed = dict.fromkeys(placed.parts, packages)
        self._needed = needed
        self._connect(needed)
        self._sync_changed(needed)
        # programs that were run here may need any package
        if evaluation is not None and not evaluation.has_run_programs:
            there: set[str] = set()
            here = set(self._packages_of(placed.local))
            for name, packages in needed.items():
                if self._machines[name].gets_local_builds:
                    here |= packages
                else:
                    there |= packages
            self.remote_only = frozenset(there - here)

    def finish_sync(self, plan: Plan) -> Plan:
        """
        Wait for the code on the machines, and check the parts of a plan there.

        Packages that are built here are sent only now, so build them before.
        Return the plan with the names of machines in its labels.

        :raises GiveUpError: when a machine lacks a file that its part needs
        :raises UserError: when code could not be sent
        """
        context = self._context
        placed = self.place(plan)
        context.report(rules_in_vain(placed.whole, self._deployment))
        self._wait_for_sync()
        late, self._late = self._late, {}
        self._start_sync(late)
        self._wait_for_sync()
        checked = Tasks(
            self._machines.values(), lambda m: m.check(placed.part(m.name))
        ).check()
        context.report_or_fail(
            found for name in self._machines for found in checked[name]
        )
        self.used = frozenset(placed.parts)
        if context.options.watch is not None:
            self.dependencies = self._dependencies_of(placed)
            self.records = self._read_records(self.dependencies)
        return placed.whole

    @property
    def digest(self) -> str:
        """A hash of what the deployment says about machines."""
        known = self._deployment
        machines = [replace(m, position=None) for m in known.machines.values()]
        rules = [
            (str(rule), rule.machine)
            for rule in known.rules
            if rule.machine is not None
        ]
        text = repr((machines, rules, known.everything_on))
        return hashlib.sha256(text.encode()).hexdigest()

    def start(
        self, plan: Plan, *, is_growing: bool
    ) -> tuple[Plan, RemoteParts]:
        """
        Start the parts; return what runs here, and the started parts.

        :param plan: As :meth:`finish_sync` has returned it
        :param is_growing: Whether more may come while it runs, for any machine
        :raises UserError: when a part cannot be started
        """
        placed = self.place(plan)
        names = list(self._machines if is_growing else placed.parts)
        machines = {name: self._machines[name] for name in names}
        settings = self._settings()
        if self._context.options.until_ready or needs_readiness(placed.whole):
            after = dependencies_of(placed.whole.members())
            settings = replace(settings, after=after)
        starting = Tasks(
            machines.values(),
            lambda m: m.start(placed.part(m.name), settings),
        )
        try:
            links = starting.check()
        except BaseException:
            self._close_connections()
            starting.wait(CLOSE_TIMEOUT)
            for link in starting.results.values():
                link.close()
            raise
        for name in names:
            # from here on its connection is the launch's
            del self._machines[name]
        self._close_connections()
        self._parts = RemoteParts(
            [links[name] for name in names],
            placed,
            self._placer.place_more,
            lambda name, part: machines[name].plan(part),
        )
        return placed.local, self._parts

    def detach(self) -> None:
        """Leave the parts to the parent, in a fork of its process."""
        if self._parts is not None:
            self._parts.detach_fork()

    def close(self) -> None:
        """Close all connections, which ends the parts on the machines."""
        if self._parts is not None:
            self._parts.close()
        self._close_connections()

    def _close_connections(self) -> None:
        closing = Tasks(self._machines.values(), LaunchMachine.close)
        closing.wait(CLOSE_TIMEOUT)
        self._machines.clear()
        self._early.wait(CLOSE_TIMEOUT)
        if self._syncing is not None:
            self._syncing.wait(CLOSE_TIMEOUT)

    def _packages_of(self, plan: Plan) -> frozenset[str]:
        session = self._session
        if session.root is None:
            return frozenset()
        return packages_of(
            plan, session.locator, session.root, session.colcon.install_base
        )

    def _sync_changed(self, needed: Mapping[str, frozenset[str]]) -> None:
        """Send packages to the machines that need more than they have."""
        wanted = {}
        for name, packages in needed.items():
            known = self._machines[name].packages
            if known is None or not packages <= known:
                wanted[name] = packages | (known or frozenset())
        if not wanted or self._session.root is None:
            return
        self._wait_for_sync()
        for name, packages in wanted.items():
            self._machines[name].packages = packages
        for name in list(wanted):
            # it is built here first
            if self._machines[name].gets_local_builds:
                self._late[name] = wanted.pop(name)
        self._start_sync(wanted)

    def _start_sync(self, wanted: Mapping[str, frozenset[str]]) -> None:
        if wanted:
            # before threads start
            code = self._code
            self._syncing = Tasks(
                [self._machines[name] for name in wanted],
                lambda m: m.receive_code(wanted[m.name], code),
            )

    def _wait_for_sync(self) -> None:
        """
        Wait until the machines have the code that is being sent.

        :raises UserError: when it cannot be sent
        """
        syncing, self._syncing = self._syncing, None
        if syncing is None:
            return
        syncing.wait()
        for name in syncing.errors:
            self._machines[name].say_unseen()
        for synced in syncing.check().values():
            self.built |= synced.built

    @cached_property
    def _code(self) -> Code:
        """The code that is here."""
        session = self._session
        colcon = session.colcon
        return Code(
            colcon.root,
            tuple(session.packages),
            colcon.build_base,
            colcon.install_base,
            merge_install=colcon.merge_install,
            build_arguments=colcon.build_arguments,
            settings=colcon.common_settings,
            environment=session.environment,
            title=f'colcon launch {self._context.options.title}',
        )

    def _dependencies_of(self, placed: PlacedPlan) -> RemoteDependencies:
        """Return what the parts of the machines use."""
        files = {}
        for name, part in placed.parts.items():
            covers = self._machines[name].folders.covers
            for process in part.processes():
                files[process.label] = files_of(process, covers)
            for component in part.components():
                files[component.label] = files_of(component, covers)
        packages = {
            name: frozenset(closure(self._session.packages, names))
            for name, names in self._needed.items()
            if names
        }
        is_off = self._context.options.no_build
        # nothing here changes the code of these
        unsynced = [
            name
            for name in packages
            if self._machines[name].sync_mode == 'none'
            and not self._machines[name].shares_workspace
        ]
        return RemoteDependencies(
            placed.machines,
            files,
            packages,
            dict.fromkeys(unsynced, '--no-build' if is_off else 'sync: none'),
        )

    def _read_records(self, used: RemoteDependencies) -> Products:
        """
        Return the code that the machines have, see `LaunchMachine.contents`.

        :raises UserError: when a machine cannot be asked
        """

        def read(machine: LaunchMachine) -> Mapping[str, Mapping[str, str]]:
            name = machine.name
            labels = [n for n, m in used.machines.items() if m == name]
            files = {path for label in labels for path in used.files[label]}
            packages = used.packages.get(name, frozenset())
            is_synced = name not in used.unsynced
            return machine.contents(files, packages if is_synced else ())

        found = Tasks(self._machines.values(), read).check()
        return {
            k: v for contents in found.values() for k, v in contents.items()
        }

    def _meant_machines(self) -> list[str]:
        """Return the machines that anything may run on."""
        meant = {rule.machine for rule in self._deployment.rules}
        meant.add(self._deployment.everything_on or '')
        return [name for name in self._deployment.machines if name in meant]

    def _connect(self, needed: Collection[str]) -> None:
        """
        Connect with machines, all at once, and with no others.

        :raises UserError: when one cannot be reached
        """
        expected, self._early = (
            self._early,
            Tasks((), LaunchMachine.connect),
        )
        for name, machine in list(self._machines.items()):
            if not machine.is_ready and name not in needed:
                self._machines.pop(name).close()
        others = self._begin_to_connect(
            [name for name in needed if name not in self._machines]
        )
        names = [n for n in needed if not self._machines[n].is_ready]
        if names:
            # this computer has nothing else to do meanwhile
            import_module('colcon_yamllaunch.run')
        facts: dict[str, MachineFacts] = {}
        may_ask = not self._context.is_again
        for tasks in (expected, others):
            tasks.wait()
            for name in list(tasks.errors):
                if name not in names:
                    del tasks.errors[name]
                # one after the other, as each asks at the terminal; who typed
                # at a launch that runs would be heard by its processes
                elif may_ask and self._machines[name].connection.must_ask:
                    again = self._machine(name, may_ask=True)
                    facts[name] = again.connect()
                    del tasks.errors[name]
            facts |= tasks.check()
        for name in names:
            self._machines[name].use(facts[name])

    def _begin_to_connect(self, names: Collection[str]) -> Tasks[MachineFacts]:
        machines = [self._machine(name) for name in names]
        return Tasks(machines, LaunchMachine.connect)

    def _machine(self, name: str, *, may_ask: bool = False) -> LaunchMachine:
        machine = LaunchMachine(
            self._launcher, self._deployment.machines[name], may_ask=may_ask
        )
        self._machines[name] = machine
        return machine

    def _settings(self) -> PartSettings:
        """Return what is the same for the parts on all machines."""
        options, folder = self._context.options, self._context.log_folder
        settings = PartSettings(
            '', log_limit=options.log_limit, tty=options.tty
        )
        if folder is None:
            return settings
        settings = replace(settings, log_name=folder.name)
        # the launch here warns of invalid values
        store = log_store_of(folder, self._context.environment, lambda _: None)
        if store is None:
            return settings
        return replace(settings, kept_logs=store.kept, logs_limit=store.limit)
