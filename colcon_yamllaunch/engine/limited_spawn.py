# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Starting programs with limits, another priority, or as another user.

posix_spawn() can do none of that. Python could be started in between, but
takes longer than all else. So a fork of this process sets the limits for
itself, and becomes the program; whatever goes wrong there is passed on before.

Only launches with limits import this.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
import errno
from functools import cache
import json
import os
import pwd
import resource
import signal
import struct
from typing import Any, NoReturn

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.engine.spawn import StartError
from colcon_yamllaunch.plan.member_settings import ResourceLimits, Scheduling

#: What the system refuses: a key of the deployment file, :data:`GROUP` or the
#: program, and the number of the error.
Problem = tuple[str, int]

#: Stands for entering a control group in a `Problem`.
GROUP = 'group'
_PROGRAM = ''
# of sched_setattr(2), which neither Python nor older C libraries have
_SET_SCHEDULING = {
    'x86_64': 314,
    'aarch64': 274,
    'riscv64': 274,
    'ppc64le': 355,
    's390x': 345,
    'i686': 351,
    'armv7l': 380,
}
_SCHED_DEADLINE = 6
_RESET_ON_FORK = 1
_ATTRIBUTES = struct.Struct('=IIQiIQQQ')
_NANOSECONDS = 1e9
# `CPU_SETSIZE` of Linux
_MAXIMUM_CPUS = 1024
#: Folders that another user can mostly not write to.
_FOLDER_VARIABLES = ('ROS_LOG_DIR', 'XDG_RUNTIME_DIR')


@dataclass(frozen=True, slots=True)
class Restrictions:
    """
    What a process sets for itself before it becomes the program.

    :param limits: Those that it sets by itself; its group has the others
    :param user: The name or number of a user, or an empty text
    :param folder: The folder of its control group, if it is to enter one
    :param is_memory_own: Whether `memory` is set by RLIMIT_DATA
    """

    limits: ResourceLimits = ResourceLimits()
    user: str = ''
    folder: str | None = None
    is_memory_own: bool = False

    def steps(self) -> Iterable[tuple[str, Callable[[], object]]]:
        """Return the steps in order, each with its key in the file."""
        limits, folder = self.limits, self.folder
        if folder is not None:
            yield GROUP, lambda: _enter(folder)
        if limits.oom is not None:
            yield 'oom', lambda: _set_oom_score(limits.oom)
        if limits.nice is not None:
            nice = limits.nice
            yield 'nice', lambda: os.setpriority(os.PRIO_PROCESS, 0, nice)
        if limits.cpus:
            yield 'cpus', lambda: _set_cpus(limits.cpus)
        if (scheduling := limits.scheduling) is not None:
            yield 'scheduling', lambda: _set_scheduling(scheduling)
        if self.user:
            yield 'user', lambda: _become(self.user)


def tried(restrictions: Restrictions) -> list[Problem]:
    """Return which restrictions the system refuses."""

    def body() -> list[Problem]:
        found = []
        for key, step in restrictions.steps():
            try:
                step()
            except OSError as error:
                found.append((key, error.errno or errno.EINVAL))
        return found

    if not list(restrictions.steps()):
        return []
    pid, problems = _forked(body)
    os.waitpid(pid, 0)
    return problems


