# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the `output` attribute of a process means."""

_ALL = frozenset(('stdout', 'stderr'))
_NONE: frozenset[str] = frozenset()

#: The streams of a process that the screen shows, by output mode.
SHOWN = {
    'both': _ALL,
    'screen': _ALL,
    'log': frozenset(('stderr',)),
    'own_log': _NONE,
    'full': _ALL,
}
#: The output modes that write to the log file of the whole launch.
IN_COMMON_LOG = frozenset(('both', 'log', 'full'))
#: The output modes that write to log files of the process itself.
IN_OWN_LOG = frozenset(('both', 'log', 'own_log', 'full'))
