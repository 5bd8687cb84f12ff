# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The content of packages and files on the machine, for `--watch`."""

from collections.abc import Callable
from collections.abc import Iterator
from collections.abc import Mapping
from contextlib import suppress
import os
from pathlib import Path
from typing import Any

from colcon_yamllaunch.common.fingerprint import content_digest
from colcon_yamllaunch.common.fingerprint import Fingerprint
from colcon_yamllaunch.common.fingerprint import fingerprint
from colcon_yamllaunch.workspace.freshness.build_record import (
    DamagedRecordError,
)
from colcon_yamllaunch.workspace.freshness.build_record import read_record
from colcon_yamllaunch.workspace.freshness.build_record import Record
from colcon_yamllaunch.workspace.freshness.build_record import RECORD_NAME
from colcon_yamllaunch.workspace.freshness.source_links import tree

#: What has the files of a merged install space that may be of any package.
ANY_PACKAGE = '*'
_LINK = 'link to '


def read(
    arguments: Mapping[str, Any], _say: Callable[[str], None]
) -> dict[str, Any]:
    """
    Return the contents of packages and files.

    Of each package in `packages` there are `installed` and `products`: the
    paths, relative to the install space and to its folder below `build/`, with
    what tells their content, also behind links. Packages in a merged install
    space that no record tells apart are `ANY_PACKAGE`. Of each file in `files`
    there is what tells its content, empty if there is none.

    :param arguments: `build_base` and `install_base`, `merge_install`,
      `packages`, their names, and `files`; paths may begin with `~/`
    """
    told: dict[str, Any] = {}
    for name in arguments['packages']:
        install_base, build = (
            Path(os.path.expanduser(arguments[base]))
            for base in ('install_base', 'build_base')
        )
        build /= name
        record = _record(build)
        if record is not None:
            installed, built = record.installed, record.products
        else:
            # it was brought as it is, or somebody else built it
            merged = arguments['merge_install']
            paths = tree(install_base if merged else install_base / name)
            name = ANY_PACKAGE if merged else name
            unknown = Fingerprint(0, 0, executable=False)
            installed = {
                os.path.relpath(p, install_base): unknown for p in paths
            }
            built = {}
        told[name] = {
            'installed': dict(_contents(install_base, installed)),
            'products': dict(_contents(build, built)),
        }
    return {
        'packages': told,
        'files': {
            path: _content(os.path.expanduser(path))
            for path in arguments['files']
        },
    }


def _record(build: Path) -> Record | None:
    with suppress(DamagedRecordError):
        return read_record(build / RECORD_NAME)
    return None


def _contents(
    base: Path, files: Mapping[str, Fingerprint]
) -> Iterator[tuple[str, str]]:
    for path, found in files.items():
        if found.digest and not found.digest.startswith(_LINK):
            yield path, f'{found.digest} {found.executable:d}'
            continue
        # what is behind it may change without a build
        yield path, _content(f'{base}/{path}')
        for below in tree(base / path):
            inner = os.path.relpath(below, base)
            yield inner, _content(f'{base}/{inner}')


def _content(path: str) -> str:
    """Return what tells the content of a file; empty if there is none."""
    now = fingerprint(path)
    if now is None or not os.path.isfile(path):
        return ''
    # large files and those of others are told by their times
    content = content_digest(Path(path), now.size) or f'{now.size} {now.mtime}'
    return f'{content} {now.executable:d}'
