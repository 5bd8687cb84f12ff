# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Installs launches as services of systemd, and removes them."""

from collections.abc import Mapping, Sequence
import grp
import os
from pathlib import Path
import pwd
import re
import shlex
import shutil
import socket
import subprocess
import sys
from tempfile import TemporaryDirectory

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.files import names_in, text_of
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.messages import say_line, show
from colcon_yamllaunch.common.suggestions import did_you_mean, one_of
from colcon_yamllaunch.deployment.deployment import HERE, Machine
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.plan_json import plan_to_json
from colcon_yamllaunch.service.own_part import own_part
from colcon_yamllaunch.service.unit import (
    environment_text,
    kept_variables,
    MARK,
    Unit,
)
from colcon_yamllaunch.verb.context import LaunchContext
from colcon_yamllaunch.verb.log_folders import locked
from colcon_yamllaunch.verb.options import LaunchOptions, LOG_FILES
from colcon_yamllaunch.verb.prepare import prepare
from colcon_yamllaunch.verb.run_launch import saved_plan

#: Where others have theirs, below which `system` and `user` are.
OTHER_UNITS = tuple(
    Path(folder)
    for folder in ('/etc/systemd', '/usr/lib/systemd', '/lib/systemd')
)
#: Exists where systemd runs (`sd_booted(3)`).
BOOTED = Path('/run/systemd/system')
#: The kind of machine that has a host name.
_SSH = 'ssh'
_NAME = re.compile(r'[A-Za-z0-9][A-Za-z0-9_.-]{0,99}')


@dataclass(frozen=True, slots=True)
class _Scope:
    """
    The services of the system, or those of the user.

    :param folder: The folder with the folders of services
    :param units: The folder with their unit files
    :param target: The target that starts them
    """

    is_system: bool
    folder: Path
    units: Path
    target: str

    def unit_file(self, name: str) -> Path:
        """Return the path of a unit file."""
        return self.units / f'{name}.service'

    def is_installed(self, name: str) -> bool:
        """Return whether there is such a service, installed by this."""
        return text_of(self.unit_file(name)).startswith(MARK)

    def installed(self) -> list[str]:
        """Return the names of the services that were installed by this."""
        return [n for n in names_in(self.folder) if self.is_installed(n)]

    def rights(self) -> tuple[str, ...]:
        """
        Return the first words of a command that changes the services.

        :raises UserError: when this needs root, and there is no way to it
        """
        if not self.is_system or os.geteuid() == 0:
            return ()
        if shutil.which('sudo') is None:
            raise UserError(
                f'{self.units} belongs to root, and there is no sudo here',
                'do it as root, or install a service of yours with --user',
            )
        return ('sudo',)

    def systemctl(self, *words: str) -> tuple[str, ...]:
        """Return a command for the service manager."""
        manager = () if self.is_system else ('--user',)
        return (*self.rights(), 'systemctl', *manager, *words)


_SYSTEM = _Scope(
    True,
    Path('/etc/colcon_launch/services'),
    # of the administrator (`systemd.unit(5)`)
    Path('/etc/systemd/system'),
    'multi-user',
)
_CONFIG = Path(os.environ.get('XDG_CONFIG_HOME') or '~/.config').expanduser()
_USER = _Scope(
    False,
    _CONFIG / 'colcon_launch/services',
    _CONFIG / 'systemd/user',
    'default',
)


def install(context: LaunchContext) -> int:
    """
    Build and check a launch, and install it as a service.

    :raises GiveUpError: when there can be no launch, and the user knows why
    :raises UserError: when there can be none, or no service
    """
    options = context.options
    name = str(options.install_service)
    _need_systemd()
    is_system = options.system or options.as_ is not None
    if os.geteuid() == 0 and not options.user:
        is_system = True
    scope = _SYSTEM if is_system else _USER
    _refuse_name(name, scope)
    user = _user(options) if scope.is_system else None
    # before a build, which may take long
    scope.rights()
    with locked(context.log_folder), context.workspace.lock:
        if options.from_plan is None:
            plan, _ = prepare(context)
        else:
            plan = saved_plan(options.from_plan, context.cwd)
        plan = _part(context, plan)
    if plan.worker_position is not None:
        raise UserError(
            'this launch cannot be a service, as what happens while it runs '
            f'is up to Python ({plan.worker_position})',
            'write that part in YAML or XML, or as settings of --deploy',
        )
    folder, is_update = scope.folder / name, scope.is_installed(name)
    saved, environment = folder / f'{name}.json', folder / 'environment'
    unit = Unit(
        name,
        options.title,
        _command(saved, options),
        str(environment),
        user,
        options.service_logs != LOG_FILES,
    )
    variables = kept_variables(
        context.workspace.environment, context.environment
    )
    texts = {
        saved: ('640', plan_to_json(plan)),
        # only systemd reads it
        environment: ('600', environment_text(variables)),
        scope.unit_file(name): ('644', unit.text(plan)),
    }
    _write(scope, user, folder, texts)
    if BOOTED.exists():
        _run(scope.systemctl('daemon-reload'))
    if options.enable:
        _run(scope.systemctl('enable', name))
        if BOOTED.exists() and not scope.is_system:
            _run(('loginctl', 'enable-linger'))
    show(_report(scope, name, is_update=is_update, enabled=options.enable))
    return 0


