# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Sending the code of the workspace to a machine, and building it there.

Start with :mod:`.code_sync`. :mod:`.listing` lists the files that a machine
needs, :mod:`.manifest` compares them with those there, and :mod:`.transfer`
sends the difference by rsync (:mod:`.rsync_shell`). Files that others made or
edited on the machine are neither replaced nor deleted. :mod:`.build` runs
colcon there (:mod:`.colcon_build`), and :mod:`.inspection` looks at files and
packages there. `agent/machine_agent` calls the functions that take `arguments`
and `say`, by the names of their modules.
"""
