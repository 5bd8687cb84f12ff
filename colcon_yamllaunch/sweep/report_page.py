# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The report of a sweep as one HTML file, for people, with its plots.

It loads nothing and runs nothing, and text from launch files and processes is
escaped. The plots are SVG, with the colours of the page around them.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from html import escape
from itertools import combinations, islice
import math
from pathlib import Path
import statistics
import time

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.common.table import without_end, without_middle
from colcon_yamllaunch.sweep.results import (
    number_of,
    RunResult,
    SweepDefinition,
    versions_of,
)
from colcon_yamllaunch.sweep.table import Run, RunTable

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
_STYLE = Path(__file__).with_name('report.css')
#: Rows of the tables with runs; results.csv has all.
_MAXIMUM_ROWS = 1000
#: Values of an argument whose shares are shown one by one, and the number of
#: ranges if there are more and they are numbers.
_MAXIMUM_SHARES = 20
_BINS = 10
#: Values of an argument that is no number that fit below a plot.
_MAXIMUM_NAMES = 12
#: Pairs of metrics that are plotted.
_MAXIMUM_PAIRS = 10
#: The name of the time of a run among the metrics.
_TIME = 'time of a run (s)'
# nothing is loaded or run, whatever gets into the page
_POLICY = "default-src 'none'; style-src 'unsafe-inline'"

#: A value, and how many of its runs succeeded and are done.
_Share = tuple[str, int, int]


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
        """Return about five round numbers, which are written at the axis."""
        rough = (self.high - self.low) / _TICKS
        if not _LEAST < rough < math.inf:
            return [self.low]
        power = 10.0 ** math.floor(math.log10(rough))
        steps = (m * power for m in (1, 2, 5))
        step = next((s for s in steps if s >= rough), 10 * power)
        first = math.ceil(self.low / step - 1e-9)
        last = math.floor(self.high / step + 1e-9)
        if last - first > 4 * _TICKS:
            return [self.low]
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
    begin = _axis_begin(up)
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
    begin = _axis_begin(up)
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


def _axis_begin(up: _Scale) -> float:
    """Return the left end of the x axis, right of the numbers of `up`."""
    longest = max(len(number_text(value)) for value in up.ticks())
    return max(_LEFT, 22 + _CHARACTER * longest)


def _x_axis(
    scale: _Scale, begin: float, label: str, names: Sequence[str] = ()
) -> Iterator[str]:
    width = _RIGHT - begin
    yield _grid_line(begin, f'{_BOTTOM}')
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
        yield _label(scale.at(value), y, 'middle', text)
    label = without_end(label, int(width / _CHARACTER))
    yield _label(begin + width / 2, _HEIGHT - 5, 'middle', label)


def _y_axis(
    scale: _Scale, begin: float, label: str, *, only_whole: bool = False
) -> Iterator[str]:
    for value in scale.ticks():
        if not only_whole or value == int(value):
            y = scale.at(value)
            yield _grid_line(begin, f'{y:.1f}')
            yield _label(begin - 5, y + 4, 'end', number_text(value))
    middle = (_TOP + _BOTTOM) / 2
    yield (
        f'<text transform="translate(10 {middle}) rotate(-90)" '
        f'text-anchor="middle">{escape(without_end(label, 26))}</text>'
    )


def _grid_line(begin: float, y: str) -> str:
    return f'<path class="axis" d="M{begin:.1f} {y}H{_RIGHT}"></path>'


def _label(x: float, y: float, anchor: str, text: str) -> str:
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">'
        f'{escape(text)}</text>'
    )


def _svg(label: str, *parts: str) -> str:
    return (
        f'<svg viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img" '
        f'aria-label="{escape(label)}">{"".join(parts)}</svg>'
    )


@dataclass(frozen=True, slots=True)
class _Page:
    """
    The content of the page; see :func:`report_page`.

    :param done: The runs that are done, with their results
    """

    table: RunTable
    metrics: Sequence[str]
    results: Mapping[int, RunResult]
    log_of: Callable[[int], str | None]
    done: Sequence[tuple[Run, RunResult]]


