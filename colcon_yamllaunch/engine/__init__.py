# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Runs a plan: starts, watches, restarts and stops its processes.

Input: a plan, an environment and observers. Output: events, and an exit code.
Start with :mod:`.engine`, which connects the loop, processes, output and
signals; a signal such as Ctrl-C arrives in `Engine._stop_by`.

A member of a launch is a process or a component. A part of a launch is what
runs on one machine.

State and decisions, without the system:

- :mod:`.supervisor` decides what is started and stopped, and when.
  :mod:`.process_stop` decides which signals a process gets when it is stopped.
  :mod:`.outcome` says how a process ended, and :mod:`.restarts` whether and
  when it starts again (`respawn` of launch files, `restart` of deployment
  files).
- :mod:`.events` declares what can happen, and :mod:`.event_codec` reads events
  of other machines. :mod:`.state` is the state of the launch, which only
  events change; it has what failed. `run.py` (`_Launch.finish`) decides the
  exit code from that, from its exit conditions, and from output errors.
- :mod:`.commands` declares what can be requested, and :mod:`.dispatcher`
  executes it. The second Ctrl-C, or the first one while the launch is being
  stopped already, is the command `Escalate`: `Supervisor.escalate` sends the
  next of SIGINT, SIGTERM and SIGKILL at once, and drops timers.
- :mod:`.exit_conditions` ends a launch by itself (`--until`, `--for`,
  `--timeout`), and :mod:`.line_pattern` searches output in bounded time.
- :mod:`.readiness` finds out which members are ready, by :mod:`.ready_checks`
  and, for what only ROS knows, :mod:`.ros_ready_checks`;
  :mod:`.held_entries` holds back what waits for them.
- :mod:`.participants` declares what can take part in a launch beside the
  engine: the watcher, the parts on other machines, Python launch files.

The system:

- :mod:`.loop` waits for descriptors, timers, signals and children.
  :mod:`.limits` has the timeouts and limits.
- :mod:`.process_starter` starts the processes of the plan: :mod:`.spawn` each
  in its process group, :mod:`.cgroup` in the control group of the launch,
  :mod:`.line_buffering` so that lines show at once. :mod:`.own_files` has
  their parameter files.
- :mod:`.resource_limits` finds out which limits of a deployment file this
  machine can set, :mod:`.limit_groups` has those of control groups, and
  :mod:`.limited_spawn` starts processes with limits or as another user.
- :mod:`.channels` makes their pipes and terminals, :mod:`.relay` reads what
  they write and cuts it into :mod:`.lines`, :mod:`.terminals` types at them,
  and :mod:`.writer` writes to the screen without waiting for it.
- :mod:`.launch_scan` finds the processes of a launch, also those that lost
  their parent. :mod:`.guard` is a process that stops them if the launcher is
  killed; :mod:`.guard_link` starts it.
- :mod:`.debugging` and :mod:`.description` are about one process on request.

ROS, for components, lifecycle nodes and timers on ROS time:

- :mod:`.composition` has the components and their containers, and
  :mod:`.lifecycles` the lifecycle nodes. They receive calls of the supervisor
  and messages of the ROS client, and send it :mod:`.ros_requests`.
- :mod:`.ros_client` is that program, which alone uses ROS; :mod:`.ros_link`
  runs it, as a :mod:`.helper_process`. It checks readiness conditions by
  :mod:`.ros_conditions`.
- A load that its container refuses is not retried. A component is loaded again
  when its container starts again (`Composition.started`), and when a container
  came back without it or a new ROS client has started (`_request_open`). The
  client sends a call again only if the container that got it has ended
  (`_repeat`).
"""
