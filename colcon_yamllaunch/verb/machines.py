# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The machines of a launch, from the first connection to the running parts.

All of them are connected with, and get their code, at once, each by a thread
of its own, while this computer builds. When the launch runs there are no
threads any more.
"""

from collections import deque
from collections.abc import Callable
from collections.abc import Collection
from collections.abc import Iterable
from collections.abc import Iterator
from collections.abc import Mapping
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from functools import partial
from importlib import import_module
from pathlib import Path
import threading
from typing import Any
from typing import Generic
from typing import NoReturn
from typing import TYPE_CHECKING
from typing import TypeVar

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.language.policies.evaluate import Evaluation
from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.plan.labels import MACHINE_SEPARATOR
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.remote.connection.connection_errors import no_workspace
from colcon_yamllaunch.remote.connection.machine_connection import Facts
from colcon_yamllaunch.remote.connection.machine_connection import (
    MachineConnection,
)
from colcon_yamllaunch.remote.deployment import deployment_file
from colcon_yamllaunch.remote.deployment.deployment import Deployment
from colcon_yamllaunch.remote.deployment.deployment import Machine
from colcon_yamllaunch.remote.deployment.placement import Placed
from colcon_yamllaunch.remote.deployment.placement import Placer
from colcon_yamllaunch.remote.deployment.placement import rules_in_vain
from colcon_yamllaunch.remote.deployment.remote_paths import RemotePaths
from colcon_yamllaunch.remote.deployment.remote_paths import variables_along
from colcon_yamllaunch.remote.machine_link import MachineLink
from colcon_yamllaunch.remote.part_protocol import PartSettings
from colcon_yamllaunch.remote.remote_parts import RemoteParts
from colcon_yamllaunch.remote.sync.code_sync import Code
from colcon_yamllaunch.remote.sync.code_sync import sync_code
from colcon_yamllaunch.remote.sync.code_sync import Synced
from colcon_yamllaunch.verb.log_folders import log_store_of
from colcon_yamllaunch.verb.machine_paths import files_of
from colcon_yamllaunch.verb.machine_paths import packages_of
from colcon_yamllaunch.verb.machine_paths import PathsThere
from colcon_yamllaunch.verb.messages import say
from colcon_yamllaunch.verb.options import LaunchOptions
from colcon_yamllaunch.verb.workspace_session import WorkspaceSession
from colcon_yamllaunch.watch.dependencies import RemoteDependencies
from colcon_yamllaunch.workspace.packages.closure import closure

if TYPE_CHECKING:
    from colcon_yamllaunch.remote.part_protocol import PartSettings
    from colcon_yamllaunch.remote.remote_parts import RemoteParts
    from colcon_yamllaunch.watch.consequences import Products
    from colcon_yamllaunch.watch.dependencies import RemoteDependencies


#: What a launch takes behind that.
_BEHIND = (
    'colcon_yamllaunch.verb.preflight',
    'colcon_yamllaunch.run',
)
#: Seconds that the clocks of a machine and this computer may differ.
CLOCKS = 0.1
#: How many lines of a machine are kept that nobody sees unless it fails.
UNSEEN = 1000
#: Seconds that a thread may take to end once its connection is closed.
PATIENCE = 15.0


class MachinesThere:
    """
    The machines that parts of a launch run on.

    :param session: The workspace here, if there is one
    :param environment: The user's
    :param cwd: The folder that the launch is begun in
    :param log_folder: The folder for the logs, or None to keep none
    :param say: Is called with a line that the user should see at once; None
      to show what machines say only when something fails there
    :param title: The command, for other launches that wait for this one
    :param mode: `none` to bring no code whatever the machines say, as with
      `--no-build`
    :param may_ask: Whether ssh may ask for a password at the terminal
    """

    def __init__(
        self,
        deployment: Deployment,
        session: WorkspaceSession,
        environment: Mapping[str, str],
        cwd: Path,
        log_folder: Path | None,
        say: Callable[[str], None] | None,
        title: str,
        *,
        mode: str | None = None,
        may_ask: bool = True,
    ) -> None:
        self.deployment = deployment
        self._session = session
        self._environment = environment
        self._cwd = cwd
        self._log_folder = log_folder
        self._say = say
        self._title = title
        # what machines have said that nobody saw
        self._unseen: dict[str, deque[str]] = {}
        self._mode = mode
        self._may_ask = may_ask
        self._connections: dict[str, MachineConnection] = {}
        self._paths: dict[str, PathsThere] = {}
        # what to say of those whose workspace is not there
        self._lacks: dict[str, UserError] = {}
        self._errands: Errands[Any] | None = None
        # what connects with those that will most likely be needed
        self._expected: Errands[Facts] = Errands({})
        # the packages that the machines have, or are about to get
        self._brought: dict[str, frozenset[str]] = {}
        # those that are brought when all is built here
        self._late: dict[str, frozenset[str]] = {}
        self._code: Code | None = None
        self._placer = Placer(deployment)
        #: The packages that were built there.
        self.built: dict[str, frozenset[str]] = {}

    def place(self, plan: Plan) -> Placed:
        """Cut a plan, and forget what was placed before."""
        self._placer = Placer(self.deployment)
        return self._placer.place(plan)

    def needed(
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
        if self.deployment.everything_on is not None:
            return dict.fromkeys(placed.parts, named)
        return {
            name: self._packages_of(part)
            for name, part in placed.parts.items()
        }

    def only_there(
        self, placed: Placed, needed: Mapping[str, frozenset[str]]
    ) -> frozenset[str]:
        """Return the packages that need not be built here; once connected."""
        there: set[str] = set()
        here = set(self._packages_of(placed.local))
        for name, packages in needed.items():
            if self._gets_what_is_built_here(name):
                here |= packages
            else:
                there |= packages
        return frozenset(there - here)

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
                if self.deployment.machines[name].kind != 'slurm'
            ]
        )

    def begin(self, needed: Mapping[str, frozenset[str]]) -> None:
        """
        Connect with the machines, and begin to bring the code there.

        What was begun before goes on.

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

    def begin_with(self, plan: Plan) -> None:
        """
        Do so for a plan that is all that is known of the launch.

        :raises UserError: when a machine cannot be reached
        """
        packages = self._packages_of(plan)
        placed = self.place(plan)
        self.begin(self.needed(placed, packages, is_growing=False))

    def wait(self) -> None:
        """
        Wait until the code is there.

        What is installed here is brought only then, so it is to be called
        when all is built here.

        :raises UserError: when it is not
        """
        self._wait()
        late, self._late = self._late, {}
        self._bring_all(late)
        self._wait()

    def runs_there(
        self, placed: Placed, needed: Mapping[str, frozenset[str]]
    ) -> RemoteDependencies:
        """
        Return what runs on the machines, for `--watch`.

        :param needed: What :meth:`needed` has returned
        """
        files = {}
        for name, part in placed.parts.items():
            covers = self._paths[name].folders.covers
            for process in part.processes():
                files[process.label] = files_of(process, covers)
            for component in part.components():
                files[component.label] = files_of(component, covers)
        packages = {
            name: frozenset(closure(self._session.packages, names))
            for name, names in needed.items()
            if names
        }
        why = '--no-build' if self._mode == 'none' else 'sync: none'
        kept = dict.fromkeys(filter(self._keeps_code, packages), why)
        return RemoteDependencies(placed.machines, files, packages, kept)

    def records(self, there: RemoteDependencies) -> dict[str, dict[str, str]]:
        """
        Return the code that the machines have, for `--watch`.

        It is by the machine and package, as `arm│my_pkg`, and `arm│` for files
        that are named; the files by the machine and the paths that they would
        have here.

        :raises UserError: when a machine cannot be asked
        """
        files: dict[str, set[str]] = {}
        for label, machine in there.machines.items():
            files.setdefault(machine, set()).update(there.files[label])
        asked = Errands(
            {
                name: partial(
                    self._records_of,
                    name,
                    files.get(name, ()),
                    ()
                    if name in there.unsynced
                    else there.packages.get(name, ()),
                )
                for name in self._connections
            }
        )
        asked.wait()
        asked.check()
        return {
            f'{machine}{MACHINE_SEPARATOR}{package}': {
                f'{machine}{MACHINE_SEPARATOR}{path}': content
                for path, content in files.items()
            }
            for machine, packages in asked.results.items()
            for package, files in packages.items()
        }

    def _wait(self) -> None:
        """
        Wait until what has been begun is done.

        :raises UserError: when it has failed
        """
        if self._errands is None:
            return
        self._errands.wait()
        errands, self._errands = self._errands, None
        for name in errands.errors:
            for line in self._unseen.pop(name, ()):
                say(line)
        errands.check()
        for name, synced in errands.results.items():
            before = self.built.get(name, frozenset())
            self.built[name] = before | synced.built

    def check(self, placed: Placed) -> Iterator[Diagnostic]:
        """Find what the parts name and the machines do not have."""
        errands = Errands(
            {
                name: partial(self._check, name, placed.part(name))
                for name in self._connections
            }
        )
        errands.wait()
        errands.check()
        for found in errands.results.values():
            yield from found

    def localised(self, name: str, plan: Plan) -> Plan:
        """Return a plan with the paths of a machine."""
        return self._paths[name].plan(plan)

    def start(
        self, placed: Placed, settings: PartSettings, *, is_growing: bool
    ) -> RemoteParts:
        """
        Start the parts, and return what the launch needs of them.

        :param settings: What is the same for all machines
        :param is_growing: Whether more may come for any machine
        :raises UserError: when a part cannot be started
        """
        names = list(self._connections)
        if not is_growing:
            names = list(placed.parts)
        errands = Errands(
            {
                name: partial(self._start, name, placed.part(name), settings)
                for name in names
            }
        )
        try:
            errands.wait()
            errands.check()
        except BaseException:
            self.close()
            errands.wait(PATIENCE)
            for link in errands.results.values():
                link.close()
            raise
        links = [errands.results[name] for name in names]
        for name in names:
            # from here on it is the launch's
            del self._connections[name]
        self.close()
        return RemoteParts(
            links,
            placed,
            self._placer.place_more,
            self.localised,
        )

    def close(self) -> None:
        """End all connections, and wait for what is done through them."""
        closing = Errands({n: c.close for n, c in self._connections.items()})
        closing.wait(PATIENCE)
        self._connections.clear()
        self._expected.wait(PATIENCE)
        if self._errands is not None:
            self._errands.wait(PATIENCE)
            self._errands = None

    def _meant_machines(self) -> list[str]:
        """Return the machines that anything may run on."""
        meant = {rule.machine for rule in self.deployment.rules}
        meant.add(self.deployment.everything_on or '')
        return [name for name in self.deployment.machines if name in meant]

    def _connect(self, names: Sequence[str]) -> None:
        """
        Connect with machines, all at once.

        :raises UserError: when one cannot be reached
        """
        expected, self._expected = self._expected, Errands({})
        for name in self._connections.keys() - self._paths.keys() - {*names}:
            self._connections.pop(name).close()
        others = self._begin_to_connect(
            [name for name in names if name not in self._connections]
        )
        for module in _BEHIND if names else ():
            # this computer has nothing else to do meanwhile
            import_module(module)
        facts: dict[str, Facts] = {}
        for errands in (expected, others):
            errands.wait()
            facts.update(errands.results)
            for name in list(errands.errors):
                if name not in names:
                    errands.forgive(name)
                # one after the other, as each asks at the terminal
                elif self._may_ask and self._connections[name].must_ask:
                    again = self._connection_with(name, may_ask=True)
                    self._connections[name] = again
                    facts[name] = again.connect()
                    errands.forgive(name)
            errands.check()
        for name in names:
            self._paths[name] = self._paths_to(name, facts[name])
            self._mind_workspace(name, facts[name])
            self._mind_clock(name, facts[name])

    def _begin_to_connect(self, names: Sequence[str]) -> 'Errands[Facts]':
        for name in names:
            self._connections[name] = self._connection_with(name)
        return Errands({n: self._connections[n].connect for n in names})

    def _connection_with(
        self, name: str, *, may_ask: bool = False
    ) -> MachineConnection:
        machine = self.deployment.machines[name]
        return MachineConnection(
            machine,
            self._places_of_workspace(machine),
            self._environment,
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
        if self._say is not None:
            self._say(text)
        else:
            unseen = self._unseen.setdefault(name, deque(maxlen=UNSEEN))
            unseen.append(text)

    def _mind_clock(self, name: str, facts: Facts) -> None:
        if abs(facts.ahead) - facts.delay > CLOCKS:
            order = 'ahead of' if facts.ahead > 0 else 'behind'
            self._say_of(
                name,
                f'warning: its clock is {abs(facts.ahead):.1f} s {order} that '
                'of this computer, so nodes misjudge the age of messages; '
                'help: synchronise both, as by chrony',
            )

    def _mind_workspace(self, name: str, facts: Facts) -> None:
        """
        See to it that a workspace that nobody brings is there.

        :raises UserError: when it is not, and was named
        """
        machine, workspace = self.deployment.machines[name], facts.workspace
        if workspace is None or facts.has_workspace:
            return
        if self._session.root is None or self._mode_of(name) == 'none':
            self._lacks[name] = no_workspace(machine, workspace)
            if machine.workspace is not None:
                raise self._lacks[name]

    def _paths_to(self, name: str, facts: Facts) -> PathsThere:
        folders: dict[str, str] = {}
        session = self._session
        if session.root is not None and facts.workspace is not None:
            install_base = session.colcon.install_base
            folders = {
                str(install_base): f'{facts.workspace}/{install_base.name}',
                str(session.root): facts.workspace,
            }
            if install_base.is_relative_to(session.colcon.root):
                del folders[str(install_base)]
        if self._log_folder is not None:
            base = facts.workspace or f'{facts.home}/.ros'
            logs = f'{base}/log/{self._log_folder.name}'
            folders[str(self._log_folder)] = logs
        machine = self.deployment.machines[name]
        return PathsThere(
            machine,
            RemotePaths(folders),
            str(self._cwd),
            facts.workspace,
            facts.home,
            session.locator,
        )

    def _code_here(self) -> Code:
        if self._code is None:
            session = self._session
            colcon = session.colcon
            self._code = Code(
                colcon.root,
                tuple(session.packages),
                colcon.build_base,
                colcon.install_base,
                merge_install=colcon.merge_install,
                build_arguments=colcon.build_arguments,
                settings=colcon.common_settings,
                environment=session.environment,
                title=self._title,
            )
        return self._code

    def _gets_what_is_built_here(self, name: str) -> bool:
        mode = self._mode_of(name)
        return mode == 'install' or (
            mode == 'none' and self._mode is None and self._shares(name)
        )

    def _keeps_code(self, name: str) -> bool:
        """Return whether nothing here changes the code of a machine."""
        return self._mode_of(name) == 'none' and not self._shares(name)

    def _shares(self, name: str) -> bool:
        """Return whether a machine has the path of the workspace here."""
        # on a shared file system it is the same workspace
        return self._paths[name].workspace == str(self._session.root)

    def _mode_of(self, name: str) -> str:
        return self._mode or self.deployment.machines[name].sync

    def _bring_all(self, wanted: Mapping[str, frozenset[str]]) -> None:
        if wanted:
            code = self._code_here()
            self._errands = Errands(
                {
                    name: partial(self._bring, name, names, code)
                    for name, names in wanted.items()
                }
            )

    def _records_of(
        self, name: str, files: Iterable[str], packages: Iterable[str]
    ) -> dict[str, dict[str, str]]:
        text_there = self._paths[name].folders.text
        # by the paths there, as they are here
        named = {text_there(path): path for path in files}
        asked: dict[str, Any] = {'packages': (), 'files': sorted(named)}
        if packages:
            colcon = self._session.colcon
            asked |= {
                'packages': sorted(packages),
                'install_base': text_there(str(colcon.install_base)),
                'build_base': text_there(str(colcon.build_base)),
                'merge_install': colcon.merge_install,
            }
        connection = self._connections[name]
        answer = connection.ask('inspection.read_contents', asked)
        found = {}
        try:
            for package, told in answer['packages'].items():
                colcon = self._session.colcon
                bases = {
                    'installed': colcon.install_base,
                    'products': colcon.build_base / package,
                }
                found[package] = {
                    f'{base}/{path}': str(content)
                    for kind, base in bases.items()
                    for path, content in told[kind].items()
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
        machine = self.deployment.machines[name]
        paths = self._paths[name]
        variables = variables_along(self._environment, machine.env)
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

    def _packages_of(self, plan: Plan) -> frozenset[str]:
        session = self._session
        if session.root is None:
            return frozenset()
        return packages_of(
            plan, session.locator, session.root, session.colcon.install_base
        )


_Result = TypeVar('_Result')


class Errands(Generic[_Result]):
    """
    Something that is done for each of some machines.

    :param what: Does it, by the name of the machine; begun at once
    """

    def __init__(self, what: Mapping[str, Callable[[], _Result]]) -> None:
        self._results: dict[str, _Result] = {}
        self._errors: dict[str, Exception] = {}
        self._threads = {
            name: threading.Thread(
                target=self._run, args=(name, do), name=name, daemon=True
            )
            for name, do in what.items()
        }
        for thread in self._threads.values():
            thread.start()

    def wait(self, seconds: float | None = None) -> bool:
        """
        Wait until all is done; a signal may end that.

        Return whether it is.

        :param seconds: How long for each at most, None for ever
        """
        for thread in self._threads.values():
            thread.join(seconds)
        return not any(t.is_alive() for t in self._threads.values())

    @property
    def results(self) -> Mapping[str, _Result]:
        """What came of it where it succeeded."""
        return self._results

    @property
    def errors(self) -> Mapping[str, Exception]:
        """What went wrong where it did not."""
        return self._errors

    def check(self) -> None:
        """
        Tell all that went wrong, if anything did.

        :raises UserError: when it did
        """
        for error in self._errors.values():
            if not isinstance(error, UserError):
                raise error
        # each machine's own, in the order of the machines
        found = [self._errors[n] for n in self._threads if n in self._errors]
        if found:
            raise UserError('\n'.join(dict.fromkeys(map(str, found))))

    def forgive(self, name: str) -> None:
        """Take into account that what went wrong was put right."""
        del self._errors[name]

    def _run(self, name: str, do: Callable[[], _Result]) -> None:
        try:
            self._results[name] = do()
        except Exception as e:  # noqa: BLE001
            # told in the main thread
            self._errors[name] = e


class DeployedLaunch:
    """
    What a launch does about other machines.

    :param environment: The user's
    :param log_folder: The folder for the logs, or None to keep none
    :param report: Shows problems to the user
    :param fail: Shows them, and ends the launch by an exception
    :param may_ask: Whether ssh may ask for a password at the terminal
    """

    def __init__(
        self,
        options: LaunchOptions,
        cwd: Path,
        environment: Mapping[str, str],
        session: WorkspaceSession,
        log_folder: Path | None,
        report: Callable[[Iterable[Diagnostic]], None],
        fail: Callable[[Sequence[Diagnostic]], NoReturn],
        *,
        may_ask: bool,
    ) -> None:
        self._options = options
        self._cwd = cwd
        self._environment = environment
        self._session = session
        self._log_folder = log_folder
        self._report = report
        self._fail = fail
        self._may_ask = may_ask
        self._parts: RemoteParts | None = None
        #: The packages that are not built here, as nothing here needs them.
        self.only_there: frozenset[str] = frozenset()
        #: The machines that parts of it run on.
        self.used: frozenset[str] = frozenset()
        # the packages that each machine needs
        self._needed: Mapping[str, frozenset[str]] = {}
        #: What runs there, and the code that is there, with `--watch`.
        self.there: RemoteDependencies | None = None
        self.records: Products = {}

    @cached_property
    def deployment(self) -> Deployment:
        """
        Which machines there are, and what runs on them.

        :raises GiveUpError: when the deployment file is wrong
        :raises UserError: when there is no such machine
        """
        found = None
        if self._options.deploy is not None:
            path = str(self._cwd / self._options.deploy)
            try:
                found = deployment_file.read_deployment(path)
            except LaunchError as e:
                self._fail(e.diagnostics)
        if self._options.on is not None:
            return deployment_file.deployed_on(self._options.on, found)
        assert found is not None
        return found

    @cached_property
    def machines(self) -> 'MachinesThere':
        """The machines, as far as they have been connected with."""
        # who only looks at a launch connects nowhere
        return MachinesThere(
            self.deployment,
            self._session,
            self._environment,
            self._cwd,
            self._log_folder,
            None if self._options.quiet else self._session.announce,
            ' '.join(['colcon launch', *self._options.positionals]),
            mode='none' if self._options.no_build else None,
            may_ask=self._may_ask,
        )

    def expect_machines(self) -> None:
        """
        Begin to connect while the launch file is evaluated.

        :raises GiveUpError: when the deployment file is wrong
        :raises UserError: when there is no such machine
        """
        self.machines.expect()

    def bring_code(
        self, evaluation: Evaluation, named: Collection[str]
    ) -> None:
        """
        Connect with the machines of a launch, and begin to bring the code.

        :param named: The packages of the workspace that the launch names
        :raises GiveUpError: when no build brings a program of it
        :raises UserError: when a machine cannot be reached
        """
        from colcon_yamllaunch.verb.preflight import executables_in_vain

        locator = self._session.locator
        found = executables_in_vain(evaluation.executables, locator)
        if found:
            self._fail(found)
        placed = self.machines.place(evaluation.plan)
        self._needed = needed = self.machines.needed(
            placed,
            frozenset(named),
            is_growing=evaluation.growing is not None,
        )
        self.machines.begin(needed)
        # what was run here may need any of them
        if not evaluation.has_run_programs:
            self.only_there = self.machines.only_there(placed, needed)

    def bring_code_of(self, plan: Plan) -> None:
        """
        Do so for a saved plan.

        :raises UserError: when a machine cannot be reached
        """
        self.machines.begin_with(plan)

    def settled(self, plan: Plan) -> Plan:
        """
        Return a plan as it is known by its users, with names of machines.

        All that its parts need is there then.

        :raises GiveUpError: when something that they need is not
        :raises UserError: when the code could not be brought
        """
        self._report(rules_in_vain(plan, self.deployment))
        placed = self.machines.place(plan)
        self.machines.wait()
        found = list(self.machines.check(placed))
        if any(d.severity == 'error' for d in found):
            self._fail(found)
        self._report(found)
        self.used = frozenset(placed.parts)
        if self._options.watch is not None:
            self.there = self.machines.runs_there(placed, self._needed)
            self.records = self.machines.records(self.there)
        return placed.whole

    def local(self, plan: Plan) -> Plan:
        """Return what of a plan runs here."""
        return self.machines.place(plan).local

    @property
    def digest(self) -> str:
        """What tells the deployment from others."""
        # only who watches files asks
        import hashlib

        known = self.deployment
        # where it is written does not matter
        machines = [replace(m, position=None) for m in known.machines.values()]
        rules = [(str(rule), rule.machine) for rule in known.rules]
        text = repr((machines, rules, known.everything_on))
        return hashlib.sha256(text.encode()).hexdigest()

    @property
    def built(self) -> frozenset[str]:
        """The packages that were built on machines."""
        return frozenset[str]().union(*self.machines.built.values())

    def disown(self) -> None:
        """Have nothing to do with the parts, in a fork of this process."""
        if self._parts is not None:
            self._parts.disown()

    def start(
        self, plan: Plan, *, is_growing: bool
    ) -> 'tuple[Plan, RemoteParts]':
        """
        Start the parts, and return what of the plan runs here besides.

        :param plan: As :meth:`settled` has returned it
        :param is_growing: Whether more may come while it runs
        :raises UserError: when one cannot be started
        """
        placed = self.machines.place(plan)
        self._parts = self.machines.start(
            placed, self._settings(), is_growing=is_growing
        )
        return placed.local, self._parts

    def close(self) -> None:
        """End what is connected, and what runs there."""
        if self._parts is not None:
            self._parts.close()
        if 'machines' in vars(self):
            self.machines.close()

    def _settings(self) -> 'PartSettings':
        """Return what is the same for the parts on all machines."""
        from colcon_yamllaunch.remote.part_protocol import PartSettings

        settings = PartSettings(
            '', log_limit=self._options.log_limit, tty=self._options.tty
        )
        folder = self._log_folder
        if folder is None:
            return settings
        settings = replace(settings, log_name=folder.name)
        # that the user's wish is no number is said by who tidies up here
        store = log_store_of(folder, self._environment, lambda _: None)
        if store is None:
            return settings
        return replace(settings, kept_logs=store.kept, logs_limit=store.limit)
