# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Tells what the last builds on a machine made, to who watches files."""

from collections.abc import Callable
from collections.abc import Mapping
import os
from pathlib import Path
from typing import Any

from colcon_yamllaunch.common.fingerprint import Fingerprint
from colcon_yamllaunch.workspace.freshness.build_record import (
    DamagedRecordError,
)
from colcon_yamllaunch.workspace.freshness.build_record import read_record
from colcon_yamllaunch.workspace.freshness.build_record import RECORD_NAME

_LINK = 'link to '


def tell(
    arguments: Mapping[str, Any], _say: Callable[[str], None]
) -> dict[str, Any]:
    """
    Return what was installed and built of packages, file by file.

    Of each package there are `installed` and `products`: the paths, relative
    to the install space and to its folder below `build/`, with what tells
    their content.

    :param arguments: `build_base`, absolute, and the `packages`
    """
    build_base = Path(os.path.expanduser(arguments['build_base']))
    told = {}
    for name in arguments['packages']:
        try:
            record = read_record(build_base / name / RECORD_NAME)
        except DamagedRecordError:
            continue
        if record is not None:
            told[name] = {
                'installed': _contents(record.installed),
                'products': _contents(record.products),
            }
    return {'packages': told}


def _contents(files: Mapping[str, Fingerprint]) -> dict[str, str]:
    return {
        path: f'{found.digest} {found.executable:d}{_behind(found.digest)}'
        for path, found in files.items()
    }


def _behind(digest: str) -> str:
    """Tell the file that a link leads to, as it may change without a build."""
    if not digest.startswith(_LINK):
        return ''
    try:
        status = os.stat(digest.removeprefix(_LINK))
    except OSError:
        return ''
    return f' {status.st_mtime_ns} {status.st_size}'
