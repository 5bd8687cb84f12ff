# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Plots as SVG, with the colours of the page around them."""

from collections.abc import Iterator
from collections.abc import Sequence
from html import escape
import math
import statistics

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.table import without_end
from colcon_yamllaunch.common.table import without_middle

#: Pixels; a plot grows and shrinks with the page.
_WIDTH, _HEIGHT = 320, 206
_LEFT, _RIGHT, _TOP, _BOTTOM = 48, 310, 8, 162
#: Pixels that a character of a label takes, about.
_CHARACTER = 6.2
#: Pixels between points and the axes, and between points and their mean.
_MARGIN = 6
_ASIDE = 9
#: Marks of an axis, about.
_TICKS = 5
#: Points that a plot has at most, so that a browser draws it at once.
MAXIMUM_POINTS = 2000
_MAXIMUM_BINS = 24
#: The smallest extent of an axis that can be divided.
_LEAST = 1e-300


@dataclass(frozen=True, slots=True)
class Point:
    """
    A point of a scatter plot.

    :param good: Whether its run succeeded
    :param title: The text that is shown when the mouse is over it
    """

    x: float
    y: float
    good: bool
    title: str


class _Scale:
    """
    An axis: the pixel of each value.

    :param start: The pixel of the lowest value
    """

    def __init__(
        self, values: Sequence[float], start: float, end: float
    ) -> None:
        low, high = min(values), max(values)
        if high - low < _LEAST:
            # a single value is in the middle
            margin = max(abs(low) / 2, _LEAST)
            low, high = low - margin, high + margin
        self.low, self.high = low, high
        self._start, self._end = start, end

    def at(self, value: float) -> float:
        """Return the pixel of a value."""
        part = (value - self.low) / (self.high - self.low)
        return self._start + part * (self._end - self._start)

    def ticks(self) -> list[float]:
        """Return the numbers that are written at the axis."""
        return ticks(self.low, self.high)


def ticks(low: float, high: float) -> list[float]:
    """Return about five round numbers between two others."""
    rough = (high - low) / _TICKS
    if not _LEAST < rough < math.inf:
        return [low]
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(
        (m * power for m in (1, 2, 5) if m * power >= rough), 10 * power
    )
    first = math.ceil(low / step - 1e-9)
    last = math.floor(high / step + 1e-9)
    if last - first > 4 * _TICKS:
        return [low]
    # by multiplication, as sums of steps do not stay round
    return [number * step for number in range(first, last + 1)]


def number_text(value: float) -> str:
    """Return a number as people write it."""
    text = f'{value:.4g}'
    return text if 'e' in text else f'{float(text):,.10g}'


def histogram(values: Sequence[float], label: str) -> str:
    """
    Return the distribution of `values`.

    :param values: At least one
    :param label: Their name
    """
    low, high = min(values), max(values)
    count = min(_MAXIMUM_BINS, max(1, math.ceil(2 * len(values) ** (1 / 3))))
    if high - low < _LEAST:
        count = 1
    heights = [0] * count
    for value in values:
        part = (value - low) / ((high - low) or 1)
        heights[min(count - 1, int(part * count))] += 1
    up = _Scale((0, max(heights)), _BOTTOM, _TOP)
    begin = _begin(up)
    across = _Scale((low, high), begin, _RIGHT)
    width = (across.high - across.low) / count
    bars = []
    for number, height in enumerate(heights):
        if height:
            edges = [across.low + width * (number + n) for n in (0, 1)]
            left, right = map(across.at, edges)
            title = f'{" to ".join(map(number_text, edges))}: {height}'
            bars.append(
                f'<rect class="good" x="{left + 0.5:.1f}" '
                f'y="{up.at(height):.1f}" '
                f'width="{max(0.5, right - left - 1):.1f}" '
                f'height="{up.at(0) - up.at(height):.1f}">'
                f'<title>{escape(title)}</title></rect>'
            )
    return _svg(
        f'Distribution of {label}',
        *_x_axis(across, begin, label),
        *_y_axis(up, begin, 'runs', only_whole=True),
        *bars,
    )


