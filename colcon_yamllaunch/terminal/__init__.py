# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The terminal of a launch: its keys and its status block.

:mod:`.keymap` has the keys of the status block and of the full screen
(`full_screen/`), with their help. :mod:`.own_terminal` decides what a launch
uses of its terminal, and :mod:`.terminal_session` when.

- Keys: :mod:`.keyboard` reads bytes, :mod:`.key_decoder` makes keys of them,
  :mod:`.keys` finds what they mean, and :mod:`.key_acts` sends the commands.
- Status block: :mod:`.status_model` is the state of the launch with what keys
  changed, :mod:`.status_block` makes lines of it, and :mod:`.status_writer`
  draws them below the output.
- :mod:`.attachment` connects the keyboard to one process, and :mod:`.pager`
  lends the terminal to `$PAGER`.
"""
