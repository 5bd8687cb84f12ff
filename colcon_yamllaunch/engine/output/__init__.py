# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Bytes from and to processes, terminals and the screen.

:mod:`.relay` reads the output of processes, :mod:`.terminals` types at them,
and :mod:`.writer` writes to the screen without waiting for it.
:mod:`.signals` delivers signals to the loop.
"""
