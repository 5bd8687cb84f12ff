# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Parts of a launch on other machines.

Only a launch with a deployment file (`--deploy`) imports this.

- `deployment/` reads the file and assigns the parts of the plan to machines.
  `remote_paths` has the variables that are sent.
- `connection/` connects with a machine (`ssh`, `slurm` or a command) and sends
  our program.
- `sync/` sends the code by rsync, and builds it there.
- `agent/` runs on the machine: it answers requests, and runs its part.
- `link/` is the launcher's side while the launch runs: `machine_link` detects
  a lost connection (`_lose`) and connects again, and `remote_part` passes on
  what happens there as events.
- `wire/` has the messages of a connection. `numbered` delivers each of them
  exactly once, also over several connections.
"""
