# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the file system told: changes of files, as plain data."""

from collections.abc import Sequence
from typing import Literal
from typing import NamedTuple

#: What happened to a file; `mode` is that it can be run now, or no more, and
#: `again` that it was written or moved and is as it was.
Kind = Literal['new', 'changed', 'deleted', 'mode', 'again']


class Change(NamedTuple):
    """
    A file that is not as it was.

    One that is reached under several names that are watched makes a change
    for each, all in one batch.

    :param path: The name under which it is watched: below the folder of a
      package, or as the plan has it
    :param real: The file behind all symbolic links
    """

    kind: Kind
    path: str
    real: str


class Batch(NamedTuple):
    """
    Changes that count as one, such as those of a checkout.

    :param seen_ns: When the first of them was noticed, by the clock that
      never goes back (nanoseconds)
    :param notes: What the user should know about the watching itself
    """

    changes: tuple[Change, ...]
    seen_ns: int
    notes: tuple[str, ...] = ()


def merged(batches: Sequence[Batch]) -> Batch:
    """
    Return all changes of some batches as one.

    What follows from any of them follows from that, too.

    :param batches: At least one
    """
    changes = (change for batch in batches for change in batch.changes)
    notes = (note for batch in batches for note in batch.notes)
    return Batch(
        tuple(dict.fromkeys(changes)),
        batches[0].seen_ns,
        tuple(dict.fromkeys(notes)),
    )
