# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The lines between the launcher and this program.

The worker reads requests from its standard input and writes to its standard
output, as JSON, one object a line. What launch files print goes to standard
error. It ends when its input does, whatever it is doing then, with all that it
started. SIGINT is ignored: a terminal's Ctrl-C is the launcher's.

Positions are `[path, line, column]`, both from 1. A process has an `id`, a
number that is never used again.

SCOPE is what actions leave to those behind them:

    {"configurations": {"name": "text"},
     "environment": {"NAME": "text", "UNSET": null},
        the variables that differ from the environment of this program
     "namespace": "/a" or null,
     "parameters": [{"name": "x.y", "value": 1.5}, {"file": "/p.yaml"}],
        values as `Parameter.as_json` has them (text, .inf and .nan as there)
     "remaps": [["from", "to"]],
     "uses_sim_time": false,
     "processes": 3}
        how many processes there are so far, which ROS 2 counts in their
        names; only the launcher says so

Requests, each answered in order, by any number of messages and then `done`:

    {"do": "start", "id": 1, "log_folder": "/…",
     "packages": {"name": {"prefix": "/ws/install/name", "built": true}}}
        the first one; the packages of the workspace
    {"do": "visit", "id": 2, "path": "/…/a.launch.py", "scope": SCOPE}
    {"do": "arguments", "id": 3, "path": "/…"}
        answered with {"say": "argument", "name", "default" (text or null),
        "description", "choices" (list or null), "conditional", "position",
        "file"} for each that the file and what it includes declare
    {"do": "action", "id": 4, "entity": ENTITY, "scope": SCOPE,
     "position": […], "file": "/…", "frontend": "yaml" or "xml"}
        an action of another package in a YAML or XML file; ENTITY is
        {"type": "gz_server", "attributes": {"name": text, bool, number, list,
        or a list of ENTITY}, "texts": {"name": what is written for one that
        YAML takes no text for}, "children": [ENTITY] (null in YAML where no
        list stands), "position": […]}; `file` is the path that the launch
        file goes by
    {"do": "substitute", "id": 5, "name": "subs-file", "arguments": ["text"],
     "position": […], "file": "/…", "scope": SCOPE}
        answered with {"say": "value", "text": "…"}
    {"do": "finish", "id": 6, "scope": SCOPE}
        once, when all launch files are read; what was emitted meanwhile is
        handled, and SCOPE is the one that event handlers run in
    {"do": "event", "id": 7, "event": EVENT}
        only where there are event handlers; EVENT is one of
        {"type": "start", "process": ID, "pid": 12}
        {"type": "exit", "process": ID, "returncode": -2, "respawns": false,
         "asked": false}
            `asked`: whether it was stopped, as by `--stop` or `--restart`
        {"type": "output", "process": ID, "stream": "stdout", "text": "…"}
        {"type": "state", "node": "/n", "from": "configuring" or null,
         "to": "inactive"}
        {"type": "shutdown", "reason": "…", "by_sigint": true}
            once, also when nothing runs any more (the reason "idle")
    {"do": "call", "id": 8, "number": 3}
        goes on with what was told as `call`

A `start` may have `arguments`, such as ["name:=value"]: those of the command
line, which some launch files look for in `sys.argv`. Without them, they find
the launch configurations of the scope there.

{"do": "where"} is answered at once, whatever is being done, with {"say":
"where", "frames": [as in an error]}: the user's own lines that are run.

