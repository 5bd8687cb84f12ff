# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Finding packages on the machine, for `sync: none`. Runs there."""

from collections.abc import Callable
from collections.abc import Mapping
from contextlib import suppress
import os
from pathlib import Path
import re
from typing import Any

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.common.fingerprint import digest
from colcon_yamllaunch.common.search_path import split_path
from colcon_yamllaunch.common.text_files import content_of
from colcon_yamllaunch.workspace.environment.environment_cache import (
    cached_environment,
)

Say = Callable[[str], None]

_VERSION = re.compile(rb'<version\b[^>]*>\s*([^<\s]+)\s*</version>')

_MARKERS = (
    'share/{}/package.xml',
    'share/colcon-core/packages/{}',
    'share/ament_index/resource_index/packages/{}',
)


def find(arguments: Mapping[str, Any], say: Say) -> dict[str, Any]:
    """
    Find packages in the environment of the workspace.

    The arguments are `workspace`, its root; `install_base` and `build_base`,
    relative to it; and `names`. Return the digest and the version of the
    manifest of each package that was `found`, both empty without a manifest;
    and the `prefixes` that were searched.
    """
    root = Path(os.path.realpath(Path(arguments['workspace']).expanduser()))
    install_base = root / arguments['install_base']
    names = list(arguments['names'])
    prefixes = [install_base, *(install_base / name for name in names)]
    found = {n: m for n in names if (m := _manifest(n, prefixes)) is not None}
    missing = [name for name in names if name not in found]
    if missing:
        variables: Mapping[str, str] = os.environ
        setup = install_base / 'setup.bash'
        if setup.is_file():
            try:
                variables = cached_environment(
                    setup, os.environ, root / arguments['build_base']
                ).variables
            except WorkspaceError as e:
                say(str(e))
        prefixes += [
            Path(path)
            for name in ('AMENT_PREFIX_PATH', 'COLCON_PREFIX_PATH')
            for path in split_path(variables.get(name))
        ]
        for name in missing:
            manifest = _manifest(name, prefixes)
            if manifest is not None:
                found[name] = manifest
    shown = [str(p) for p in dict.fromkeys(prefixes) if p.is_dir()]
    return {'found': found, 'prefixes': shown}


def version_of(manifest: bytes) -> str:
    """Return the version of a manifest, empty if it has none."""
    match = _VERSION.search(manifest)
    return match[1].decode(errors='replace') if match else ''


def _manifest(name: str, prefixes: list[Path]) -> list[str] | None:
    for prefix in prefixes:
        for marker in _MARKERS:
            path = prefix / marker.format(name)
            if not path.is_file():
                continue
            with suppress(OSError):
                content = content_of(prefix / _MARKERS[0].format(name))
                return [digest(content), version_of(content)]
            return ['', '']
    return None
