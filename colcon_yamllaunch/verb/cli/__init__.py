# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The command line: its options, positionals and messages.

Start with `options`, which has all options of the verbs; `option` defines
what an option is. `argv` prepares the words for colcon's parser,
`command_line` reads those that it leaves, and `launch_options` and
`sweep_options` check what they mean together.
"""
