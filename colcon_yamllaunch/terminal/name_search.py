# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Who is meant by a part of a name, while it is typed."""

from collections.abc import Iterable
from collections.abc import Mapping


def matching(text: str, names: Mapping[str, Iterable[str]]) -> list[str]:
    """
    Return the labels that a text means, the best first.

    Who is called so comes before those whose names begin so, and these before
    those whose names have it. Those alike stay in the order of the plan.

    :param text: A part of a name, in upper or lower case
    :param names: The names of each, by label, in the order of the plan
    """
    wanted = text.lower()
    ranks: list[tuple[int, str]] = []
    for label, called in names.items():
        lower = [name.lower() for name in called]
        if wanted in lower:
            ranks.append((0, label))
        elif any(name.startswith(wanted) for name in lower):
            ranks.append((1, label))
        elif any(wanted in name for name in lower):
            ranks.append((2, label))
    ranks.sort(key=lambda rank: rank[0])
    return [label for _, label in ranks]
