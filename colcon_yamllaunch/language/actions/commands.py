# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The commands of `$(command …)`."""

from collections.abc import Sequence
from contextlib import suppress
from functools import partial
import os
import select
import shutil
import signal
import subprocess

from colcon_yamllaunch.common.process_scan import (
    read_process,
    variable_of,
    young_processes,
)
from colcon_yamllaunch.language.evaluation.call import Call
from colcon_yamllaunch.language.syntax.diagnostics import error

#: The most that a command may write (bytes).
MAXIMUM_OUTPUT = 16 * 1024 * 1024
#: How many characters of its error output a message shows.
MAXIMUM_STDERR = 2000
#: By this variable what a command leaves running is found.
COMMAND_VARIABLE = 'COLCON_LAUNCH_COMMAND'

_CHUNK = 64 * 1024
#: What ends a launch that is being prepared.
_ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)


def run_command(call: Call, line: str, words: Sequence[str], mode: str) -> str:
    """
    Run a command and return its output; nothing that it started stays.

    :param line: The command as it is written
    :param words: Its words
    :param mode: How to treat output on stderr
    :raises LaunchError: when it fails or writes too much
    """
    walk = call.walk
    walk.has_run_programs = True
    mark = os.urandom(8).hex()
    environment = {**walk.scope_environment(), COMMAND_VARIABLE: mark}
    program = shutil.which(words[0], path=environment.get('PATH'))
    # one that comes while the command begins would leave it behind
    unblocked = signal.pthread_sigmask(signal.SIG_BLOCK, _ENDING)
    unblock = partial(signal.pthread_sigmask, signal.SIG_SETMASK, unblocked)

    def begin() -> None:
        # a group of its own, to end what it leaves running
        os.setpgid(0, 0)
        unblock()

    try:
        with subprocess.Popen(
            words,
            executable=program or words[0],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT if mode == 'capture' else subprocess.PIPE,
            env=environment,
            cwd=walk.cwd,
            preexec_fn=begin,
        ) as process:
            try:
                unblock()
                output, errors = _output(process)
            finally:
                _kill_all_of(process.pid, mark)
    except (OSError, ValueError) as e:
        raise error(
            f"the command '{line}' cannot be run: {e}",
            call,
            may_pass_after_build=True,
        ) from e
    finally:
        unblock()
    stderr = errors.decode(errors='replace').strip()[:MAXIMUM_STDERR]
    if len(output) > MAXIMUM_OUTPUT:
        raise error(
            f"the command '{line}' writes more than {MAXIMUM_OUTPUT} bytes",
            call,
        )
    if process.returncode != 0:
        raise error(
            f"the command '{line}' failed with exit code "
            f'{process.returncode}' + (f': {stderr}' if stderr else ''),
            call,
            may_pass_after_build=True,
        )
    if stderr and mode == 'warn':
        walk.warn(f"the command '{line}' said: {stderr}", call.position)
    elif stderr and mode == 'fail':
        raise error(
            f"the command '{line}' wrote to stderr: {stderr}",
            call,
            hint="add 'ignore', 'warn' or 'capture': "
            f"$(command '{line}' ignore)",
            may_pass_after_build=True,
        )
    return output.decode(errors='replace')


def _kill_all_of(pid: int, mark: str) -> None:
    """Kill a command that is not reaped yet, and what it leaves running."""
    with suppress(ProcessLookupError):
        os.killpg(pid, signal.SIGKILL)
    launcher = read_process(os.getpid())
    since = 0 if launcher is None else launcher.birth
    elders: set[tuple[str, int]] = set()
    # what left the group, by setsid(); it may fork meanwhile
    while left := [
        process.pid
        for process in young_processes(since, elders)
        if variable_of(process.pid, COMMAND_VARIABLE) == mark
    ]:
        for process_id in left:
            with suppress(ProcessLookupError):
                os.kill(process_id, signal.SIGKILL)


def _output(process: subprocess.Popen[bytes]) -> tuple[bytes, bytes]:
    """
    Return what a command writes, and the start of its errors.

    What it leaves running is not waited for, and a command that writes more
    than anybody reads is not either.
    """
    assert process.stdout is not None
    output, errors = bytearray(), bytearray()
    into = {process.stdout.fileno(): output}
    if process.stderr is not None:
        into[process.stderr.fileno()] = errors
    poll = select.poll()
    for descriptor in into:
        poll.register(descriptor, select.POLLIN)
    end = os.pidfd_open(process.pid)
    poll.register(end, select.POLLIN)
    has_ended = False
    try:
        while into and len(output) <= MAXIMUM_OUTPUT:
            ready = [found for found, _ in poll.poll(0 if has_ended else None)]
            if not ready:
                break
            if end in ready:
                has_ended = True
                poll.unregister(end)
                ready.remove(end)
            for descriptor in ready:
                chunk = os.read(descriptor, _CHUNK)
                into[descriptor] += chunk
                if not chunk:
                    poll.unregister(descriptor)
                    del into[descriptor]
            # of the errors only the start is shown
            del errors[4 * MAXIMUM_STDERR :]
        if not into and not has_ended:
            os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)
    finally:
        os.close(end)
    return bytes(output), bytes(errors)
