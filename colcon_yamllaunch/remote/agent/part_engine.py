# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The process that runs a part of a launch, as the launcher runs a launch."""

from collections.abc import Mapping
from contextlib import suppress
import os
from pathlib import Path
import select
import signal
from typing import Any

from colcon_yamllaunch.common.codec import Codec
from colcon_yamllaunch.common.codec import CodecError
from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.engine.launch_scan import new_identity
from colcon_yamllaunch.engine.state import About
from colcon_yamllaunch.observers.log_store import LogStore
from colcon_yamllaunch.plan.plan_json import plan_from_json
from colcon_yamllaunch.plan.plan_json import PlanFormatError
from colcon_yamllaunch.remote.agent import launcher_channel
from colcon_yamllaunch.remote.agent.launcher_channel import LauncherChannel
from colcon_yamllaunch.remote.agent.part import Part
from colcon_yamllaunch.remote.agent.part_place import PartPlace
from colcon_yamllaunch.remote.part_settings import PartSettings
from colcon_yamllaunch.run import run
from colcon_yamllaunch.run import RunContext
from colcon_yamllaunch.workspace.environment.sourcing import source

_COLCON_IGNORE = 'COLCON_IGNORE'


def start_engine(
    launcher: LauncherChannel, place: PartPlace, content: Mapping[str, Any]
) -> str:
    """
    Start the engine of a part, and return its identity.

    It begins once the launcher has spoken with it.

    :raises LauncherGoneError: when the launcher is gone
    :raises UserError: when it cannot be started
    """
    try:
        plan = plan_from_json(content['plan'])
        settings = Codec().from_json(
            PartSettings, content['settings'], 'settings'
        )
    except (PlanFormatError, CodecError, KeyError) as error:
        raise UserError(f'its part of the plan is wrong: {error}') from error
    ours, its = os.pipe()
    pid = os.fork()
    if not pid:
        code = 1
        try:
            os.close(ours)
            code = _run(place, plan, settings, its)
        finally:
            os._exit(code)
    os.close(its)
    told = b''
    try:
        while True:
            if ours in launcher.poll({ours: select.POLLIN}):
                more = os.read(ours, 1 << 16)
                if not more:
                    break
                told += more
    except BaseException:
        with suppress(OSError):
            # it has started nothing that is not its own
            os.killpg(pid, signal.SIGTERM)
        raise
    finally:
        os.close(ours)
    word, _, text = told.decode(errors='replace').partition(' ')
    if word == 'ready':
        # which is removed by the engine
        launcher_channel.PROGRAM.folder = ''
    if word != 'ready':
        raise UserError(text or 'it broke off while it was being started')
    return text


def _run(
    place: PartPlace, plan: Any, settings: PartSettings, told: int
) -> int:
    """Run the part, in a process of its own; return the exit code."""
    os.setsid()
    null = os.open(os.devnull, os.O_RDWR | os.O_CLOEXEC)
    for descriptor in (0, 1, 2):
        os.dup2(null, descriptor)
    for number in (signal.SIGHUP, signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)
    signal.signal(signal.SIGPIPE, signal.SIG_IGN)
    identity = new_identity()
    server = None
    try:
        try:
            environment = environment_of(settings, os.environ)
            log_folder = _log_folder(settings)
            server = place.listen(identity)
        except UserError as error:
            os.write(told, f'failed {error}'.encode())
            return 1
        except OSError as error:
            text = f'{place.path} cannot be written: {error.strerror}'
            os.write(told, f'failed {text}; make room there'.encode())
            return 1
        part = Part(server, settings, log_folder)
        os.write(told, f'ready {identity}'.encode())
        os.close(told)
        return _run_part(
            plan, settings, environment, log_folder, part, identity
        )
    finally:
        if server is not None:
            server.close()
            place.remove(identity)
            launcher_channel.PROGRAM.remove()


def _run_part(
    plan: Any,
    settings: PartSettings,
    environment: Mapping[str, str],
    log_folder: Path | None,
    part: Part,
    identity: str,
) -> int:
    store = None
    if log_folder is not None and settings.kept_logs is not None:
        store = LogStore(log_folder, settings.kept_logs, settings.logs_limit)
    with open(os.devnull, 'w', encoding='utf-8') as nothing:
        try:
            context = RunContext(
                environment=environment,
                log_folder=log_folder,
                stream=nothing,
                log_limit=settings.log_limit,
                log_store=store,
                tty=settings.tty,
                identity=identity,
                participants=(part,),
                is_hidden=True,
                about=About(
                    f'part of a launch on {settings.machine} that lost its '
                    'launcher',
                    None,
                    '',
                    settings.workspace or os.path.expanduser('~'),
                ),
                terminal_size=os.terminal_size(
                    (settings.columns, settings.rows)
                ),
            )
            return run(plan, context)
        except Exception:  # noqa: BLE001
            # the launcher has been sent it, see `Part.failed`
            return 1


def environment_of(
    settings: PartSettings, environment: Mapping[str, str]
) -> dict[str, str]:
    """
    Return the environment of the processes of a part.

    :param environment: That of a login there
    :raises WorkspaceError: when the workspace cannot be sourced
    """
    variables = {**environment, **settings.variables}
    if settings.workspace is None:
        return variables
    setup = Path(settings.workspace) / 'install' / 'setup.bash'
    return dict(source(setup, variables).variables)


def _log_folder(settings: PartSettings) -> Path | None:
    """Return the folder for the logs there, made, or None for none."""
    if settings.log_name is None:
        return None
    places = []
    if settings.workspace is not None:
        places.append(Path(settings.workspace) / 'log')
    places.append(Path(os.path.expanduser('~')) / '.ros' / 'log')
    for base in places:
        with suppress(OSError):
            base.mkdir(parents=True, exist_ok=True)
            if base.parent.name != '.ros':
                (base / _COLCON_IGNORE).touch()
            # on a shared file system the launcher or another machine has it
            for name in (
                settings.log_name,
                f'{settings.log_name}_{os.getpid()}',
            ):
                with suppress(FileExistsError):
                    (base / name).mkdir()
                    return base / name
    return None
