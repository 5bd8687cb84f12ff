# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""How many runs succeeded with each value of a launch argument."""

from collections.abc import Mapping
from collections.abc import Sequence

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.sweep.plots import number_text
from colcon_yamllaunch.sweep.run_result import number_of
from colcon_yamllaunch.sweep.run_result import RunResult
from colcon_yamllaunch.sweep.run_table import RunTable

#: Values that are shown one by one.
MAXIMUM_VALUES = 20
_BINS = 10


@dataclass(frozen=True, slots=True)
class Share:
    """
    The runs with a value, or with numbers of a range.

    :param value: The value, or the range
    :param total: How many of them are done
    """

    value: str
    succeeded: int
    total: int

    @property
    def part(self) -> float:
        """The share of those that succeeded, from 0 to 1."""
        return self.succeeded / self.total


@dataclass(frozen=True, slots=True)
class Shares:
    """
    What is shown of an argument.

    :param left_out: How many values are not, as they are too many: those with
      which most runs succeed
    """

    name: str
    shares: tuple[Share, ...]
    left_out: int = 0


def shares_of(
    name: str, table: RunTable, results: Mapping[int, RunResult]
) -> Shares:
    """Return the shares for an argument."""
    counts: dict[str, list[int]] = {}
    for run in table.runs:
        result = results.get(run.number)
        if result is not None:
            count = counts.setdefault(run.arguments[name], [0, 0])
            count[0] += result.succeeded
            count[1] += 1
    if len(counts) <= MAXIMUM_VALUES:
        found = tuple(Share(v, *count) for v, count in counts.items())
        return Shares(name, found)
    numbers = [number_of(value) for value in counts]
    values = [number for number in numbers if number is not None]
    if len(values) == len(counts):
        return Shares(name, _binned(values, list(counts.values())))
    found = tuple(Share(value, *count) for value, count in counts.items())
    worst = sorted(found, key=lambda share: share.part)[:MAXIMUM_VALUES]
    return Shares(name, tuple(worst), len(found) - len(worst))


def _binned(
    values: Sequence[float], counts: Sequence[Sequence[int]]
) -> tuple[Share, ...]:
    """Return the shares for ranges of numbers."""
    order = sorted(zip(values, counts, strict=True), key=lambda one: one[0])
    # as many values in each, as they may be anywhere
    size = -(-len(order) // _BINS)
    shares = []
    for start in range(0, len(order), size):
        part = order[start : start + size]
        shares.append(
            Share(
                f'{number_text(part[0][0])} to {number_text(part[-1][0])}',
                sum(count[0] for _, count in part),
                sum(count[1] for _, count in part),
            )
        )
    return tuple(shares)
