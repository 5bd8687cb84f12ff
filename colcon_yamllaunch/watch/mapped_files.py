# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Which files are mapped into a process: its program and its libraries."""

from collections.abc import Mapping
from dataclasses import replace
import os

from colcon_yamllaunch.watch.knowledge import is_edited
from colcon_yamllaunch.watch.knowledge import Knowledge

_DELETED = ' (deleted)'


def mapped_files(pid: int, own: tuple[str, ...] = ()) -> frozenset[str] | None:
    """
    Return the files that are mapped into a process, but for the system's.

    One that was replaced since goes by the name that it had. None is returned
    for a process that is gone, or of somebody else.

    :param pid: The process; what it started counts, too, as one that was
      started with a prefix or in a shell has nothing itself
    :param own: What the paths of the workspace begin with
    """
    found: set[str] = set()
    is_known = False
    pending = [pid]
    while pending:
        current = pending.pop()
        try:
            # fields are separated by spaces, and the path comes last
            with open(f'/proc/{current}/maps', errors='surrogateescape') as f:
                lines = f.readlines()
        except OSError:
            continue
        is_known = is_known or bool(lines)
        for line in lines:
            path = line[line.find('/') :].rstrip('\n') if '/' in line else ''
            path = path.removesuffix(_DELETED)
            if is_edited(path, own):
                found.add(path)
        pending += _children(current)
    return frozenset(found) if is_known else None


def with_libraries(
    knowledge: Knowledge, processes: Mapping[str, int]
) -> Knowledge:
    """
    Return what is known once it was looked what is mapped into processes.

    What was mapped into one that has ended is kept.

    :param processes: Those that run, with their labels
    """
    own = tuple(folder + os.sep for folder in knowledge.products)
    found = []
    for process in knowledge.processes:
        pid = processes.get(process.label)
        mapped = mapped_files(pid, own) if pid else None
        if mapped is not None:
            process = replace(
                process,
                libraries=mapped,
                may_run_python=process.may_run_python
                or any('/libpython' in path for path in mapped),
            )
        found.append(process)
    return replace(knowledge, processes=tuple(found))


def _children(pid: int) -> list[int]:
    found: list[int] = []
    try:
        for thread in os.listdir(f'/proc/{pid}/task'):
            with open(f'/proc/{pid}/task/{thread}/children') as file:
                found += map(int, file.read().split())
    except OSError:
        # some kernels do not tell
        pass
    return found