def remove(options: LaunchOptions) -> int:
    """
    Stop a service, and remove it.

    :raises UserError: when there is no such service
    """
    name = str(options.remove_service)
    _need_systemd()
    scopes = [_USER, _SYSTEM]
    if options.user or options.system:
        scopes = [_SYSTEM if options.system else _USER]
    found = [scope for scope in scopes if scope.is_installed(name)]
    if not found:
        known = sorted({n for scope in scopes for n in scope.installed()})
        there = f'there is {", ".join(known) or "none"}'
        raise UserError(
            f"colcon launch has installed no service '{name}'",
            did_you_mean(name, known) or there,
        )
    if len(found) > 1:
        raise UserError(
            f"there are two services '{name}'", 'add --user or --system'
        )
    (scope,) = found
    if BOOTED.exists():
        _run(scope.systemctl('disable', '--now', name))
    unit = scope.unit_file(name)
    link = scope.units / f'{scope.target}.target.wants' / unit.name
    paths = map(str, (link, unit, scope.folder / name))
    _run((*scope.rights(), 'rm', '-rf', *paths))
    if BOOTED.exists():
        _run(scope.systemctl('daemon-reload'))
    show(f'removed the service {name}')
    return 0


def _need_systemd() -> None:
    if shutil.which('systemctl') is None:
        raise UserError(
            'there is no systemd on this computer, which services need',
            'in a container, let `colcon launch` be its command',
        )


def _refuse_name(name: str, scope: _Scope) -> None:
    """
    Refuse a wrong name, and that of a unit which we have not installed.

    :raises UserError: when it is one of these
    """
    if _NAME.fullmatch(name) is None:
        raise UserError(
            f"'{name}' is no name for a service",
            'it has letters, digits, and . _ - after the first of them',
        )
    kind = 'system' if scope.is_system else 'user'
    for folder in (scope.units, *(units / kind for units in OTHER_UNITS)):
        path = folder / f'{name}.service'
        if os.path.lexists(path) and not text_of(path).startswith(MARK):
            raise UserError(
                f"there is another service '{name}': {path}",
                'choose another name',
            )


def _user(options: LaunchOptions) -> str:
    """
    Return the user that a service of the system runs as.

    It is the one who installs it, also by `sudo`, unless `--as` names one.

    :raises UserError: when there is no such user
    """
    own = os.environ.get('SUDO_USER') or pwd.getpwuid(os.geteuid()).pw_name
    name = options.as_ or own
    try:
        return pwd.getpwnam(name).pw_name
    except KeyError:
        names = [entry.pw_name for entry in pwd.getpwall()]
        hint = did_you_mean(name, names) or f'sudo adduser --system {name}'
        raise UserError(f"--as: there is no user '{name}'", hint) from None


