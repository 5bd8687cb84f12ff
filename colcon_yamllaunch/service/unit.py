# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The unit file of a launch, see `systemd.service(5)`, and its environment."""

from collections.abc import Iterator, Mapping, Sequence
from fnmatch import fnmatchcase

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.start_order import dependencies_of, stages_of

#: What the first line of a unit file begins with that is made here.
MARK = '# made by colcon launch --install-service'
#: Seconds without a sign of life after which systemd restarts the launch.
WATCHDOG_SECONDS = 30
#: Seconds from the end of a launch that failed to its next start.
RESTART_SECONDS = 5
#: Seconds to stop besides those that processes may take: a process that the
#: kernel does not end is waited for, and so is the guard.
STOP_MARGIN = 15.0
#: The folder below `/run` with the folders for control sockets.
RUNTIME_FOLDER = 'colcon_launch'
#: The variables that a service has like the terminal it was installed from;
#: it also has those that the workspace sets.
KEPT_VARIABLES = (
    *('PATH', 'LD_LIBRARY_PATH', 'PYTHON*', 'LANG', 'LC_*'),
    *('TZ', 'AMENT_*', 'CMAKE_PREFIX_PATH', 'COLCON_*', 'ROS_*', 'RMW_*'),
    *('RCUTILS_*', 'RCL_*', 'CYCLONEDDS_*', 'FASTRTPS_*', 'FASTDDS_*'),
    *('ZENOH_*', 'GZ_*', 'IGN_*', 'GAZEBO_*', 'CUDA_*'),
)
#: Those that are about the launch that installs it, or about sources.
DROPPED_VARIABLES = (
    *('COLCON_LOG_PATH', 'COLCON_LAUNCH_ID', 'ROS_WORKSPACE', 'PWD'),
    *('OLDPWD', 'SHLVL', '_'),
)


@dataclass(frozen=True, slots=True)
class Unit:
    """
    What a unit file says.

    :param title: What is launched
    :param command: The command line that runs the plan
    :param environment: The path of the file with its environment
    :param name: The name of the service
    :param user: The user that a service of the system runs as; None for a
      service of a user
    :param has_journal: Whether the journal has the output, and not log files
    """

    name: str
    title: str
    command: Sequence[str]
    environment: str
    user: str | None
    has_journal: bool

    def text(self, plan: Plan) -> str:
        """Return the unit file that runs a plan."""
        return '\n'.join((*self._lines(plan), ''))

    def _lines(self, plan: Plan) -> Iterator[str]:
        title = _literal(self.title)
        yield f'{MARK} {title}'
        yield f'# To change it: systemctl edit {self.name}'
        yield '[Unit]'
        yield f'Description={title} (colcon launch)'
        if self.user is not None:
            # the manager of a user has no such unit, and starts later anyway
            yield 'Wants=network-online.target'
            yield 'After=network-online.target'
        yield '\n[Service]'
        yield 'Type=notify'
        yield 'NotifyAccess=main'
        yield f'ExecStart={" ".join(map(_quoted, self.command))}'
        yield 'WorkingDirectory=/'
        yield f'EnvironmentFile={_literal(self.environment)}'
        if self.has_journal:
            yield 'Environment=COLCON_LOG_PATH=/dev/null'
        else:
            # its lines are in launch.log
            yield 'StandardOutput=null'
        yield f'SyslogIdentifier={self.name}'
        yield 'Restart=on-failure'
        yield f'RestartSec={RESTART_SECONDS}'
        # the launch reports what is not ready in time
        yield 'TimeoutStartSec=infinity'
        yield f'TimeoutStopSec={stop_seconds(plan):g}'
        yield f'WatchdogSec={WATCHDOG_SECONDS}'
        # the launch stops its processes in order also then
        yield 'WatchdogSignal=SIGTERM'
        yield 'KillMode=mixed'
        yield 'Delegate=yes'
        if self.user is not None:
            yield f'User={self.user}'
            yield f'RuntimeDirectory={RUNTIME_FOLDER}/{self.name}'
            yield 'RuntimeDirectoryMode=0700'
        yield '\n[Install]'
        target = 'default' if self.user is None else 'multi-user'
        yield f'WantedBy={target}.target'


def stop_seconds(plan: Plan) -> float:
    """Return how long a launch may take to stop, stage by stage."""
    timeouts = {
        process.label: process.sigterm_timeout + process.sigkill_timeout
        for process in plan.processes()
    }
    stages = stages_of(dependencies_of(plan.members()))
    longest = (max(timeouts.get(n, 0.0) for n in stage) for stage in stages)
    return STOP_MARGIN + sum(longest)


def environment_text(variables: Mapping[str, str]) -> str:
    """
    Return variables as a file for `EnvironmentFile=` (`systemd.exec(5)`).

    What is not UTF-8 is left out, as systemd would refuse the whole file.
    """
    return ''.join(
        f'{name}={_assigned(value)}\n'
        for name, value in sorted(variables.items())
        if _is_text(name + value)
    )


def kept_variables(
    sourced: Mapping[str, str], user: Mapping[str, str]
) -> dict[str, str]:
    """
    Return the variables of a service.

    :param sourced: The environment with the workspace sourced
    :param user: The environment of the terminal, without it
    """
    return {
        name: value
        for name, value in sourced.items()
        if name not in DROPPED_VARIABLES
        and (
            user.get(name) != value
            or any(fnmatchcase(name, pattern) for pattern in KEPT_VARIABLES)
        )
    }


def _literal(text: str) -> str:
    """Return a text in which systemd replaces nothing, as one line."""
    return ' '.join(text.split()).replace('%', '%%')


def _quoted(word: str) -> str:
    """Return a word of a command line (`systemd.service(5)`)."""
    escaped = word.replace('\\', r'\\').replace('"', r'\"')
    return '"{}"'.format(escaped.replace('%', '%%').replace('$', '$$'))


def _assigned(value: str) -> str:
    for character in '\\"`$':
        value = value.replace(character, f'\\{character}')
    return f'"{value}"'


def _is_text(text: str) -> bool:
    # bytes that are not UTF-8 are surrogates here; null bytes cannot occur
    return not any('\ud800' <= character <= '\udfff' for character in text)