Messages, in the order in which a launch executes them:

    {"say": "found", "missing": ["launch_ros"]}
        the first line of all; if any is missing, it ends
    {"say": "begin", "kind": "file" or "group" or "timer", "title": "…",
     "position": […], "period": 2.0, "cancel_on_shutdown": true,
     "on_ros_time": false}
        what follows stands inside, up to {"say": "end"}; the last three only
        for a timer. An `end` may have a better `title`
    {"say": "process", "id": 17, "program": "talker", "argv": […], "cwd": "/…"
     or null, "environment": {…} (as in SCOPE), "position": […],
     "output": "screen", "emulate_tty": false, "respawn": false,
     "respawn_delay": 0.0, "respawn_max_retries": -1,
     "sigterm_timeout": 5.0, "sigkill_timeout": 5.0,
     "on_exit_shutdown": false, "package": "p" or null,
     "node": "/ns/name" or null, "is_container": false, "shell": false,
     "is_lifecycle": false, "autostart": false,
     "parameters": [{"name": "x", "value": 1, "position": […]}]}
        a text of `argv` that names a file with parameters made for this
        process is {"content": "…", "parameters": […]} instead; `program` is
        what ROS 2 calls it without its number
    {"say": "component", "container": "/box", "package", "plugin", "name",
     "namespace", "remaps": ["a:=b"], "parameters": […],
     "extra_arguments": […], "is_lifecycle", "autostart", "position"}
    {"say": "message", "level": "INFO", "text": "…"}
    {"say": "shutdown", "reason": "…"}
    {"say": "change_state", "node": "/n", "transition": "configure",
     "position": […]}
    {"say": "signal", "process": ID, "signal": 2 (0: stop it), "position"}
    {"say": "call", "number": 3, "title": "…", "position": […]}
        what is left to the time when its turn comes
    {"say": "begin", "kind": "settled", "number": 3}
        what follows, up to the `end`, stands in the place of that `call`
    {"say": "condition", "text": "…", "taken": true, "position": […]}
    {"say": "package", "name": "p", "position": […]}
        a package that the launch names
    {"say": "executable", "package": "p", "name": "talker", "path": "/…",
     "position": […]}
    {"say": "file", "path": "/…/b.launch.py"}
        another launch file in Python that was read
    {"say": "read", "path": "/…/helpers.py"}
        a module that launch files have imported, unless it is installed
    {"say": "warning", "text": "…", "position": […]}
    {"say": "include", "ask": 1, "path": "/…/b.launch.yaml", "scope": SCOPE,
     "position": […]}
        a YAML or XML file that is included, which the launcher reads itself:
        it answers {"answer": 1, "scope": SCOPE}, or {"answer": 1, "failed":
        true} when it has told the user of errors. Before it answers, it may
        send requests, which are to be done first
    {"say": "locate", "ask": 2, "path": "/…"}
        answered with {"answer": 2, "path": "/…" or null}: the file to read for
        a path of a package that is not installed yet
    {"say": "handlers", "handlers": [{"event": "exit", "processes": [ID],
     "condition": "", "actions": ["start rviz2"], "position": […]}],
     "output": [ID]}
        before `done`, when they are others than before: all event handlers
        that there are, and whose output is to be told. `processes` is null for
        all of them and for what is not about processes; a text stands for one
        that has not been started. After the first `event` or `call`,
        `handlers` is only true or false: whether there are any
    {"say": "done", "id": 2, "scope": SCOPE}
        or with, instead of the scope,
        "error": {"text": "ValueError: …", "hint": "…" or null, "frames":
          [{"position": […], "end_column": 9 or null}],
          "package": "p" or null, "argument": name or null}
          the user's own frames, innermost last; `package`: one that is not
          there, or not built; `argument`: a required one that is not given
        "refused": "…"
          only `ros2 launch` itself can run it, and why
        "failed": true
          the launcher told the user of errors itself, in an `include`
        What was told before an error at an `event` or `call` holds, and a
        `shutdown` is among it, as ROS 2 ends the launch then.
