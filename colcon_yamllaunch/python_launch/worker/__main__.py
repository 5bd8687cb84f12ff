# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Runs the worker from its folder, as `python3 FOLDER`.

Its package gets a name of its own, so that neither its modules nor others
beside its folder are found by launch files.
"""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec, module_from_spec, spec_from_file_location
import os
import signal
import sys

NAME = 'colcon_launch_worker'
#: What has to be there, and is imported only when a launch file does: with
#: `launch_ros` come the messages of ROS.
NEEDED = ('launch', 'launch_ros')


def main() -> None:
    """Answer requests until there are no more."""
    from .channel import Channel, log_output
    from .imports import run_later

    # a handler that does nothing, unlike SIG_IGN, is not for what is started
    signal.signal(signal.SIGINT, lambda *_: None)
    if os.getpgid(0) != os.getpid():
        os.setpgid(0, 0)
    channel = Channel()
    # prints are for a log, each when it is made
    sys.stdout = log_output(1)
    sys.stderr = log_output(2)
    missing = [name for name in NEEDED if not find_spec(name)]
    channel.say('found', missing=missing)
    if missing:
        return
    run_later()

    from .entries import Entries, install_logging
    from .events import Events
    from .extensions import Extensions
    from .imports import report_modules
    from .timers import Timers
    from .visit import Visitor

    visitor = Visitor(channel)
    visitor.packages.install()
    install_logging(visitor)
    visitor.renew_context()
    events = Events(visitor)
    Entries(visitor, events).install()
    Timers(visitor, events).install()
    Extensions(visitor)
    report_modules(visitor)
    visitor.run()


def _run_folder() -> None:
    """Import this folder as a package, and run it."""
    folder = sys.path.pop(0)
    spec = spec_from_file_location(
        NAME,
        os.path.join(folder, '__init__.py'),
        submodule_search_locations=[folder],
    )
    assert spec is not None
    sys.modules[NAME] = module_from_spec(spec)
    import_module(f'{NAME}.__main__').main()


if __name__ == '__main__':
    _run_folder()
