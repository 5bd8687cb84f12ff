# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Runs a plan: starts, watches, restarts and stops its processes.

Input: a plan, an environment and observers. Output: events, and an exit code.
Start with :mod:`.engine`, which connects the loop, processes, output and
signals; a signal such as Ctrl-C arrives in `Engine._stop_by`.

- :mod:`.supervisor` decides what is started, restarted (`respawn_delay`) and
  stopped, and when. It does not touch the system.
- :mod:`.events` declares what can happen, and :mod:`.event_codec` reads events
  of other machines. :mod:`.state` is the state of the launch, which only
  events change; it has what failed. `run.py` (`_Launch.finish`) decides the
  exit code from that, from `--until` and `--for`, and from output errors.
- :mod:`.commands` declares what can be requested, and :mod:`.dispatcher`
  executes it. The second Ctrl-C, or the first one while the launch is being
  stopped already, is the command `Escalate`: `Supervisor.escalate` sends the
  next of SIGINT, SIGTERM and SIGKILL at once, and drops timers.
- :mod:`.loop` waits for descriptors and timers. :mod:`.limits` has the
  timeouts and limits.
- :mod:`.process_starter` and `process/` start programs, `output/` reads what
  they write, and `stopping/` ends them; its guard does so if the launcher is
  killed. :mod:`.orphans` finds what a process left running.
- :mod:`.helper_process` runs our own programs, such as the ROS client of
  `components/`, which loads components and changes lifecycle states.
- :mod:`.participants` declares what can take part in a launch beside the
  engine: the watcher, the parts on other machines, Python launch files.
- :mod:`.launch` is the interface to a running launch, here, in another process
  or on a machine. :mod:`.outcome` judges how a process ended, and says what
  follows (`delay_of_respawn`).
- :mod:`.exit_conditions` ends a launch by itself (`--until`, `--for`).
"""