def report_page(
    definition: SweepDefinition,
    results: Mapping[int, RunResult],
    log_of: Callable[[int], str | None],
    made: float,
) -> str:
    """
    Return the page.

    :param log_of: Returns the path of the log of a run, relative to the page,
      or None if there is none
    :param made: When, in seconds since the epoch
    """
    table = definition.table
    runs = [run for run in table.runs if run.number in results]
    done = [(run, results[run.number]) for run in runs]
    page = _Page(table, tuple(definition.metrics), results, log_of, done)
    return '\n'.join(_parts(page, definition, made)) + '\n'


def _parts(
    page: _Page, definition: SweepDefinition, made: float
) -> Iterator[str]:
    title = escape(one_line(definition.title))
    yield f"""\
<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{_POLICY}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title} - colcon sweep</title>
<style>{_STYLE.read_text(encoding='utf-8')}</style></head><body>
<h1>{title}</h1>
<pre>{escape(one_line(definition.command))}</pre>"""
    yield from _totals(page)
    yield from _versions(page)
    if page.results and page.table.varied:
        yield '<h2>Success by argument</h2><div class="cards">'
        for name in page.table.varied:
            yield from _success(page, name)
        yield '</div>'
    yield from _measures(page)
    yield from _repeats(page)
    if failed := [(run, r) for run, r in page.done if not r.succeeded]:
        yield '<h2>Runs that did not succeed</h2>'
        yield from _runs(page, failed)
    if page.done:
        yield '<h2>All runs</h2><details>'
        yield f'<summary>{len(page.done):,} runs</summary>'
        yield from _runs(page, page.done)
        yield '</details>'
    date = time.strftime('%Y-%m-%d %H:%M', time.localtime(made))
    yield f'<p>Made by colcon sweep, {date}.</p></body></html>'


def _totals(page: _Page) -> Iterator[str]:
    total, done = len(page.table.runs), len(page.results)
    results = page.results.values()
    numbers = {'runs': f'{total:,}'}
    if done < total:
        numbers['done so far'] = f'{done:,}'
    if done:
        succeeded = sum(result.succeeded for result in results)
        seconds = statistics.median(result.seconds for result in results)
        numbers['succeeded'] = f'{100 * succeeded / done:.4g}%'
        numbers['did not succeed'] = f'{done - succeeded:,}'
        numbers['median time'] = f'{number_text(seconds)} s'
    yield '<dl>'
    for name, text in numbers.items():
        yield f'<div><dt>{name}</dt><dd>{text}</dd></div>'
    yield '</dl>'


def _versions(page: _Page) -> Iterator[str]:
    """Show the version of the code, and warn if there are several."""
    versions = versions_of(page.results.values())
    if len(versions) == 1 and 'not recorded' not in versions:
        yield f'<p>Code (commit, fingerprint): {_text(*versions)}</p>'
    if len(versions) < 2:
        return
    yield (
        f'<div class="card warning"><h3>These results are of {len(versions)} '
        'versions of the code</h3>'
    )
    yield from _table(
        ['commit, fingerprint', 'runs', 'succeeded'],
        (
            map(_cell, (name, f'{len(results):,}', _succeeded(results)))
            for name, results in versions.items()
        ),
    )
    yield '<p>To do all runs again: --again all</p></div>'


def _success(page: _Page, name: str) -> Iterator[str]:
    """Show how many runs succeeded with each value of an argument."""
    shares, left_out = _shares(page, name)
    yield f'<div class="card"><h3>{_text(name)}</h3>'
    yield from _table(
        [],
        (
            (
                f'<td>{_text(value) or "(empty)"}</td>',
                '<td class="share"><div>'
                f'<i style="width:{100 * good / total:.2f}%"></i></div></td>',
                _number(f'{100 * (good / total):.3g}%'),
                _number(f'{good:,} of {total:,}'),
            )
            for value, good, total in shares
        ),
    )
    if left_out:
        yield (
            f'<p>{left_out:,} values with which more runs succeed are '
            'left out; results.csv has them all.</p>'
        )
    yield '</div>'


