# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

r"""
The worker: a program that visits Python launch files with ROS 2's `launch`.

It runs with the Python of the sourced environment, as `python3
FOLDER-OF-THIS-FILE`. It imports nothing of this project but its own modules,
and nothing of ROS 2 before it has said what is missing. ROS 2's own `launch`
and `launch_ros` visit the descriptions; what would start is only prepared, and
reported to the launcher. Start reading at `visit`, which answers requests.

It reads requests from its standard input and writes to its standard output,
as JSON, one object a line. What launch files print goes to standard error. It
ends when its input does, whatever it is doing then, with all that it started.
SIGINT is ignored: a terminal's Ctrl-C is the launcher's.

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
     "node": "/ns/name" or null, "is_container": false,
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
