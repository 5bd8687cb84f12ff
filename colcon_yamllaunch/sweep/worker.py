# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The workers of a sweep: processes that plan and launch its runs.

They are forks of a process that has imported all modules and knows the
workspace, as a new program takes longer to import these than a short run
costs. A worker launches one run after the other, with one guard for all of
them, as each fork makes both processes copy their memory.
"""

from collections.abc import Callable
from collections.abc import Mapping
from contextlib import closing
from contextlib import suppress
import json
import os
import signal
import socket
import sys
from typing import Any

from colcon_yamllaunch.common.codec import to_json
from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.prctl import end_with_parent
from colcon_yamllaunch.engine.cgroup import expect_moves
from colcon_yamllaunch.engine.guard_link import GuardProcess
from colcon_yamllaunch.sweep.isolation import enter_own_network
from colcon_yamllaunch.sweep.isolation import VARIABLE
from colcon_yamllaunch.sweep.results import failed_run
from colcon_yamllaunch.sweep.run import first_error
from colcon_yamllaunch.sweep.run import NotBuiltError
from colcon_yamllaunch.sweep.run import perform
from colcon_yamllaunch.sweep.run import PlanError
from colcon_yamllaunch.sweep.run import Sweep
from colcon_yamllaunch.sweep.table import Run

#: Sent to a worker when its run may start processes.
GO = b'g'
#: Bytes that are kept of the messages of the planning of a run.
MESSAGES_SIZE = 64 * 1024
#: Files in the message of a run that is planned.
_MOST_USES = 500
#: Runs of a worker, so that it does not grow without end.
_RUNS = 100
#: Bytes of the number of a run.
_NUMBER = 32


def fork(action: Callable[[], int | None], output: int = -1) -> int:
    """
    Call `action` in a child process, and return the child's process id.

    The child has its own session, so keys of the terminal do not reach it, and
    the default signal handlers. The result of `action` is its exit code.

    :param output: The descriptor for standard output and error; -1 for none
    :raises OSError: when there can be no further process
    """
    pid = os.fork()
    if pid:
        return pid
    code = 1
    try:
        signal.set_wakeup_fd(-1)
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, signal.SIG_DFL)
        os.setsid()
        null = os.open(os.devnull, os.O_RDWR)
        os.dup2(null, 0)
        for target in (1, 2):
            os.dup2(null if output == -1 else output, target)
        os.close(null)
        code = action() or 0
    finally:
        os._exit(code)


def keep_moves_fast(parent: int) -> None:
    """
    Keep the kernel ready to move processes to control groups.

    Its first move waits for some 10 ms, moves soon after it do not, see
    :func:`.cgroup.expect_moves`. That is a tenth of a run of 0.1 s.
    """
    end_with_parent(signal.SIGTERM, parent)
    os.closerange(3, os.sysconf('SC_OPEN_MAX'))
    while expect_moves():
        pass


class Worker:
    """
    A worker process, in that process: plans and launches runs.

    :param link: The socket to the runner
    :param messages: The file that standard output and error go to
    :param domain: Its ROS_DOMAIN_ID
    """

    def __init__(
        self,
        sweep: Sweep,
        link: socket.socket,
        messages: int,
        domain: int,
        *,
        own_network: bool,
    ) -> None:
        self._sweep = sweep
        self._link = link
        self._messages = messages
        self._domain = domain
        self._own_network = own_network

    def work(self, parent: int, runs: Mapping[int, Run], run: Run) -> int:
        """
        Launch `run`, then those whose numbers arrive; return the exit code.

        :param parent: The runner; the worker ends with it
        """
        signal.signal(signal.SIGINT, signal.default_int_handler)
        try:
            with closing(GuardProcess(is_kept=True)) as guard:
                for left in reversed(range(_RUNS)):
                    if self._own_network:
                        enter_own_network(again=left + 1 < _RUNS)
                    # the new network has undone it
                    end_with_parent(signal.SIGTERM, parent)
                    message = self._launch(run, guard)
                    sys.stdout.flush()
                    sys.stderr.flush()
                    message['idle'] = left > 0 and message.get('idle', True)
                    self._send(message)
                    number = b''
                    if message['idle']:
                        number = self._link.recv(_NUMBER)
                    if not number:
                        break
                    run = runs[int(number)]
        except KeyboardInterrupt:
            return 130
        except Exception as e:  # noqa: BLE001 - the other runs go on
            with suppress(OSError):
                self._send(_error(run, f'internal error: {e!r}'))
            return 1
        finally:
            with suppress(Exception):
                sys.stdout.flush()
                sys.stderr.flush()
        return 0

    def _launch(self, run: Run, guard: GuardProcess) -> dict[str, Any]:
        """Plan a run, wait for its turn, and return its result."""
        sweep = self._sweep
        folder = sweep.folder.run_folder(run.number)
        try:
            planned = sweep.plan(run, folder, {VARIABLE: str(self._domain)})
        except NotBuiltError:
            return {'not built': True}
        except UserError as e:
            return _error(run, str(e))
        except PlanError:
            sys.stderr.flush()
            text = os.pread(self._messages, MESSAGES_SIZE, 0)
            return _error(run, first_error(text.decode(errors='replace')))

        def wait() -> None:
            self._send({'planned': planned.uses[:_MOST_USES]})
            if self._link.recv(len(GO)) != GO:
                raise KeyboardInterrupt

        def over() -> None:
            # a runner that is gone starts no other run
            with suppress(OSError):
                self._send({'over': True})

        try:
            result = perform(
                run.number, planned, folder, sweep.goal, guard, wait, over
            )
        finally:
            planned.close()
        if result is None:
            raise KeyboardInterrupt
        # the worker of a launch file in Python may leave something behind
        return {'result': to_json(result), 'idle': not planned.participants}

    def _send(self, message: dict[str, Any]) -> None:
        self._link.send(json.dumps(message).encode())


def _error(run: Run, reason: str) -> dict[str, Any]:
    return {'result': to_json(failed_run(run.number, reason))}
