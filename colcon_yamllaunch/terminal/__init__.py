# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Two views of a launch: the status block, and the full screen (`--ui`).

Both show the same launch: its state, and the commands that it executes.

- :mod:`.keymap` has the keys of both, each with its help and its effect.
- :mod:`.status_model` makes rows of the state, for both.
- :mod:`.line_filter` has the filter of the output that keys change in both,
  and applies it to the output above the status block.

The full screen is in `full_screen/`. The terminal that a launch was started in
is :mod:`.terminal_session`:

- Keys: :mod:`.keyboard` reads bytes and decodes keys, :mod:`.keys` handles
  them, and the session carries out what has an effect elsewhere.
- Status block: :mod:`.status_block` makes lines of rows, and
  :mod:`.status_writer` draws them below the output.
- :mod:`.attachment` connects the keyboard to one process, also where there is
  no status block, and :mod:`.pager` lends the terminal to `$PAGER`.

In other terminals, :mod:`.client_attachment` connects the keyboard to a
process of a running launch, and :mod:`.status_table` makes the text of
`--status`.
"""
