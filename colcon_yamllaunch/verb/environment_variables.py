# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The environment variables that colcon lists in its help."""

from colcon_core.environment_variable import EnvironmentVariable

#: How many former launches keep their folder, unless the user says otherwise.
KEPT_LOG_FOLDERS = 100
#: How many keep it if the user does.
LOG_FOLDERS = EnvironmentVariable(
    'COLCON_LAUNCH_LOG_FOLDERS',
    'How many former launches keep their folder in the log folder: a number '
    f'(default: {KEPT_LOG_FOLDERS}), or `all`',
)
#: Whether a launch has a control group; the runtime reads it.
CGROUP = EnvironmentVariable(
    'COLCON_LAUNCH_CGROUP',
    'Whether launches get a control group where one can be made: 0 for none',
)
#: Bytes that the log folders of all launches may take together, unless the
#: user says otherwise.
ALL_LOGS_LIMIT = 10_000_000_000
#: What they may take if the user does.
LOG_TOTAL = EnvironmentVariable(
    'COLCON_LAUNCH_LOG_TOTAL',
    'What the log folders of all launches may take together: a size such as '
    f'500MB (default: {ALL_LOGS_LIMIT // 10**9}GB), or `none`',
)
#: How long launch files in Python may take; the name is
#: `language.python_files.python_visit.TIMEOUT_VARIABLE`.
PYTHON_TIMEOUT = EnvironmentVariable(
    'COLCON_LAUNCH_PYTHON_TIMEOUT',
    'How many seconds may pass without a sign of life while a launch file in '
    'Python is read (default: 60)',
)
#: Whose workspaces are used; its name is `workspace.packages.trust.TRUST`.
TRUSTED = EnvironmentVariable(
    'COLCON_LAUNCH_TRUST',
    'Folders of other users whose workspaces are used, separated by colons, '
    'or `*` for those of everybody',
)