class LimitedSpawn:
    """
    Starts programs as :func:`os.posix_spawn` does, with restrictions.

    :param explain: Returns the error for a restriction that cannot be set
    :raises StartError: when there is no such user
    """

    def __init__(
        self,
        restrictions: Restrictions,
        explain: Callable[[Problem], StartError],
    ) -> None:
        self._restrictions = restrictions
        self._explain = explain
        #: The user that they run as, None for that of the launch.
        self.user: pwd.struct_passwd | None = None
        if restrictions.user:
            try:
                self.user = user_of(restrictions.user)
            except KeyError:
                name = restrictions.user
                raise StartError(f"there is no user '{name}'") from None

    def complete(
        self,
        environment: dict[str, str],
        given: Iterable[tuple[str, str | None]],
    ) -> None:
        """
        Add the variables of its user to those of a process.

        :param given: Those that the plan sets, which stay
        """
        user = self.user
        if user is None:
            return
        own = dict.fromkeys(('USER', 'LOGNAME'), user.pw_name)
        own['HOME'] = user.pw_dir
        fixed = dict(given)
        for variable in own.keys() - fixed.keys():
            environment[variable] = own[variable]

    def __call__(
        self,
        program: str,
        argv: Sequence[str],
        environment: Mapping[str, str],
        *,
        file_actions: Iterable[tuple[int, int, int]],
        setsigdef: Iterable[int],
        **_options: Any,
    ) -> int:
        """
        Start a program in a group of its own; see :func:`os.posix_spawn`.

        :raises OSError: when the program cannot be executed
        :raises StartError: when a restriction cannot be set
        """
        restrictions = self._restrictions
        memory = restrictions.limits.memory
        if not restrictions.is_memory_own:
            memory = None
        elif memory is not None:
            # imported before, as the fork has no memory for it
            _libc()

        def body() -> list[Problem]:
            os.setpgid(0, 0)
            for _, source, target in file_actions:
                os.dup2(source, target)
                os.set_inheritable(target, True)
            if restrictions.user:
                _give_outputs(restrictions.user)
            for key, step in restrictions.steps():
                try:
                    step()
                except OSError as error:
                    return [(key, error.errno or errno.EINVAL)]
            variables = dict(environment)
            if restrictions.user:
                _drop_folders(variables)
            for number in setsigdef:
                signal.signal(number, signal.SIG_DFL)
            signal.pthread_sigmask(signal.SIG_SETMASK, ())
            try:
                _execute(program, argv, variables, memory)
            except OSError as error:
                return [(_PROGRAM, error.errno or errno.EINVAL)]

        pid, problems = _forked(body)
        if not problems:
            return pid
        os.waitpid(pid, 0)
        key, number = problems[0]
        if key == _PROGRAM and number == errno.EACCES and self.user:
            # we may execute more than that user
            raise StartError(
                f"{self.user.pw_name} may not execute '{program}', or not "
                'enter its folder',
                f'see who may: namei -l {program}',
            )
        if key == _PROGRAM:
            raise OSError(number, os.strerror(number))
        raise self._explain((key, number))


def user_of(name: str) -> pwd.struct_passwd:
    """
    Return a user.

    :param name: Its name or number
    :raises KeyError: when there is none
    """
    try:
        return pwd.getpwnam(name)
    except KeyError:
        if name.isdecimal():
            return pwd.getpwuid(int(name))
        raise


def can_schedule(scheduling: Scheduling) -> bool:
    """Return whether we know how to set a scheduling policy here."""
    machine = os.uname().machine
    return scheduling.policy != 'deadline' or machine in _SET_SCHEDULING


def available_cpus() -> set[int]:
    """Return the processors that our processes may run on."""
    before = os.sched_getaffinity(0)
    # the kernel takes those away that we may not have
    os.sched_setaffinity(0, range(_MAXIMUM_CPUS))
    found = os.sched_getaffinity(0)
    os.sched_setaffinity(0, before)
    return found


def _forked(body: Callable[[], list[Problem]]) -> tuple[int, list[Problem]]:
    """
    Call a function in a fork of this process, which ends with it.

    Return its process id, and what the function has returned; nothing if it
    became a program.
    """
    reader, writer = os.pipe()
    # none reaches our handlers in the fork
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
    pid = os.fork()
    if not pid:
        _end_after(body, writer)
    signal.pthread_sigmask(signal.SIG_SETMASK, mask)
    os.close(writer)
    with open(reader, 'rb') as file:
        text = file.read()
    return pid, [(key, n) for key, n in json.loads(text or b'[]')]


