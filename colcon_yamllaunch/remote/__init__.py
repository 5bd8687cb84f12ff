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
- `link/` is the launcher's side while the launch runs. `machine_link` is a
  client of the control socket of a part. It detects a lost connection (silence
  in `_beat`, the end of the stream in `_receive`, that of the process in
  `ended`), handles that in `_lose`, connects again, and goes on where it was,
  so that everything arrives exactly once. `remote_part` emits the events of a
  part here, and sends it commands. `remote_parts` is the participant in the
  launch.
- `part_commands` has the commands that only a launcher sends, and
  `part_settings` what a part is given besides its plan.

Output of a process there passes through `engine/relay`,
`control/journal`, `control/client_connection` and `agent/part_link` on the
machine, and through `link/machine_link`, `link/remote_part` and
`engine/relay` here.

Before a launch, launcher and agent exchange frames (`connection/frames`). A
part that runs is a launch whose launcher holds it by the control protocol.
"""
