# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The page about a sweep, for people: one HTML file that needs nothing else.

It loads nothing, runs nothing, and whatever a launch file or a process wrote
is text in it.
"""

from collections.abc import Callable
from collections.abc import Iterable
from collections.abc import Iterator
from collections.abc import Mapping
from html import escape
from itertools import combinations
from itertools import islice
import statistics
import time

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.sweep.plots import histogram
from colcon_yamllaunch.sweep.plots import MAXIMUM_POINTS
from colcon_yamllaunch.sweep.plots import mean_and_deviation
from colcon_yamllaunch.sweep.plots import number_text
from colcon_yamllaunch.sweep.plots import Point
from colcon_yamllaunch.sweep.plots import scatter
from colcon_yamllaunch.sweep.plots import share_bar
from colcon_yamllaunch.sweep.plots import spread_text
from colcon_yamllaunch.sweep.report_style import STYLE
from colcon_yamllaunch.sweep.run_result import number_of
from colcon_yamllaunch.sweep.run_result import RunResult
from colcon_yamllaunch.sweep.run_result import versions_of
from colcon_yamllaunch.sweep.run_table import Run
from colcon_yamllaunch.sweep.run_table import RunTable
from colcon_yamllaunch.sweep.success_shares import Shares
from colcon_yamllaunch.sweep.success_shares import shares_of

#: Rows of the tables with runs; results.csv has all.
_MAXIMUM_ROWS = 1000
#: Values of an argument that is no number that a plot has place for.
_MAXIMUM_NAMES = 12
#: Pairs of metrics that are plotted.
_MAXIMUM_PAIRS = 10
#: What the time of a run is called among the metrics.
_TIME = 'time of a run (s)'

# nothing is to be fetched or run, whatever gets into the page
_POLICY = "default-src 'none'; style-src 'unsafe-inline'"


@dataclass(frozen=True, slots=True)
class Page:
    """
    What the page is about.

    :param title: The package and the launch file
    :param command: The command, as it was typed
    :param metrics: The names of the metrics
    :param log_of: Returns the path of the logs of a run, from the page on, or
      None if there are none
    :param made: When, in seconds since the epoch
    """

    title: str
    command: str
    table: RunTable
    results: Mapping[int, RunResult]
    metrics: tuple[str, ...]
    log_of: Callable[[int], str | None]
    made: float

    def done(self) -> Iterator[tuple[Run, RunResult]]:
        """Iterate over the runs that are done."""
        for run in self.table.runs:
            result = self.results.get(run.number)
            if result is not None:
                yield run, result


def report_page(page: Page) -> str:
    """Return the page."""
    return '\n'.join(_page(page)) + '\n'


def _page(page: Page) -> Iterator[str]:
    title = escape(one_line(page.title))
    yield '<!DOCTYPE html>'
    yield '<html lang="en"><head><meta charset="utf-8">'
    yield f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">'
    yield (
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
    )
    yield f'<title>{title} - colcon sweep</title>'
    yield f'<style>{STYLE}</style></head><body>'
    yield f'<h1>{title}</h1>'
    yield f'<pre>{escape(one_line(page.command))}</pre>'
    yield from _numbers(page)
    yield from _versions(page)
    shares = [
        shares_of(name, page.table, page.results) for name in page.table.varied
    ]
    if page.results and shares:
        yield '<h2>Success by argument</h2><div class="cards">'
        for share in shares:
            yield from _shares(share)
        yield '</div>'
    yield from _measures(page)
    yield from _repeats(page)
    yield from _failures(page)
    yield from _all_runs(page)
    made = time.strftime('%Y-%m-%d %H:%M', time.localtime(page.made))
    yield f'<p>Made by colcon sweep, {made}.</p></body></html>'


def _numbers(page: Page) -> Iterator[str]:
    total, done = len(page.table.runs), len(page.results)
    results = page.results.values()
    succeeded = sum(result.succeeded for result in results)
    numbers = [('runs', f'{total:,}')]
    if done < total:
        numbers.append(('done so far', f'{done:,}'))
    if done:
        numbers.append(('succeeded', f'{100 * succeeded / done:.4g}%'))
        numbers.append(('did not succeed', f'{done - succeeded:,}'))
        seconds = statistics.median(result.seconds for result in results)
        numbers.append(('median time', f'{number_text(seconds)} s'))
    yield '<dl>'
    for name, text in numbers:
        yield f'<div><dt>{name}</dt><dd>{text}</dd></div>'
    yield '</dl>'


def _versions(page: Page) -> Iterator[str]:
    """Show which code was run, and warn if that was not the same."""
    versions = versions_of(page.results.values())
    if len(versions) == 1 and 'not recorded' not in versions:
        yield f'<p>Code (commit, fingerprint): {_text(*versions)}</p>'
    if len(versions) < 2:
        return
    yield (
        f'<div class="card warning"><h3>These results are of {len(versions)} '
        'versions of the code</h3><table><tr><th>commit, fingerprint</th>'
        '<th>runs</th><th>succeeded</th></tr>'
    )
    for name, results in versions.items():
        count, good = len(results), sum(r.succeeded for r in results)
        yield (
            f'<tr>{_cell(name)}<td>{count:,}</td>'
            f'<td>{100 * good / count:.3g}%</td></tr>'
        )
    yield '</table><p>To do all runs again: --again all</p></div>'


def _shares(shares: Shares) -> Iterator[str]:
    yield f'<div class="card"><h3>{_text(shares.name)}</h3><table>'
    for share in shares.shares:
        yield (
            f'<tr><td>{_text(share.value) or "(empty)"}</td>'
            f'<td class="share">{share_bar(share.part)}</td>'
            f'<td class="number">{100 * share.part:.3g}%</td>'
            f'<td class="number">{share.succeeded:,} of {share.total:,}</td>'
            '</tr>'
        )
    yield '</table>'
    if shares.left_out:
        yield (
            f'<p>{shares.left_out:,} values with which more runs succeed are '
            'left out; results.csv has them all.</p>'
        )
    yield '</div>'


def _measures(page: Page) -> Iterator[str]:
    """Plot the metrics, and the time, alone and by arguments."""
    done = list(page.done())
    if not done:
        return
    found: dict[str, dict[int, float]] = {
        _TIME: {run.number: result.seconds for run, result in done}
    }
    for name in page.metrics:
        values = {
            run.number: number
            for run, result in done
            if (number := number_of(result.metrics.get(name, ''))) is not None
        }
        if values:
            # what is asked for comes first
            found[name] = values
    names = [*(name for name in found if name != _TIME), _TIME]
    for name in names:
        yield f'<h2>{_text(name)}</h2><div class="cards">'
        numbers = list(found[name].values())
        caption = _statistics(numbers, len(done))
        yield _card(histogram(numbers, name), caption)
        for argument in page.table.varied:
            yield from _by_argument(page, argument, name, found[name])
        yield '</div>'
    pairs = list(combinations([name for name in names if name != _TIME], 2))
    if pairs:
        yield '<h2>Metrics by one another</h2><div class="cards">'
        for one, other in pairs[:_MAXIMUM_PAIRS]:
            points = [
                Point(
                    found[one][run.number],
                    found[other][run.number],
                    result.succeeded,
                    _title(page, run),
                )
                for run, result in done
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
    page: Page, argument: str, name: str, values: Mapping[int, float]
) -> Iterator[str]:
    runs = [run for run in page.table.runs if run.number in values]
    texts = list(dict.fromkeys(run.arguments[argument] for run in runs))
    numbers = {text: number_of(text) for text in texts}
    names: list[str] = []
    places: dict[str, float] = {}
    for index, (text, number) in enumerate(numbers.items()):
        if None in numbers.values():
            names.append(text)
            places[text] = float(index)
        elif number is not None:
            places[text] = number
    if len(names) > _MAXIMUM_NAMES or len(texts) < 2:
        return
    points = [
        Point(
            places[run.arguments[argument]],
            values[run.number],
            page.results[run.number].succeeded,
            _title(page, run),
        )
        for run in runs
    ]
    caption = _sampled(points)
    has_means = len(texts) <= _MAXIMUM_NAMES and len(points) > len(texts)
    if has_means:
        caption += ' With mean and standard deviation for each value.'
    plot = scatter(points, argument, name, names, has_means=has_means)
    yield _card(plot, caption.strip())


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


def _repeats(page: Page) -> Iterator[str]:
    """Show mean and spread of the runs with the same arguments."""
    names = page.table.varied
    groups: dict[tuple[str, ...], list[RunResult]] = {}
    for run, result in page.done():
        key = tuple(run.arguments[name] for name in names)
        groups.setdefault(key, []).append(result)
    if page.table.repeats < 2 or not groups:
        return
    yield '<h2>Mean and standard deviation of repeats</h2>'
    heads = [*names, 'runs', 'succeeded', *page.metrics, _TIME]
    yield '<div class="wide"><table><tr>'
    yield ''.join(f'<th>{_text(head)}</th>' for head in heads)
    yield '</tr>'
    for values, results in islice(groups.items(), _MAXIMUM_ROWS):
        good = sum(result.succeeded for result in results)
        cells = [
            *values,
            f'{len(results):,}',
            f'{100 * good / len(results):.3g}%',
            *(
                _spread([number_of(r.metrics.get(name, '')) for r in results])
                for name in page.metrics
            ),
            _spread([result.seconds for result in results]),
        ]
        yield f'<tr>{"".join(map(_cell, cells))}</tr>'
    yield '</table></div>'


def _spread(found: Iterable[float | None]) -> str:
    values = [value for value in found if value is not None]
    if not values:
        return ''
    return spread_text(*mean_and_deviation(values))


def _failures(page: Page) -> Iterator[str]:
    failed = [(run, r) for run, r in page.done() if not r.succeeded]
    if not failed:
        return
    yield '<h2>Runs that did not succeed</h2>'
    yield from _rows(page, failed, len(failed))


def _all_runs(page: Page) -> Iterator[str]:
    if page.results:
        count = len(page.results)
        yield f'<h2>All runs</h2><details><summary>{count:,} runs</summary>'
        yield from _rows(page, page.done(), count)
        yield '</details>'


def _rows(
    page: Page, runs: Iterable[tuple[Run, RunResult]], count: int
) -> Iterator[str]:
    repeats = ['repeat'] if page.table.repeats > 1 else []
    heads = ['run', *page.table.varied, *repeats, 'outcome', 'seconds']
    heads += [*page.metrics, 'reason']
    is_mixed = len(versions_of(page.results.values())) > 1
    heads += ['commit', 'fingerprint'] * is_mixed
    yield '<div class="wide"><table><tr>'
    yield ''.join(f'<th>{_text(head)}</th>' for head in heads)
    yield '</tr>'
    for run, result in islice(runs, _MAXIMUM_ROWS):
        number = f'{run.number}'
        log = page.log_of(run.number)
        if log is not None:
            number = f'<a href="{_text(log)}">{run.number}</a>'
        kind = '' if result.succeeded else ' class="bad"'
        cells = [
            f'<td class="number">{number}</td>',
            *(_cell(run.arguments[name]) for name in page.table.varied),
            *(_cell(str(run.repeat)) for _ in repeats),
            f'<td{kind}>{result.outcome}</td>',
            f'<td class="number">{result.seconds:.2f}</td>',
            *(_cell(result.metrics.get(name, '')) for name in page.metrics),
            _cell(result.reason),
        ]
        if is_mixed:
            cells += [_cell(result.commit), _cell(result.fingerprint)]
        yield f'<tr>{"".join(cells)}</tr>'
    yield '</table></div>'
    if count > _MAXIMUM_ROWS:
        yield (
            f'<p>These are the first {_MAXIMUM_ROWS:,} of {count:,}; '
            '<a href="results.csv">results.csv</a> has them all.</p>'
        )


def _cell(text: str) -> str:
    return f'<td>{_text(text)}</td>'


def _title(page: Page, run: Run) -> str:
    return f'run {run.number}: {one_line(page.table.title(run))}'


def _text(text: str) -> str:
    return escape(one_line(text))
