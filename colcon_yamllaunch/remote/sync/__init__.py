# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Sending the code of the workspace to a machine, and building it there.

Start with :mod:`.code_sync`. :mod:`.listing` and :mod:`.install_listing` list
what a machine needs, :mod:`.manifest` compares that with what is there, and
:mod:`.transfer` sends the difference by rsync. What others made or edited on
the machine is neither replaced nor deleted. :mod:`.build` runs colcon there.
"""
