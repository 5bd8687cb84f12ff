# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Plots as SVG, which takes its colours from the page around it."""

from collections.abc import Iterator
from collections.abc import Sequence
from html import escape
import math

from colcon_yamllaunch.common.frozen import dataclass

#: Pixels; a plot grows and shrinks with the page.
_WIDTH, _HEIGHT = 360, 210
_LEFT, _RIGHT, _TOP, _BOTTOM = 48, 10, 8, 34
#: Marks of an axis, about.
_TICKS = 5
#: Points that a plot has at most, so that a browser draws it at once.
MAXIMUM_POINTS = 2000
_MAXIMUM_BINS = 24
#: What an axis extends over at least; less cannot be divided.
_LEAST = 1e-300


@dataclass(frozen=True, slots=True)
class Point:
    """
    A point of a scatter plot.

    :param good: Whether its run succeeded
    :param title: What is shown when it is pointed at
    """

    x: float
    y: float
    good: bool
    title: str


class _Scale:
    """
    Where values are on an axis.

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


def ticks(low: float, high: float) -> list[float]:
    """Return round numbers between two others, some five."""
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
    Return a distribution.

    :param values: At least one
    :param label: What they are
    """
    low, high = min(values), max(values)
    count = min(_MAXIMUM_BINS, max(1, math.ceil(2 * len(values) ** (1 / 3))))
    if high - low < _LEAST:
        count = 1
    heights = [0] * count
    for value in values:
        part = (value - low) / ((high - low) or 1)
        heights[min(count - 1, int(part * count))] += 1
    across = _Scale((low, high), _LEFT, _WIDTH - _RIGHT)
    up = _Scale((0, max(heights)), _HEIGHT - _BOTTOM, _TOP)
    edges = [
        across.low + (across.high - across.low) / count * number
        for number in range(count + 1)
    ]
    bars = []
    for number, height in enumerate(heights):
        if not height:
            continue
        left, right = across.at(edges[number]), across.at(edges[number + 1])
        top, bottom = up.at(height), up.at(0)
        title = (
            f'{number_text(edges[number])} to '
            f'{number_text(edges[number + 1])}: {height}'
        )
        bars.append(
            f'<rect class="good" x="{left + 0.5:.1f}" y="{top:.1f}" '
            f'width="{max(0.5, right - left - 1):.1f}" '
            f'height="{bottom - top:.1f}"><title>{escape(title)}</title>'
            '</rect>'
        )
    parts = (
        *_across(across, label),
        *_upwards(up, 'runs', only_whole=True),
        *bars,
    )
    return _svg(parts, f'Distribution of {label}')


def scatter(
    points: Sequence[Point],
    x_label: str,
    y_label: str,
    names: Sequence[str] = (),
) -> str:
    """
    Return a scatter plot.

    :param points: At least one
    :param names: What the whole numbers of x stand for, if it is no number
    """
    across = _Scale([p.x for p in points], _LEFT + 6, _WIDTH - _RIGHT - 6)
    if names:
        across = _Scale(
            (-0.5, len(names) - 0.5), _LEFT + 6, _WIDTH - _RIGHT - 6
        )
    up = _Scale([p.y for p in points], _HEIGHT - _BOTTOM - 6, _TOP + 6)
    step = max(1, math.ceil(len(points) / MAXIMUM_POINTS))
    # those that failed are drawn last, so that they are seen
    drawn = sorted(points[::step], key=lambda p: not p.good)
    marks = [_mark(p, across.at(p.x), up.at(p.y)) for p in reversed(drawn)]
    parts = (
        *_across(across, x_label, names),
        *_upwards(up, y_label),
        *marks,
    )
    return _svg(parts, f'{y_label} by {x_label}')


def share_bar(part: float) -> str:
    """Return a bar that shows a share, from 0 to 1."""
    good = 100 * part
    return (
        '<svg viewBox="0 0 100 10" preserveAspectRatio="none" height="12" '
        'style="height:0.8rem" role="img" '
        f'aria-label="{good:.4g}%">'
        f'<rect class="good" width="{good:.2f}" height="10"></rect>'
        f'<rect class="bad" x="{good:.2f}" width="{100 - good:.2f}" '
        'height="10"></rect></svg>'
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


def _across(
    scale: _Scale, label: str, names: Sequence[str] = ()
) -> Iterator[str]:
    bottom = _HEIGHT - _BOTTOM
    yield (
        f'<path class="axis" d="M{_LEFT} {bottom}H{_WIDTH - _RIGHT}"></path>'
    )
    marks = [(value, number_text(value)) for value in _round(scale)]
    if names:
        room = max(3, 52 // len(names))
        marks = [(n, _shortened(name, room)) for n, name in enumerate(names)]
    for value, text in marks:
        x = scale.at(value)
        yield (
            f'<text x="{x:.1f}" y="{bottom + 14}" text-anchor="middle">'
            f'{escape(text)}</text>'
        )
    yield (
        f'<text x="{(_LEFT + _WIDTH - _RIGHT) / 2}" y="{_HEIGHT - 5}" '
        f'text-anchor="middle">{escape(_shortened(label, 50))}</text>'
    )


def _upwards(
    scale: _Scale, label: str, *, only_whole: bool = False
) -> Iterator[str]:
    for value in _round(scale):
        if only_whole and value != int(value):
            continue
        y = scale.at(value)
        yield (
            f'<path class="axis" d="M{_LEFT} {y:.1f}H{_WIDTH - _RIGHT}">'
            '</path>'
        )
        yield (
            f'<text x="{_LEFT - 5}" y="{y + 4:.1f}" text-anchor="end">'
            f'{escape(number_text(value))}</text>'
        )
    middle = (_TOP + _HEIGHT - _BOTTOM) / 2
    yield (
        f'<text transform="translate(10 {middle}) rotate(-90)" '
        f'text-anchor="middle">{escape(_shortened(label, 28))}</text>'
    )


def _round(scale: _Scale) -> list[float]:
    return ticks(scale.low, scale.high)


def _svg(parts: Sequence[str], label: str) -> str:
    return (
        f'<svg viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img" '
        f'aria-label="{escape(label)}">{"".join(parts)}</svg>'
    )


def _shortened(text: str, room: int) -> str:
    return text if len(text) <= room else f'{text[: room - 1]}…'
