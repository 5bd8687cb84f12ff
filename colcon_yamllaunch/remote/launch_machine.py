# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""One machine of a launch: its connection, its paths and its code."""

from collections import deque
from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.messages import say
from colcon_yamllaunch.deployment.deployment import Machine
from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic, Severity
from colcon_yamllaunch.plan.labels import MACHINE_SEPARATOR
from colcon_yamllaunch.plan.plan import AfterReady, Entry, Plan, Process, Timer
from colcon_yamllaunch.remote.connection.connection_errors import no_workspace
from colcon_yamllaunch.remote.connection.machine_connection import (
    MachineConnection,
    MachineFacts,
)
from colcon_yamllaunch.remote.machine_link import MachineLink
from colcon_yamllaunch.remote.part_protocol import PartSettings
from colcon_yamllaunch.remote.plan_references import named_paths
from colcon_yamllaunch.remote.remote_paths import RemotePaths, sent_variables
from colcon_yamllaunch.remote.sync.code_sync import Code, sync_code, Synced
from colcon_yamllaunch.workspace.workspace_session import WorkspaceSession

#: Seconds that the clocks of a machine and this computer may differ.
CLOCKS = 0.1
#: How many lines of a machine are kept that nobody sees unless it fails.
UNSEEN = 1000
#: What is asked of the machine.
LOOK = 'inspection.find_missing'
#: Finds limits that a machine cannot set.
FIND_LIMIT_PROBLEMS = 'inspection.find_limit_problems'


@dataclass(frozen=True, slots=True)
class Launcher:
    """
    The launch on this computer, as far as its machines need it.

    :param workspace: Its workspace
    :param environment: The user's
    :param cwd: The folder in which it was begun
    :param log_folder: The folder for its logs, None for none
    :param builds: Whether code may be built and sent
    :param quiet: Whether lines of the machines are shown only on failure
    """

    workspace: WorkspaceSession
    environment: Mapping[str, str]
    cwd: Path
    log_folder: Path | None
    builds: bool
    quiet: bool