def _part(context: LaunchContext, plan: Plan) -> Plan:
    """
    Return what runs on this computer.

    :raises UserError: when it is not clear what does, or nothing does
    """
    options, deployment = context.options, context.deployment
    on = options.on
    if deployment is None or not deployment.machines:
        if on is not None:
            raise UserError(
                '--install-service installs it on the computer that it runs '
                'on',
                f"log in to {on}, and install it there, without --on; '--on "
                "NAME' is for a machine of a --deploy file",
            )
        return plan
    placed = context.placed(plan)
    assert placed is not None
    if on is None and placed.parts:
        names = ', '.join(placed.parts)
        raise UserError(
            f'{options.deploy} has processes on {names}, and a service runs '
            'what is on its own computer',
            f'--on {HERE} for what is on this computer; on each of the '
            'others, the same command with --on and its name',
        )
    if on is not None and on != HERE:
        machine = deployment.machines.get(on)
        if machine is None:
            hint = one_of(on, [HERE, *deployment.machines])
            raise UserError(f"--on: there is no machine '{on}'", hint)
        if not _is_this_computer(machine):
            way = ' '.join((machine.kind, *machine.words))
            raise UserError(
                f'--install-service installs on the computer that it runs '
                f'on, and this is {socket.gethostname()}, not {on}',
                f'log in there ({way}), and give the same command in the '
                f'workspace there; a machine with the name of its host, as '
                "'hostname' prints it, is always recognised",
            )
    part = placed.local if on in (None, HERE) else placed.part(str(on))
    if not any(part.members()):
        raise UserError(f'{options.deploy} has nothing on {on} to run')
    part, missing = own_part(part)
    for label, others in missing.items():
        say_line(
            f'colcon launch: warning: {label} does not wait for '
            f'{", ".join(others)}, as services of different machines do not '
            'know of each other'
        )
    return part


def _is_this_computer(machine: Machine) -> bool:
    """Return whether a machine is this computer, by its name or address."""
    own = socket.gethostname()
    if machine.name in (own, own.partition('.')[0]):
        return True
    if machine.kind != _SSH:
        return False
    host = machine.words[0].removeprefix('ssh://').rpartition('@')[2]
    try:
        found = socket.getaddrinfo(host, 0, type=socket.SOCK_DGRAM)
    except OSError:
        return False
    for family, kind, _, _, address in found:
        with socket.socket(family, kind) as probe:
            try:
                # only own addresses can be bound to
                probe.bind(address)
            except OSError:
                continue
            return True
    return False


def _command(plan: Path, options: LaunchOptions) -> list[str]:
    """Return the command line that runs a saved plan."""
    program = os.path.abspath(sys.argv[0])
    words = [sys.executable, program, 'launch', '--from-plan', str(plan)]
    if options.tty:
        words.append('--tty')
    if options.log_limit != LaunchOptions().log_limit:
        limit = 'none' if options.log_limit is None else str(options.log_limit)
        words += ['--log-limit', limit]
    return words


def _write(
    scope: _Scope,
    user: str | None,
    folder: Path,
    texts: Mapping[Path, tuple[str, str]],
) -> None:
    """
    Write the files of a service.

    :param folder: The folder for its plan, which only its user may enter
    :param texts: By path, the mode of a file and its text
    """
    install = (*scope.rights(), 'install')
    group: tuple[str, ...] = ()
    if user is not None:
        number = pwd.getpwnam(user).pw_gid
        group = ('-g', grp.getgrgid(number).gr_name)
    _run((*install, '-d', '-m', '750', *group, str(folder)))
    _run((*install, '-d', str(scope.units)))
    with TemporaryDirectory() as temporary:
        for path, (mode, text) in texts.items():
            source = Path(temporary, path.name)
            source.write_text(text, encoding='utf-8')
            _run((*install, '-m', mode, *group, str(source), str(path)))


def _report(
    scope: _Scope, name: str, *, is_update: bool, enabled: bool
) -> str:
    """Return the commands that enable and show a service."""
    start = ('start', name) if enabled else ('enable', '--now', name)
    begin = shlex.join(scope.systemctl(*start))
    if not (enabled or scope.is_system):
        # else it runs only while its user is logged in
        begin += ' && loginctl enable-linger'
    manager = '' if scope.is_system else '--user '
    lines = [
        f'{"updated" if is_update else "installed"} the service {name}: '
        f'{scope.unit_file(name)}',
        f'  {"start now" if enabled else "enable"}: {begin}',
        f'  show: systemctl {manager}status {name}',
    ]
    if is_update:
        again = shlex.join(scope.systemctl('restart', name))
        lines.append(f'  if it runs, it has the former plan until: {again}')
    return '\n'.join(lines)


def _run(words: Sequence[str]) -> None:
    """
    Run a command.

    :raises UserError: when it fails
    """
    done = subprocess.run(
        words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )
    if done.returncode:
        hint = None
        if '--user' in words:
            hint = (
                'without a session of yours, systemd does not answer: log in '
                'directly, or export XDG_RUNTIME_DIR=/run/user/$(id -u)'
            )
        reason = ' '.join(done.stderr.split()) or f'exit {done.returncode}'
        raise UserError(f"'{shlex.join(words)}' failed: {reason}", hint)
