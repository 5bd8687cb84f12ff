# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""`--timeline`: show how a launch started, from its logs."""

from collections.abc import Iterator, Mapping
from contextlib import suppress
import json
import os
from pathlib import Path
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.messages import show
from colcon_yamllaunch.observers.log_files import EVENT_LOG, with_rotated
from colcon_yamllaunch.observers.timeline import (
    chain_as_text,
    page,
    timeline_of,
)
from colcon_yamllaunch.verb.log_folders import LOG_PATH, ros_log_folder
from colcon_yamllaunch.verb.options import LaunchOptions
from colcon_yamllaunch.verb.target import find_workspace

#: The page, in the log folder.
PAGE = 'timeline.html'


def show_timeline(
    options: LaunchOptions,
    log_base: str | None,
    environment: Mapping[str, str],
) -> int:
    """
    Write the page of a launch, print the longest chain, and return 0.

    :param log_base: What the user gives as `--log-base`
    :raises UserError: when there is no such log, or the page cannot be written
    """
    if len(options.names) > 1:
        raise UserError(
            f"--timeline takes one log folder, not '{options.names[1]}', too"
        )
    if options.names:
        folder = Path(options.names[0]).expanduser()
    else:
        folder = _latest(options, log_base, environment)
    if folder.name == EVENT_LOG:
        folder = folder.parent
    # not the link, as that changes with each launch
    folder = folder.resolve()
    timeline = timeline_of(_records(folder))
    if not timeline.starts:
        raise UserError(
            f"'{folder / EVENT_LOG}' has no process that started or waited"
        )
    path = folder / PAGE
    try:
        path.write_text(page(timeline, folder.name), encoding='utf-8')
    except OSError as e:
        raise UserError(f"cannot write '{path}': {e.strerror}") from e
    show(chain_as_text(timeline))
    show(os.path.relpath(path))
    return 0


def _latest(
    options: LaunchOptions,
    log_base: str | None,
    environment: Mapping[str, str],
) -> Path:
    """
    Return the log folder of the latest launch.

    :raises UserError: when there is none
    """
    root = find_workspace(options.workspace, ())
    given = log_base or environment.get(LOG_PATH)
    base = None if root is None else root / 'log'
    if given and given != os.devnull:
        base = Path(given).expanduser()
    places = [base] if base is not None else []
    places.append(ros_log_folder(environment))
    for place in places:
        latest = place / 'latest_launch'
        if (latest / EVENT_LOG).is_file():
            return latest
        found = [p.parent for p in place.glob(f'launch_*/{EVENT_LOG}')]
        if found:
            # their names have the time
            return max(found)
    raise UserError(
        f'there are no logs of a launch in {" or ".join(map(str, places))}',
        'name a log folder: --timeline LOG',
    )


def _records(folder: Path) -> Iterator[Mapping[str, Any]]:
    """
    Iterate over the records of a launch, those of rotated files first.

    :raises UserError: when they cannot be read
    """
    for path in with_rotated(folder / EVENT_LOG):
        try:
            with open(path, encoding='utf-8', errors='replace') as stream:
                for line in stream:
                    # the last line may not be complete
                    with suppress(ValueError):
                        record = json.loads(line)
                        if isinstance(record, dict):
                            yield record
        except OSError as e:
            raise UserError(
                f"cannot read '{path}': {e.strerror}",
                'a log folder is log/launch_… of a workspace',
            ) from e
