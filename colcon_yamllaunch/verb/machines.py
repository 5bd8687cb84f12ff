# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The machines of a launch, from the first connection to the running parts.

In this order: they are connected with, get their code while this computer
builds what it needs itself, are asked for what the plan names, and start their
parts. All of them do so at once, each in a thread. When the launch runs there
are no threads any more.
"""

from collections import deque
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
import hashlib
from importlib import import_module
import threading
from typing import Any, Generic, TypeVar

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.language.policies.evaluate import Evaluation
from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic
from colcon_yamllaunch.plan.labels import MACHINE_SEPARATOR
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.remote.connection.connection_errors import no_workspace
from colcon_yamllaunch.remote.connection.machine_connection import (
    Facts,
    MachineConnection,
)
from colcon_yamllaunch.remote.deployment.deployment import Deployment, Machine
from colcon_yamllaunch.remote.deployment.placement import (
    Placed,
    Placer,
    rules_in_vain,
)
from colcon_yamllaunch.remote.deployment.remote_paths import (
    RemotePaths,
    sent_variables,
)
from colcon_yamllaunch.remote.machine_link import MachineLink
from colcon_yamllaunch.remote.part_protocol import PartSettings
from colcon_yamllaunch.remote.remote_parts import RemoteParts
from colcon_yamllaunch.remote.sync.code_sync import Code, sync_code, Synced
from colcon_yamllaunch.verb.context import LaunchContext
from colcon_yamllaunch.verb.log_folders import log_store_of
from colcon_yamllaunch.verb.machine_paths import (
    files_of,
    MachinePaths,
    packages_of,
)
from colcon_yamllaunch.verb.messages import say
from colcon_yamllaunch.verb.prepare import stop_at_unknown_executables
from colcon_yamllaunch.watch.dependencies import Products, RemoteDependencies
from colcon_yamllaunch.workspace.packages.package import closure

#: Seconds that the clocks of a machine and this computer may differ.
CLOCKS = 0.1
#: How many lines of a machine are kept that nobody sees unless it fails.
UNSEEN = 1000
#: Seconds that a thread may take to end once its connection is closed.
CLOSE_TIMEOUT = 15.0

_Result = TypeVar('_Result')


class Tasks(Generic[_Result]):
    """
    What is done for several machines at once, each in a thread.

    :param functions: What to call, by the machine; they begin at once
    """

    def __init__(self, functions: Mapping[str, Callable[[], _Result]]) -> None:
        #: What those that succeeded returned, and the errors of the others.
        self.results: dict[str, _Result] = {}
        self.errors: dict[str, Exception] = {}
        self._threads = {
            name: threading.Thread(
                target=self._run, args=(name, function), daemon=True
            )
            for name, function in functions.items()
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

    def _run(self, name: str, function: Callable[[], _Result]) -> None:
        try:
            self.results[name] = function()
        except Exception as e:  # noqa: BLE001
            # for the main thread
            self.errors[name] = e


class Machines:
    """
    The machines that parts of a launch run on.

    :param deployment: Which machines there are, and what runs on them
    """

    def __init__(self, context: LaunchContext, deployment: Deployment) -> None:
        self._context = context
        self._session = context.workspace
        self._deployment = deployment
        # what machines have said that nobody saw
        self._unseen: dict[str, deque[str]] = {}
        self._connections: dict[str, MachineConnection] = {}
        self._paths: dict[str, MachinePaths] = {}
        # what to say of those whose workspace is not there
        self._lacks: dict[str, UserError] = {}
        # what connects with those that will most likely be needed
        self._expected: Tasks[Facts] = Tasks({})
        self._syncing: Tasks[Synced] = Tasks({})
        # the packages that the machines need, and have or are about to get
        self._needed: Mapping[str, frozenset[str]] = {}
        self._brought: dict[str, frozenset[str]] = {}
        # those that are brought when all is built here
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

    def place(self, plan: Plan) -> Placed:
        """Cut a plan, and forget what was placed before."""
        self._placer = Placer(self._deployment)
        return self._placer.place(plan)

    def expect(self) -> None:
        """
        Begin to connect with the machines that will most likely be needed.

        What goes wrong matters only with those that are. Nothing is asked of
        Slurm, which may have to make room for it.
        """
        self._expected = self._begin_to_connect(
            [
                name
                for name in self._meant_machines()
                if self._deployment.machines[name].kind != 'slurm'
            ]
        )

    def bring_code(
        self, evaluation: Evaluation, named: Collection[str]
    ) -> None:
        """
        Connect with the machines of a launch, and begin to bring the code.

        What was begun before goes on.

        :param named: The packages of the workspace that the launch names
        :raises GiveUpError: when no build brings a program of it
        :raises UserError: when a machine cannot be reached
        """
        stop_at_unknown_executables(self._context, evaluation)
        placed = self.place(evaluation.plan)
        self._needed = self._packages_needed(
            placed, frozenset(named), is_growing=evaluation.growing is not None
        )
        self._begin(self._needed)
        # what was run here may need any of them
        if not evaluation.has_run_programs:
            self.remote_only = self._not_needed_here(placed)

    def bring_code_of(self, plan: Plan) -> None:
        """
        Do so for a saved plan.

        :raises UserError: when a machine cannot be reached
        """
        packages = self._packages_of(plan)
        self._begin(
            self._packages_needed(self.place(plan), packages, is_growing=False)
        )

    def settled(self, plan: Plan) -> Plan:
        """
        Return a plan as it is known by its users, with names of machines.

        All that its parts need is there then. What is installed here is
        brought only now, so all is to be built here before.

        :raises GiveUpError: when something that they need is not
        :raises UserError: when the code could not be brought
        """
        context = self._context
        context.report(rules_in_vain(plan, self._deployment))
        placed = self.place(plan)
        self._wait()
        late, self._late = self._late, {}
        self._bring_all(late)
        self._wait()
        checked = Tasks(
            {
                name: partial(self._check, name, placed.part(name))
                for name in self._connections
            }
        ).check()
        found = [d for name in self._connections for d in checked[name]]
        if any(d.severity == 'error' for d in found):
            context.fail(found)
        context.report(found)
        self.used = frozenset(placed.parts)
        if context.options.watch is not None:
            self.dependencies = self._dependencies_of(placed)
            self.records = self._read_records(self.dependencies)
        return placed.whole

    @property
    def digest(self) -> str:
        """A hash of the deployment, but for where it is written."""
        known = self._deployment
        machines = [replace(m, position=None) for m in known.machines.values()]
        rules = [(str(rule), rule.machine) for rule in known.rules]
        text = repr((machines, rules, known.everything_on))
        return hashlib.sha256(text.encode()).hexdigest()

    def start(
        self, plan: Plan, *, is_growing: bool
    ) -> tuple[Plan, RemoteParts]:
        """
        Start the parts, and return what of the plan runs here besides.

        :param plan: As :meth:`settled` has returned it
        :param is_growing: Whether more may come while it runs, for any machine
        :raises UserError: when a part cannot be started
        """
        placed = self.place(plan)
        names = list(self._connections if is_growing else placed.parts)
        settings = self._settings()
        starting = Tasks(
            {
                name: partial(self._start, name, placed.part(name), settings)
                for name in names
            }
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
            # from here on it is the launch's
            del self._connections[name]
        self._close_connections()
        self._parts = RemoteParts(
            [links[name] for name in names],
            placed,
            self._placer.place_more,
            lambda name, part: self._paths[name].plan(part),
        )
        return placed.local, self._parts

    def detach(self) -> None:
        """Leave the parts to the parent, in a fork of its process."""
        if self._parts is not None:
            self._parts.detach_fork()

    def close(self) -> None:
        """End all connections, and what runs there."""
        if self._parts is not None:
            self._parts.close()
        self._close_connections()

    def _close_connections(self) -> None:
        closing = {n: c.close for n, c in self._connections.items()}
        Tasks(closing).wait(CLOSE_TIMEOUT)
        self._connections.clear()
        self._expected.wait(CLOSE_TIMEOUT)
        self._syncing.wait(CLOSE_TIMEOUT)

    def _packages_needed(
        self, placed: Placed, named: frozenset[str], *, is_growing: bool
    ) -> dict[str, frozenset[str]]:
        """
        Return the packages of the workspace that the machines need.

        :param named: Those that the launch names
        :param is_growing: Whether more may come while it runs, for machines
          that have nothing yet, too
        """
        if is_growing:
            return dict.fromkeys(self._meant_machines(), named)
        if self._deployment.everything_on is not None:
            return dict.fromkeys(placed.parts, named)
        return {
            name: self._packages_of(part)
            for name, part in placed.parts.items()
        }

    def _not_needed_here(self, placed: Placed) -> frozenset[str]:
        """Return the packages that need not be built here; once connected."""
        there: set[str] = set()
        here = set(self._packages_of(placed.local))
        for name, packages in self._needed.items():
            if self._gets_what_is_built_here(name):
                here |= packages
            else:
                there |= packages
        return frozenset(there - here)

    def _begin(self, needed: Mapping[str, frozenset[str]]) -> None:
        """
        Connect with the machines, and begin to bring the code there.

        :param needed: The packages of the workspace that the machines need
        :raises UserError: when a machine cannot be reached
        """
        self._connect([name for name in needed if name not in self._paths])
        wanted = {
            name: names | self._brought.get(name, frozenset())
            for name, names in needed.items()
            if not names <= self._brought.get(name, frozenset())
            or name not in self._brought
        }
        if not wanted or self._session.root is None:
            return
        self._wait()
        self._brought |= wanted
        late = [n for n in wanted if self._gets_what_is_built_here(n)]
        # that is made here first
        self._late |= {name: wanted.pop(name) for name in late}
        self._bring_all(wanted)

    def _dependencies_of(self, placed: Placed) -> RemoteDependencies:
        """Return what the parts of the machines use."""
        files = {}
        for name, part in placed.parts.items():
            covers = self._paths[name].folders.covers
            for process in part.processes():
                files[process.label] = files_of(process, covers)
            for component in part.components():
                files[component.label] = files_of(component, covers)
        packages = {
            name: frozenset(closure(self._session.packages, names))
            for name, names in self._needed.items()
            if names
        }
        why = '--no-build' if self._brings_nothing else 'sync: none'
        # nothing here changes the code of these
        unsynced = [
            name
            for name in packages
            if self._mode_of(name) == 'none' and not self._shares(name)
        ]
        return RemoteDependencies(
            placed.machines, files, packages, dict.fromkeys(unsynced, why)
        )

    def _read_records(self, used: RemoteDependencies) -> Products:
        """
        Return the code that the machines have.

        It is by the machine and package, as `arm│my_pkg`, and `arm│` for files
        that are named; the files by the machine and the paths that they would
        have here.

        :raises UserError: when a machine cannot be asked
        """
        files: dict[str, set[str]] = {}
        for label, machine in used.machines.items():
            files.setdefault(machine, set()).update(used.files[label])
        packages = {
            name: packages
            for name, packages in used.packages.items()
            if name not in used.unsynced
        }
        found = Tasks(
            {
                name: partial(
                    self._records_of,
                    name,
                    files.get(name, ()),
                    packages.get(name, ()),
                )
                for name in self._connections
            }
        ).check()
        return {
            f'{machine}{MACHINE_SEPARATOR}{package}': {
                f'{machine}{MACHINE_SEPARATOR}{path}': content
                for path, content in files.items()
            }
            for machine, packages in found.items()
            for package, files in packages.items()
        }

    def _wait(self) -> None:
        """
        Wait until the code that is on its way has arrived.

        :raises UserError: when it cannot be brought
        """
        syncing, self._syncing = self._syncing, Tasks({})
        syncing.wait()
        for name in syncing.errors:
            for line in self._unseen.pop(name, ()):
                say(line)
        for synced in syncing.check().values():
            self.built |= synced.built

    def _meant_machines(self) -> list[str]:
        """Return the machines that anything may run on."""
        meant = {rule.machine for rule in self._deployment.rules}
        meant.add(self._deployment.everything_on or '')
        return [name for name in self._deployment.machines if name in meant]

    def _connect(self, names: Sequence[str]) -> None:
        """
        Connect with machines, all at once.

        :raises UserError: when one cannot be reached
        """
        expected, self._expected = self._expected, Tasks({})
        for name in self._connections.keys() - self._paths.keys() - {*names}:
            self._connections.pop(name).close()
        others = self._begin_to_connect(
            [name for name in names if name not in self._connections]
        )
        if names:
            # this computer has nothing else to do meanwhile
            import_module('colcon_yamllaunch.run')
        facts: dict[str, Facts] = {}
        may_ask = not self._context.is_again
        for tasks in (expected, others):
            tasks.wait()
            for name in list(tasks.errors):
                if name not in names:
                    del tasks.errors[name]
                # one after the other, as each asks at the terminal; who typed
                # at a launch that runs would be heard by its processes
                elif may_ask and self._connections[name].must_ask:
                    again = self._connection_with(name, may_ask=True)
                    self._connections[name] = again
                    facts[name] = again.connect()
                    del tasks.errors[name]
            facts |= tasks.check()
        for name in names:
            self._paths[name] = self._paths_to(name, facts[name])
            self._check_workspace(name, facts[name])
            self._check_clock(name, facts[name])

    def _begin_to_connect(self, names: Sequence[str]) -> Tasks[Facts]:
        for name in names:
            self._connections[name] = self._connection_with(name)
        return Tasks({n: self._connections[n].connect for n in names})

    def _connection_with(
        self, name: str, *, may_ask: bool = False
    ) -> MachineConnection:
        machine = self._deployment.machines[name]
        return MachineConnection(
            machine,
            self._places_of_workspace(machine),
            self._context.environment,
            may_ask=may_ask,
            say=partial(self._say_of, name),
        )

    def _places_of_workspace(self, machine: Machine) -> list[str]:
        """Return where the workspace may be there, the last to make it."""
        if machine.workspace is not None:
            return [machine.workspace]
        root = self._session.root
        return [] if root is None else [str(root), f'~/{root.name}']

    def _say_of(self, name: str, line: str) -> None:
        text = f'{name}{MACHINE_SEPARATOR} {line}'
        if not self._context.options.quiet:
            self._session.announce(text)
        else:
            # it is shown if something fails there
            unseen = self._unseen.setdefault(name, deque(maxlen=UNSEEN))
            unseen.append(text)

    def _check_clock(self, name: str, facts: Facts) -> None:
        if abs(facts.ahead) - facts.delay > CLOCKS:
            order = 'ahead of' if facts.ahead > 0 else 'behind'
            self._say_of(
                name,
                f'warning: its clock is {abs(facts.ahead):.1f} s {order} that '
                'of this computer, so nodes misjudge the age of messages; '
                'help: synchronise both, as by chrony',
            )

    def _check_workspace(self, name: str, facts: Facts) -> None:
        """
        Check that a workspace that nobody brings is there.

        :raises UserError: when it is not, and was named
        """
        machine, workspace = self._deployment.machines[name], facts.workspace
        if workspace is None or facts.has_workspace:
            return
        if self._session.root is None or self._mode_of(name) == 'none':
            self._lacks[name] = no_workspace(machine, workspace)
            if machine.workspace is not None:
                raise self._lacks[name]

    def _paths_to(self, name: str, facts: Facts) -> MachinePaths:
        folders: dict[str, str] = {}
        session, log_folder = self._session, self._context.log_folder
        if session.root is not None and facts.workspace is not None:
            install_base = session.colcon.install_base
            if not install_base.is_relative_to(session.colcon.root):
                there = f'{facts.workspace}/{install_base.name}'
                folders[str(install_base)] = there
            folders[str(session.root)] = facts.workspace
        if log_folder is not None:
            base = facts.workspace or f'{facts.home}/.ros'
            folders[str(log_folder)] = f'{base}/log/{log_folder.name}'
        return MachinePaths(
            self._deployment.machines[name],
            RemotePaths(folders),
            str(self._context.cwd),
            facts.workspace,
            facts.home,
            session.locator,
        )

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

    @property
    def _brings_nothing(self) -> bool:
        """Whether no code is brought, whatever the machines say."""
        return self._context.options.no_build

    def _gets_what_is_built_here(self, name: str) -> bool:
        mode = self._mode_of(name)
        return mode == 'install' or (
            mode == 'none' and not self._brings_nothing and self._shares(name)
        )

    def _shares(self, name: str) -> bool:
        """Return whether a machine has the path of the workspace here."""
        # on a shared file system it is the same workspace
        return self._paths[name].workspace == str(self._session.root)

    def _mode_of(self, name: str) -> str:
        if self._brings_nothing:
            return 'none'
        return self._deployment.machines[name].sync

    def _bring_all(self, wanted: Mapping[str, frozenset[str]]) -> None:
        if wanted:
            # before there are threads
            code = self._code
            self._syncing = Tasks(
                {
                    name: partial(self._bring, name, names, code)
                    for name, names in wanted.items()
                }
            )

    def _records_of(
        self, name: str, files: Iterable[str], packages: Iterable[str]
    ) -> dict[str, dict[str, str]]:
        remote_text = self._paths[name].folders.text
        # by the paths there, as they are here
        named = {remote_text(path): path for path in files}
        asked: dict[str, Any] = {'packages': (), 'files': sorted(named)}
        if packages:
            colcon = self._session.colcon
            asked |= {
                'packages': sorted(packages),
                'install_base': remote_text(str(colcon.install_base)),
                'build_base': remote_text(str(colcon.build_base)),
                'merge_install': colcon.merge_install,
            }
        connection = self._connections[name]
        answer = connection.ask('inspection.read_contents', asked)
        found = {}
        try:
            for package, record in answer['packages'].items():
                colcon = self._session.colcon
                bases = {
                    'installed': colcon.install_base,
                    'products': colcon.build_base / package,
                }
                found[package] = {
                    f'{base}/{path}': str(content)
                    for kind, base in bases.items()
                    for path, content in record[kind].items()
                }
            contents = answer['files'].items()
            found[''] = found.get('', {}) | {
                named[path]: str(content) for path, content in contents
            }
        except (AttributeError, KeyError, TypeError) as e:
            raise UserError(
                f'{name}: it does not tell what it has built'
            ) from e
        return found

    def _bring(self, name: str, needed: frozenset[str], code: Code) -> Synced:
        workspace = self._paths[name].workspace
        assert workspace is not None
        if name in self._lacks:
            raise self._lacks[name]
        return sync_code(
            self._mode_of(name),
            name,
            workspace,
            self._connections[name],
            code,
            needed,
            partial(self._say_of, name),
        )

    def _check(self, name: str, part: Plan) -> list[Diagnostic]:
        return list(self._paths[name].check(part, self._connections[name]))

    def _start(
        self, name: str, part: Plan, settings: PartSettings
    ) -> MachineLink:
        machine = self._deployment.machines[name]
        paths = self._paths[name]
        variables = sent_variables(self._context.environment, machine.env)
        workspace = paths.workspace
        if not paths.has_setup and not self._brought.get(name):
            # what needs no package does without
            workspace = None
        settings = replace(
            settings,
            machine=name,
            workspace=workspace,
            variables={
                **paths.folders.environment(variables),
                **dict(machine.values),
            },
            on_lost=machine.on_lost,
            lost_after=machine.lost_after or settings.lost_after,
        )
        connection = self._connections[name]
        return MachineLink(connection.start_part(paths.plan(part), settings))

    def _settings(self) -> PartSettings:
        """Return what is the same for the parts on all machines."""
        options, folder = self._context.options, self._context.log_folder
        settings = PartSettings(
            '', log_limit=options.log_limit, tty=options.tty
        )
        if folder is None:
            return settings
        settings = replace(settings, log_name=folder.name)
        # the launch here says so if the user's wish is no number
        store = log_store_of(folder, self._context.environment, lambda _: None)
        if store is None:
            return settings
        return replace(settings, kept_logs=store.kept, logs_limit=store.limit)

    def _packages_of(self, plan: Plan) -> frozenset[str]:
        session = self._session
        if session.root is None:
            return frozenset()
        return packages_of(
            plan, session.locator, session.root, session.colcon.install_base
        )