class LaunchMachine:
    """
    A machine that parts of a launch run on.

    :param machine: The machine as the deployment describes it
    :param may_ask: Whether the user may be asked for a password
    """

    def __init__(
        self,
        launcher: Launcher,
        machine: Machine,
        *,
        may_ask: bool = False,
    ) -> None:
        self.name = machine.name
        #: How it gets code: `build`, `install` or `none`.
        self.sync_mode = machine.sync if launcher.builds else 'none'
        #: Whether it is connected, and its properties are known.
        self.is_ready = False
        #: The packages that were sent; None before that.
        self.packages: frozenset[str] | None = None
        #: Where folders of this computer are on the machine.
        self.folders = RemotePaths({})
        self._launcher = launcher
        self._session = launcher.workspace
        self._machine = machine
        self._workspace: str | None = None
        self._home = ''
        # where processes run that run here where the launch is begun
        self._cwd = ''
        # whether the workspace there can be sourced
        self._has_setup = False
        self._no_workspace: UserError | None = None
        self._unseen: deque[str] = deque(maxlen=UNSEEN)
        # where the workspace may be there, the last to make it
        places = [] if machine.workspace is None else [machine.workspace]
        root = self._session.root
        if not places and root is not None:
            places = [str(root), f'~/{root.name}']
        self.connection = MachineConnection(
            machine,
            places,
            launcher.environment,
            may_ask=may_ask,
            say=self.say,
        )

    def say(self, line: str) -> None:
        """Show a line of the machine; with `--quiet`, keep it."""
        text = f'{self.name}{MACHINE_SEPARATOR} {line}'
        if self._launcher.quiet:
            self._unseen.append(text)
        else:
            self._session.announce(text)

    def say_unseen(self) -> None:
        """Show the lines that were kept, as something failed."""
        while self._unseen:
            say(self._unseen.popleft())

    def connect(self) -> MachineFacts:
        """
        Connect, and return the properties of the machine.

        :raises UserError: when it cannot be reached
        """
        return self.connection.connect()

    def close(self) -> None:
        """Close the connection, which ends the part on the machine."""
        self.connection.close()

    def use(self, facts: MachineFacts) -> None:
        """
        Use the machine for the launch, now that its properties are known.

        :raises UserError: when a workspace that was named is not there
        """
        self.is_ready = True
        self._workspace = facts.workspace
        self._home = self._cwd = facts.home
        self.folders = RemotePaths(self._remote_folders())
        is_sent = self._session.root is not None and self.sync_mode != 'none'
        workspace = facts.workspace
        if workspace and not (facts.has_workspace or is_sent):
            self._no_workspace = no_workspace(self._machine, workspace)
            if self._machine.workspace is not None:
                raise self._no_workspace
        if abs(facts.ahead) - facts.delay > CLOCKS:
            order = 'ahead of' if facts.ahead > 0 else 'behind'
            self.say(
                f'warning: its clock is {abs(facts.ahead):.1f} s {order} that '
                'of this computer, so nodes misjudge the age of messages; '
                'help: synchronise both, as by chrony'
            )

    def _remote_folders(self) -> dict[str, str]:
        folders: dict[str, str] = {}
        session, workspace = self._session, self._workspace
        if session.root is not None and workspace is not None:
            install_base = session.colcon.install_base
            if not install_base.is_relative_to(session.colcon.root):
                folders[str(install_base)] = f'{workspace}/{install_base.name}'
            folders[str(session.root)] = workspace
        log_folder = self._launcher.log_folder
        if log_folder is not None:
            base = workspace or f'{self._home}/.ros'
            folders[str(log_folder)] = f'{base}/log/{log_folder.name}'
        return folders

    @property
    def shares_workspace(self) -> bool:
        """Whether its workspace has the same path as the one here."""
        # on a shared file system it is the same workspace
        return self._workspace == str(self._session.root)

    @property
    def gets_local_builds(self) -> bool:
        """Whether the machine runs code that is built on this computer."""
        if self.sync_mode == 'none' and self._launcher.builds:
            return self.shares_workspace
        return self.sync_mode == 'install'

    def receive_code(self, packages: frozenset[str], code: Code) -> Synced:
        """
        Send packages and their dependencies to the machine.

        :raises UserError: when that is not possible
        """
        if self._no_workspace is not None:
            raise self._no_workspace
        assert self._workspace is not None
        return sync_code(
            self.sync_mode,
            self.name,
            self._workspace,
            self.connection,
            code,
            packages,
            self.say,
        )

    def contents(
        self, files: Collection[str], packages: Collection[str]
    ) -> dict[str, dict[str, str]]:
        """
        Return what identifies the content of files and packages there.

        They are by the machine and package, as `arm│my_pkg`, and by `arm│` for
        other files; each file by the machine and its path on this computer.

        :raises UserError: when the machine does not tell
        """
        # by the paths there, as they are here
        named = {self.folders.text(path): path for path in files}
        asked: dict[str, Any] = {'packages': (), 'files': sorted(named)}
        if packages:
            colcon = self._session.colcon
            asked |= {
                'packages': sorted(packages),
                'install_base': self.folders.text(str(colcon.install_base)),
                'build_base': self.folders.text(str(colcon.build_base)),
                'merge_install': colcon.merge_install,
            }
        answer = self.connection.ask('inspection.read_contents', asked)
        prefix = f'{self.name}{MACHINE_SEPARATOR}'
        found = {}
        try:
            for package, record in answer['packages'].items():
                colcon = self._session.colcon
                bases = {
                    'installed': colcon.install_base,
                    'products': colcon.build_base / package,
                }
                found[prefix + package] = {
                    f'{prefix}{base}/{path}': str(content)
                    for kind, base in bases.items()
                    for path, content in record[kind].items()
                }
            found[prefix] = {
                prefix + named[path]: str(content)
                for path, content in answer['files'].items()
            }
        except (AttributeError, KeyError, TypeError) as e:
            raise UserError(
                f'{self.name}: it does not tell what it has built'
            ) from e
        return found

    def check(self, part: Plan) -> list[Diagnostic]:
        """
        Find what processes are given and that the machine does not have.

        Those are files, limits and users.

        :param part: The part of the machine, with paths of this computer
        :raises UserError: when the machine cannot be asked
        """
        text = self.folders.text
        named = dict(named_paths(part, self.folders.covers))
        setup = f'{self._workspace}/install/setup.bash'
        folders = [
            text(str(self._launcher.cwd)),
            self._workspace or self._home,
        ]
        paths = {*map(text, named), setup, *folders}
        answer = self.connection.ask(LOOK, {'paths': sorted(paths)})
        found = answer.get('missing')
        missing = set(map(str, found)) if isinstance(found, list) else set()
        there = (folder for folder in folders if folder not in missing)
        self._cwd = next(there, self._home)
        self._has_setup = setup not in missing
        return [
            *(
                problem
                for path, process in named.items()
                if text(path) in missing
                for problem in self._missing(path, process)
            ),
            *self._limit_problems(part),
        ]

    def _limit_problems(self, part: Plan) -> Iterator[Diagnostic]:
        """Find limits that the machine cannot set; see `resource_limits`."""
        limited = {
            process.label: process
            for process in part.processes()
            if process.settings is not None and process.settings.is_restricted
        }
        if not limited:
            return
        # few launches have limits
        from colcon_yamllaunch.plan.plan_json import plan_to_json

        text = plan_to_json(Plan(tuple(limited.values())))
        answer = self.connection.ask(FIND_LIMIT_PROBLEMS, {'plan': text})
        for label, key, problem, hint in answer['problems']:
            settings = limited[label].settings
            assert settings is not None
            yield Diagnostic(
                'error',
                f'{label} runs on {self.name}: {problem}',
                settings.place(key),
                hint,
                len(key),
            )

    def _missing(self, path: str, process: Process) -> Iterator[Diagnostic]:
        """Report a missing path, if that is a problem."""
        there = self.folders.text(path)
        locator = self._session.locator
        severity: Severity = 'warning'
        problem, hint = f"there is no '{there}' there", None
        owner = locator.owner(path)
        if owner is not None:
            hint = f'make {owner.name} install it, or correct the path'
        if path == process.argv[0]:
            problem = f"there is no program '{there}' there"
            if owner is None and process.package is not None:
                hint = f'install the package {process.package} there'
            # as on this computer, the launch goes on without one that no
            # package has
            severity = 'error' if hint else 'warning'
            hint = hint or 'install it there'
        elif not self.folders.covers(path):
            problem = f"'{path}' is a file of this computer that is not there"
            hint = (
                'put it into a package of the workspace and name it by '
                '$(find-pkg-share …), or copy it there'
            )
        elif locator.package_of(path) and not Path(path).exists():
            # a program may be about to make it
            return
        yield Diagnostic(
            severity,
            f'{process.label} runs on {self.name}, and {problem}',
            process.position,
            hint,
        )

    def plan(self, part: Plan) -> Plan:
        """Return a part of the plan with the paths there."""
        entries = tuple(map(self._with_folder, part.entries))
        return self.folders.plan(replace(part, entries=entries))

    def _with_folder(self, entry: Entry) -> Entry:
        """Return an entry whose processes run in a folder that is there."""
        if isinstance(entry, Timer | AfterReady):
            inner = tuple(map(self._with_folder, entry.entries))
            return replace(entry, entries=inner)
        if isinstance(entry, Process) and entry.cwd == str(self._launcher.cwd):
            return replace(entry, cwd=self._cwd)
        return entry

    def start(self, part: Plan, settings: PartSettings) -> MachineLink:
        """
        Start a part of the plan.

        :param settings: Those that are the same on all machines
        :raises UserError: when it cannot be started
        """
        machine = self._machine
        variables = sent_variables(self._launcher.environment, machine.env)
        # a part that needs no package needs no workspace
        needs_workspace = self._has_setup or self.packages
        settings = replace(
            settings,
            machine=self.name,
            workspace=self._workspace if needs_workspace else None,
            variables={
                **self.folders.environment(variables),
                **dict(machine.values),
            },
            on_lost=machine.on_lost,
            lost_after=machine.lost_after or settings.lost_after,
        )
        return MachineLink(
            self.connection.start_part(self.plan(part), settings)
        )
