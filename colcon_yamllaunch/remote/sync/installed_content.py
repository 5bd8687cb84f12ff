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

#: Stands for the packages of a merged install space that nothing tells apart.
ANY_PACKAGE = '*'
_LINK = 'link to '


def read(
    arguments: Mapping[str, Any], _say: Callable[[str], None]
) -> dict[str, Any]:
    """
    Return texts that change with the contents of packages and files.

    Each package in `packages` has `installed` and `products`: the texts by
    paths relative to the install space and to its folder below `build/`, also
    of files behind links. The packages of a merged install space without
    records of their builds are one, `ANY_PACKAGE`. Each file in `files` has
    its text, empty if there is no file.

    :param arguments: `packages`, their names; if there are any, `build_base`,
      `install_base` and `merge_install`; and `files`; paths may begin with
      `~/`
    """
    packages: dict[str, Any] = {}
    for name in arguments['packages']:
        install_base, build_base = (
            Path(os.path.expanduser(arguments[base]))
            for base in ('install_base', 'build_base')
        )
        merged = arguments['merge_install']
        record = _record(build_base / name)
        if record is not None:
            installed, built = record.installed, record.products
        else:
            # it was sent after it was built, or somebody else built it
            paths = tree(install_base if merged else install_base / name)
            unknown = Fingerprint(0, 0, executable=False)
            installed = {
                os.path.relpath(p, install_base): unknown for p in paths
            }
            built = {}
        shown = ANY_PACKAGE if merged and record is None else name
        packages[shown] = {
            'installed': dict(_contents(install_base, installed)),
            'products': dict(_contents(build_base / name, built)),
        }
    return {
        'packages': packages,
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
        # the target of a link may change without a build
        yield path, _content(f'{base}/{path}')
        for below in tree(base / path):
            inner = os.path.relpath(below, base)
            yield inner, _content(f'{base}/{inner}')


def _content(path: str) -> str:
    """Return a text that changes with a file; empty if there is none."""
    now = fingerprint(path)
    if now is None or not os.path.isfile(path):
        return ''
    # large files, and those that cannot be read, are known by their times
    content = content_digest(Path(path), now.size) or f'{now.size} {now.mtime}'
    return f'{content} {now.executable:d}'
