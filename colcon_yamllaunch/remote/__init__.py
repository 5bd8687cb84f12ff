# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Parts of a launch on other machines.

Only launches with `--deploy` or `--on` import this.

- `plan_references` finds what a part of the plan needs, and `remote_paths` has
  the variables that are sent. The sub-package `deployment` has divided the
  plan.
- `connection/` connects with a machine (`ssh`, `slurm` or a command) and sends
  our program.
- `sync/` sends the code by rsync, and builds it there.
- `agent/` runs on the machine: it answers requests, and runs its part.
- The other modules are the launcher's side. `launch_machine` prepares a
  machine, and starts its part. While the launch runs, `remote_parts` is the
  participant in the launch. `remote_part` emits the events of a part here, and
  sends it commands. `machine_link` is a client of the control socket of a
  part. It detects a lost connection (silence in `_beat`, the end of the stream
  in `_receive`, that of the process in `ended`), handles that in `_lose`,
  connects again, and goes on where it was, so that everything arrives exactly
  once.
- `part_protocol` has what a part is given besides its plan, and the commands
  that only a launcher sends.

Output of a process there passes through `engine/relay`,
`control/journal`, `control/client_connection` and `agent/part_link` on the
machine, and through `machine_link`, `remote_part` and `engine/relay` here.

Before a launch, launcher and agent exchange messages as those of the control
protocol, see `agent/machine_agent`. A part that runs is a launch whose
launcher holds it by that protocol.
"""