def _shares(page: _Page, name: str) -> tuple[list[_Share], int]:
    """
    Return the shares of an argument, and how many values are left out.

    Many numbers are summed up in ranges; of many other values, the worst
    remain.
    """
    groups: dict[str, list[bool]] = {}
    for run, result in page.done:
        group = groups.setdefault(run.arguments[name], [])
        group.append(result.succeeded)
    shares = [(value, sum(g), len(g)) for value, g in groups.items()]
    if len(shares) <= _MAXIMUM_SHARES:
        return shares, 0
    numbers = [(number_of(share[0]), share) for share in shares]
    order = [(number, s) for number, s in numbers if number is not None]
    if len(order) < len(shares):
        worst = sorted(shares, key=lambda share: share[1] / share[2])
        return worst[:_MAXIMUM_SHARES], len(shares) - _MAXIMUM_SHARES
    # as many values in each, as they may be anywhere
    order.sort(key=lambda one: one[0])
    size = -(-len(order) // _BINS)
    bins = [order[n : n + size] for n in range(0, len(order), size)]
    return [
        (
            f'{number_text(part[0][0])} to {number_text(part[-1][0])}',
            sum(share[1] for _, share in part),
            sum(share[2] for _, share in part),
        )
        for part in bins
    ], 0


def _measures(page: _Page) -> Iterator[str]:
    """Plot the metrics and the time, alone and by arguments."""
    done = page.done
    if not done:
        return
    found: dict[str, dict[int, float]] = {}
    for name in page.metrics:
        values = {
            run.number: number
            for run, result in done
            if (number := number_of(result.metrics.get(name, ''))) is not None
        }
        if values:
            found[name] = values
    pairs = list(combinations(found, 2))[:_MAXIMUM_PAIRS]
    found[_TIME] = {run.number: result.seconds for run, result in done}
    for name, values in found.items():
        yield f'<h2>{_text(name)}</h2><div class="cards">'
        numbers = list(values.values())
        yield _card(histogram(numbers, name), _statistics(numbers, len(done)))
        for argument in page.table.varied:
            yield from _by_argument(page, argument, name, values)
        yield '</div>'
    if pairs:
        yield '<h2>Metrics by one another</h2><div class="cards">'
        for one, other in pairs:
            points = [
                _point(page, run, found[one][run.number], found[other])
                for run, _ in done
                if run.number in found[one] and run.number in found[other]
            ]
            if points:
                yield _card(scatter(points, one, other), _sampled(points))
        yield '</div>'
    missing = [name for name in page.metrics if name not in found]
    if missing:
        listed = ', '.join(map(_text, missing))
        yield f'<p>In no run a number was found for: {listed}.</p>'


def _by_argument(
    page: _Page, argument: str, name: str, values: Mapping[int, float]
) -> Iterator[str]:
    runs = [run for run in page.table.runs if run.number in values]
    texts = list(dict.fromkeys(run.arguments[argument] for run in runs))
    numbers = {text: number_of(text) for text in texts}
    places = {text: n for text, n in numbers.items() if n is not None}
    names: list[str] = []
    if len(places) < len(texts):
        names = texts
        places = {text: float(index) for index, text in enumerate(texts)}
    if len(names) > _MAXIMUM_NAMES or len(texts) < 2:
        return
    points = [
        _point(page, run, places[run.arguments[argument]], values)
        for run in runs
    ]
    caption = _sampled(points)
    has_means = len(texts) <= _MAXIMUM_NAMES and len(points) > len(texts)
    if has_means:
        caption += ' With mean and standard deviation for each value.'
    plot = scatter(points, argument, name, names, has_means=has_means)
    yield _card(plot, caption.strip())


def _point(page: _Page, run: Run, x: float, ys: Mapping[int, float]) -> Point:
    title = f'run {run.number}: {one_line(page.table.title(run))}'
    good = page.results[run.number].succeeded
    return Point(x, ys[run.number], good, title)


def _statistics(values: list[float], done: int) -> str:
    mean, deviation = mean_and_deviation(values)
    parts = [
        f'minimum {number_text(min(values))}',
        f'median {number_text(statistics.median(values))}',
        f'mean {number_text(mean)}',
        f'standard deviation {number_text(deviation)}',
        f'maximum {number_text(max(values))}',
    ]
    if len(values) < done:
        parts.append(f'found in {len(values):,} of {done:,} runs')
    return ' · '.join(parts)


def _sampled(points: list[Point]) -> str:
    if len(points) <= MAXIMUM_POINTS:
        return ''
    return f'A part of the {len(points):,} points, evenly chosen.'


def _card(plot: str, caption: str) -> str:
    shown = f'<figcaption>{escape(caption)}</figcaption>' if caption else ''
    return f'<figure class="card">{plot}{shown}</figure>'


def _repeats(page: _Page) -> Iterator[str]:
    """Show mean and spread of the runs with the same arguments."""
    names = page.table.varied
    groups: dict[tuple[str, ...], list[RunResult]] = {}
    for run, result in page.done:
        key = tuple(run.arguments[name] for name in names)
        groups.setdefault(key, []).append(result)
    if page.table.repeats < 2 or not groups:
        return
    yield '<h2>Mean and standard deviation of repeats</h2>'
    yield '<div class="wide">'
    yield from _table(
        [*names, 'runs', 'succeeded', *page.metrics, _TIME],
        (
            map(
                _cell,
                [
                    *(*values, f'{len(results):,}', _succeeded(results)),
                    *(
                        _spread(
                            number_of(r.metrics.get(name, '')) for r in results
                        )
                        for name in page.metrics
                    ),
                    _spread(result.seconds for result in results),
                ],
            )
            for values, results in islice(groups.items(), _MAXIMUM_ROWS)
        ),
    )
    yield '</div>'


def _spread(found: Iterable[float | None]) -> str:
    values = [value for value in found if value is not None]
    return spread_text(*mean_and_deviation(values)) if values else ''


def _runs(page: _Page, runs: Sequence[tuple[Run, RunResult]]) -> Iterator[str]:
    is_repeated = page.table.repeats > 1
    is_mixed = len(versions_of(page.results.values())) > 1

    def cells(run: Run, result: RunResult) -> Iterator[str]:
        number = f'{run.number}'
        if (log := page.log_of(run.number)) is not None:
            number = f'<a href="{_text(log)}">{number}</a>'
        yield _number(number)
        yield from (_cell(run.arguments[name]) for name in page.table.varied)
        if is_repeated:
            yield _cell(str(run.repeat))
        kind = '' if result.succeeded else ' class="bad"'
        yield f'<td{kind}>{result.outcome}</td>'
        yield _number(f'{result.seconds:.2f}')
        yield from (_cell(result.metrics.get(n, '')) for n in page.metrics)
        yield _cell(result.reason)
        if is_mixed:
            yield from map(_cell, (result.commit, result.fingerprint))

    yield '<div class="wide">'
    yield from _table(
        [
            *('run', *page.table.varied, *['repeat'] * is_repeated),
            *('outcome', 'seconds', *page.metrics, 'reason'),
            *['commit', 'fingerprint'] * is_mixed,
        ],
        (cells(run, result) for run, result in runs[:_MAXIMUM_ROWS]),
    )
    yield '</div>'
    if len(runs) > _MAXIMUM_ROWS:
        yield (
            f'<p>These are the first {_MAXIMUM_ROWS:,} of {len(runs):,}; '
            '<a href="results.csv">results.csv</a> has them all.</p>'
        )


def _table(
    heads: Sequence[str], rows: Iterable[Iterable[str]]
) -> Iterator[str]:
    """Yield a table whose rows have cells in HTML."""
    yield '<table>'
    if heads:
        cells = (f'<th>{_text(head)}</th>' for head in heads)
        yield f'<tr>{"".join(cells)}</tr>'
    for row in rows:
        yield f'<tr>{"".join(row)}</tr>'
    yield '</table>'


def _succeeded(results: Sequence[RunResult]) -> str:
    good = sum(result.succeeded for result in results)
    return f'{100 * good / len(results):.3g}%'


def _cell(text: str) -> str:
    return f'<td>{_text(text)}</td>'


def _number(text: str) -> str:
    return f'<td class="number">{text}</td>'


def _text(text: str) -> str:
    return escape(one_line(text))