def _end_after(body: Callable[[], list[Problem]], writer: int) -> NoReturn:
    problems: list[Problem] = [(_PROGRAM, errno.EINVAL)]
    try:
        problems = body()
    except MemoryError:
        problems = [('memory', errno.ENOMEM)]
    finally:
        os.write(writer, json.dumps(problems).encode())
        os._exit(1)


def _enter(folder: str) -> None:
    _write(f'{folder}/cgroup.procs', '0')


def _set_oom_score(score: int | None) -> None:
    _write('/proc/self/oom_score_adj', str(score))


def _set_cpus(cpus: Iterable[int]) -> None:
    os.sched_setaffinity(0, cpus)
    # the kernel ignores those that there are not
    if os.sched_getaffinity(0) != set(cpus):
        raise OSError(errno.EINVAL, os.strerror(errno.EINVAL))


def _set_scheduling(scheduling: Scheduling) -> None:
    if scheduling.policy != 'deadline':
        policy = {'fifo': os.SCHED_FIFO, 'rr': os.SCHED_RR}[scheduling.policy]
        os.sched_setscheduler(0, policy, os.sched_param(scheduling.priority))
        return
    times = (
        round(seconds * _NANOSECONDS)
        for seconds in (
            scheduling.runtime,
            scheduling.deadline,
            scheduling.period,
        )
    )
    # a thread with this policy may start others only if they do not have it
    attributes = _ATTRIBUTES.pack(
        _ATTRIBUTES.size, _SCHED_DEADLINE, _RESET_ON_FORK, 0, 0, *times
    )
    number = _SET_SCHEDULING[os.uname().machine]
    libc = _libc()
    if libc.syscall(number, 0, attributes, 0):
        raise _last_error()


def _become(name: str) -> None:
    user = user_of(name)
    if user.pw_uid == os.geteuid():
        return
    groups = os.getgrouplist(user.pw_name, user.pw_gid)
    os.setgroups(groups)
    os.setresgid(*(user.pw_gid,) * 3)
    os.setresuid(*(user.pw_uid,) * 3)


def _give_outputs(name: str) -> None:
    """Let a user open /dev/stdout and /dev/stderr."""
    with suppress(OSError):
        for descriptor in (1, 2):
            os.fchown(descriptor, user_of(name).pw_uid, -1)


def _drop_folders(variables: dict[str, str]) -> None:
    """Remove variables that name folders which we cannot write to."""
    for name in _FOLDER_VARIABLES:
        folder = variables.get(name)
        if folder is not None and not os.access(folder, os.W_OK):
            del variables[name]


def _execute(
    program: str,
    argv: Sequence[str],
    environment: Mapping[str, str],
    memory: int | None,
) -> NoReturn:
    """
    Become a program.

    :param memory: How much each of its processes may have; None for no limit
    :raises OSError: when it cannot be executed
    """
    if memory is None:
        os.execve(program, list(argv), environment)
    variables = [f'{name}={value}' for name, value in environment.items()]
    path = os.fsencode(program)
    arguments, given = _c_array(argv), _c_array(variables)
    libc = _libc()
    # this process may have more already, and so gets no more memory
    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    if hard != resource.RLIM_INFINITY:
        memory = min(memory, hard)
    resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))
    libc.execve(path, arguments, given)
    raise _last_error()


def _write(path: str, text: str) -> None:
    descriptor = os.open(path, os.O_WRONLY | os.O_CLOEXEC)
    try:
        os.write(descriptor, text.encode())
    finally:
        os.close(descriptor)


@cache
def _libc() -> Any:
    # few launches need it
    import ctypes

    return ctypes.CDLL(None, use_errno=True)


def _c_array(texts: Sequence[str]) -> Any:
    import ctypes

    return (ctypes.c_char_p * (len(texts) + 1))(*map(os.fsencode, texts), None)


def _last_error() -> OSError:
    import ctypes

    number = ctypes.get_errno()
    return OSError(number, os.strerror(number))