def scatter(
    points: Sequence[Point],
    x_label: str,
    y_label: str,
    names: Sequence[str] = (),
    *,
    has_means: bool = False,
) -> str:
    """
    Return a scatter plot.

    :param points: At least one
    :param names: The names for 0, 1, … if x is no number
    :param has_means: Whether mean and standard deviation of the points with
      the same x are marked
    """
    groups: dict[float, list[float]] = {}
    for point in points if has_means else ():
        groups.setdefault(point.x, []).append(point.y)
    means = {x: mean_and_deviation(ys) for x, ys in groups.items()}
    ends = [mean + s * d for mean, d in means.values() for s in (-1, 1)]
    up = _Scale(
        [*(p.y for p in points), *ends], _BOTTOM - _MARGIN, _TOP + _MARGIN
    )
    begin = _begin(up)
    across = _Scale(
        (-0.5, len(names) - 0.5) if names else [p.x for p in points],
        begin + _MARGIN,
        _RIGHT - _MARGIN - (_ASIDE if has_means else 0),
    )
    step = max(1, math.ceil(len(points) / MAXIMUM_POINTS))
    # failed runs are drawn last, so that they are seen
    drawn = sorted(points[::step], key=lambda p: not p.good)
    return _svg(
        f'{y_label} by {x_label}',
        *_x_axis(across, begin, x_label, names),
        *_y_axis(up, begin, y_label),
        *(_mark(p, across.at(p.x), up.at(p.y)) for p in reversed(drawn)),
        *(
            _mean_mark(mean, deviation, across.at(x) + _ASIDE, up)
            for x, (mean, deviation) in means.items()
        ),
    )


def mean_and_deviation(values: Sequence[float]) -> tuple[float, float]:
    """
    Return the mean and the standard deviation of a sample.

    :param values: At least one; the deviation of one alone is 0
    """
    mean = statistics.fmean(values)
    return mean, statistics.stdev(values) if len(values) > 1 else 0.0


def spread_text(mean: float, deviation: float) -> str:
    """Return a mean with its standard deviation, as people write them."""
    return f'{number_text(mean)} ± {number_text(float(f"{deviation:.2g}"))}'


def _mean_mark(mean: float, deviation: float, x: float, up: _Scale) -> str:
    low, high = up.at(mean - deviation), up.at(mean + deviation)
    title = f'mean {spread_text(mean, deviation)}'
    return (
        f'<path class="mean" d="M{x:.1f} {low:.1f}V{high:.1f}'
        f'M{x - 3:.1f} {up.at(mean):.1f}h6"><title>{title}</title></path>'
    )


def _mark(point: Point, x: float, y: float) -> str:
    title = f'<title>{escape(point.title)}</title>'
    if point.good:
        return (
            f'<circle class="good" cx="{x:.1f}" cy="{y:.1f}" r="2.6" '
            f'fill-opacity="0.75">{title}</circle>'
        )
    # not by its colour alone
    return (
        f'<path class="bad" d="M{x - 3:.1f} {y - 3:.1f}l6 6m0 -6l-6 6">'
        f'{title}</path>'
    )


def _begin(up: _Scale) -> float:
    """Return the left end of the x axis, right of the numbers of `up`."""
    longest = max(len(number_text(value)) for value in up.ticks())
    return max(_LEFT, 22 + _CHARACTER * longest)


def _x_axis(
    scale: _Scale, begin: float, label: str, names: Sequence[str] = ()
) -> Iterator[str]:
    width = _RIGHT - begin
    yield _line(begin, f'{_BOTTOM}')
    if names:
        # in two lines, so that each has twice the room
        room = max(3, int(2 * width / len(names) / _CHARACTER) - 2)
        marks = [
            (float(n), without_middle(name, room))
            for n, name in enumerate(names)
        ]
    else:
        marks = [(value, number_text(value)) for value in scale.ticks()]
        longest = max(len(text) + 1 for _, text in marks)
        needed = len(marks) * (longest + 1) * _CHARACTER
        marks = marks[:: math.ceil(needed / width)]
    is_crowded = sum(len(text) + 2 for _, text in marks) * _CHARACTER > width
    for number, (value, text) in enumerate(marks):
        y = _BOTTOM + 14 + (12 if is_crowded and number % 2 else 0)
        yield _text(scale.at(value), y, 'middle', text)
    label = without_end(label, int(width / _CHARACTER))
    yield _text(begin + width / 2, _HEIGHT - 5, 'middle', label)


def _y_axis(
    scale: _Scale, begin: float, label: str, *, only_whole: bool = False
) -> Iterator[str]:
    for value in scale.ticks():
        if not only_whole or value == int(value):
            y = scale.at(value)
            yield _line(begin, f'{y:.1f}')
            yield _text(begin - 5, y + 4, 'end', number_text(value))
    middle = (_TOP + _BOTTOM) / 2
    yield (
        f'<text transform="translate(10 {middle}) rotate(-90)" '
        f'text-anchor="middle">{escape(without_end(label, 26))}</text>'
    )


def _line(begin: float, y: str) -> str:
    return f'<path class="axis" d="M{begin:.1f} {y}H{_RIGHT}"></path>'


def _text(x: float, y: float, anchor: str, text: str) -> str:
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">'
        f'{escape(text)}</text>'
    )


def _svg(label: str, *parts: str) -> str:
    return (
        f'<svg viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img" '
        f'aria-label="{escape(label)}">{"".join(parts)}</svg>'
    )
