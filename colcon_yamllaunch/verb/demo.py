# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""`colcon launch --demo`: a launch of a copy of the sample workspace."""

from collections.abc import Callable, Mapping
import os
from pathlib import Path
import signal
import tempfile
from typing import Any, TYPE_CHECKING

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.messages import say
from colcon_yamllaunch.verb.options import LaunchOptions
from colcon_yamllaunch.workspace.create.sample import copy_sample, LAUNCH_FILE

if TYPE_CHECKING:
    from colcon_yamllaunch.verb.background_launch import Background

_HINT = (
    'This was a copy of the sample workspace. To get your own: '
    'colcon create --example'
)

_Launch = Callable[
    [LaunchOptions, Any, Mapping[str, str], 'Background | None'], int
]


def launch_demo(
    launch: _Launch,
    options: LaunchOptions,
    known: Any,
    environment: Mapping[str, str],
    background: 'Background | None' = None,
) -> int:
    """
    Launch a copy of the sample workspace, and remove it with its logs.

    :param launch: Launches what the options say
    :param background: Where the launch goes, if another process shows it
    :raises UserError: when there is no room for the copy
    """
    cwd = Path.cwd()
    try:
        folder = tempfile.TemporaryDirectory(
            prefix='colcon-demo-', ignore_cleanup_errors=True
        )
    except OSError as e:
        raise UserError(
            f'--demo needs a temporary folder: {e.strerror}',
            'name a folder that can be written to: TMPDIR=FOLDER',
        ) from e
    with folder:
        root = Path(folder.name, 'sample_ws')
        copy_sample(root)
        os.chdir(root)
        try:
            code = launch(
                options.replaced(positionals=LAUNCH_FILE, workspace=root),
                known,
                {**environment, 'ROS_LOG_DIR': str(root / 'log')},
                background,
            )
        finally:
            # nothing is left, even after one more Ctrl-C
            signal.signal(signal.SIGINT, signal.SIG_IGN)
            os.chdir(cwd)
    if not options.quiet:
        say(_HINT)
    return code
