# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Changes of files, as data."""

from typing import Literal
from typing import NamedTuple

#: What happened to a file; `mode` means that it became executable or is not
#: any more, and `again` that it was rewritten with its former content.
Kind = Literal['new', 'changed', 'deleted', 'mode', 'again']


class Change(NamedTuple):
    """
    A changed file.

    A file that is watched under several names has a change for each of them,
    all in one batch.

    :param path: The name under which it is watched: below the folder of a
      package, or as the plan names it
    :param real: Its path behind all symbolic links
    """

    kind: Kind
    path: str
    real: str


class Batch(NamedTuple):
    """
    Changes that are handled together, such as those of a checkout.

    :param seen_ns: When the first of them was noticed, by the monotonic clock
      (nanoseconds)
    """

    changes: tuple[Change, ...]
    seen_ns: int