"""

from __future__ import annotations

from collections.abc import Callable
import contextlib
import fcntl
import io
from itertools import count
from json import dumps, loads
import os
import queue
import signal
import threading
import time
from typing import Any

Json = dict[str, Any]

READ_SIZE = 1 << 16
#: Seconds in which a line may follow another without being written.
LONGEST_DELAY = 0.02
#: The first descriptor for the lines: launch files that make themselves
#: daemons close or write to low ones.
DESCRIPTOR = 200


def log_output(descriptor: int) -> io.TextIOWrapper:
    """Return a text stream to a log; each line is written when it is made."""
    return io.TextIOWrapper(
        io.BufferedWriter(_Log(descriptor, 'w', closefd=False)),
        errors='backslashreplace',
        line_buffering=True,
    )


class _Log(io.FileIO):
    """A log that ignores write errors, such as a full disk."""

    def write(self, data: Any, /) -> int:
        try:
            return super().write(data)
        except OSError:
            return len(data)


class Channel:
    """
    Reads lines in a thread of its own, and writes lines.

    The descriptors 0 and 1 are nothing and standard error from then on, for
    whatever launch files read, print and start. When there is no more to
    read, this program ends with all that it started, whatever it does then.
    A process that a launch file forks has no channel: it ends where it would
    answer.
    """

    def __init__(self) -> None:
        #: Returns what the main thread is doing, as frames.
        self.where: Callable[[], list[Json]] = list
        #: Called before this program ends.
        self.at_end: list[Callable[[], object]] = []
        self._input = _moved(0)
        self._output = _moved(1)
        nothing = os.open(os.devnull, os.O_RDONLY)
        os.dup2(nothing, 0)
        os.close(nothing)
        os.dup2(2, 1)
        self._asks = count(1)
        self._unwritten = b''
        self._written_at = 0.0
        self._writing = threading.Lock()
        self._lines: queue.SimpleQueue[Json] = queue.SimpleQueue()
        threading.Thread(target=self._read, daemon=True).start()
        os.register_at_fork(after_in_child=self._leave)

    def say(self, what: str, **fields: object) -> None:
        """
        Write a line; end where nobody reads.

        What closely follows another line is written with the next one, or
        before this program waits: each write may wake the launcher.
        """
        if self._output == -1:
            os._exit(0)
        line = (dumps({'say': what, **fields}) + '\n').encode()
        now = time.monotonic()
        with self._writing:
            self._unwritten += line
            if (
                now - self._written_at > LONGEST_DELAY
                or threading.current_thread() is not threading.main_thread()
            ):
                self._written_at = now
                self._write()

    def _write(self) -> None:
        data, self._unwritten = self._unwritten, b''
        try:
            while data:
                data = data[os.write(self._output, data) :]
        except OSError:
            self._end()

    def receive(self) -> Json:
        """Wait for a line."""
        with self._writing:
            self._write()
        line = self._lines.get()
        self._written_at = 0.0
        return line

    def ask(
        self, what: str, serve: Callable[[Json], object], **fields: object
    ) -> Json:
        """
        Write a line, wait for its answer and return that.

        :param serve: Does the requests that come before the answer
        """
        number = next(self._asks)
        self.say(what, ask=number, **fields)
        while True:
            line = self.receive()
            if line.get('answer') == number:
                return line
            serve(line)

    def _read(self) -> None:
        rest = b''
        while True:
            try:
                data = os.read(self._input, READ_SIZE)
            except OSError:
                data = b''
            if not data:
                self._end()
            *lines, rest = (rest + data).split(b'\n')
            for line in lines:
                request = loads(line)
                if request.get('do') == 'where':
                    # now, whatever else is being done
                    self.say('where', frames=self.where())
                else:
                    self._lines.put(request)

    def _leave(self) -> None:
        """Close the channel in a forked child."""
        for descriptor in (self._input, self._output):
            with contextlib.suppress(OSError):
                os.close(descriptor)
        self._input = self._output = -1

    def _end(self) -> None:
        try:
            for call in self.at_end:
                call()
        finally:
            for process in _started():
                with contextlib.suppress(OSError):
                    os.kill(process, signal.SIGKILL)
            os._exit(0)


def _moved(descriptor: int) -> int:
    try:
        return fcntl.fcntl(descriptor, fcntl.F_DUPFD_CLOEXEC, DESCRIPTOR)
    except OSError:
        # so many are not allowed
        return os.dup(descriptor)


def _started() -> list[int]:
    """Return the processes that this one, or one of those, has started."""
    children: dict[int, list[int]] = {}
    group = []
    for name in os.listdir('/proc'):
        if name.isdigit():
            try:
                with open(f'/proc/{name}/stat', 'rb') as file:
                    fields = file.read().rpartition(b')')[2].split()
            except OSError:
                continue
            children.setdefault(int(fields[1]), []).append(int(name))
            if int(fields[2]) == os.getpid():
                # whoever started it may have ended
                group.append(int(name))
    pending = [os.getpid()]
    found = set(group)
    while pending:
        inner = children.get(pending.pop(), [])
        found.update(inner)
        pending += inner
    return sorted(found - {os.getpid()})
