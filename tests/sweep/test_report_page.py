# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The page about a sweep: complete, escaped, and in need of nothing else."""

from collections.abc import Callable
from html.parser import HTMLParser
from itertools import pairwise
import re

from colcon_yamllaunch.sweep.report_page import (
    histogram,
    number_text,
    Point,
    report_page,
    scatter,
)
from colcon_yamllaunch.sweep.results import RunResult, SweepDefinition
from colcon_yamllaunch.sweep.table import run_table, RunTable
from hypothesis import given
from hypothesis import strategies as st
import pytest

#: Elements that have no end (HTML, "Void elements").
VOID = frozenset(('meta', 'br', 'img', 'link', 'input'))
NASTY = '</title><script>alert("1 & 2")</script>\'\x1b[31m\n\u202e'


class Reader(HTMLParser):
    """Finds out what a page consists of, and that it is well-formed."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: set[str] = set()
        self.links: list[str] = []
        self.text = ''

    def handle_starttag(
        self, tag: str, attrs: list[tuple[str, str | None]]
    ) -> None:
        self.tags.add(tag)
        names = dict(attrs)
        assert not [name for name in names if name.startswith('on')]
        assert 'src' not in names
        self.links += [names['href'] or ''] if 'href' in names else []
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        # a table row may be left open by none of ours
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


def read(page: str) -> Reader:
    reader = Reader()
    reader.feed(page)
    reader.close()
    assert not reader.open
    return reader


def page_of(
    table: RunTable, results: dict[int, RunResult], *metrics: str
) -> str:
    words = ('my_pkg', 'sim.yaml')
    given = {}, dict.fromkeys(metrics, '')
    definition = SweepDefinition('colcon sweep', words, table, *given)

    def log_of(number: int) -> str:
        return f'runs/{number:04}/launch.log'

    return report_page(definition, results, log_of, 0.0)


def test_page_has_shares_plots_failures_and_logs() -> None:
    table = run_table({'seed': '1..30', 'world': 'lab,street'})
    results = {}
    for run in table.runs:
        has_failed = run.arguments['world'] == 'street'
        outcome = 'failed' if has_failed else 'succeeded'
        metrics = {'time': f'{run.number}.5', 'words': 'none'}
        results[run.number] = RunResult(
            run.number, outcome, 'it fell', 1.5, metrics
        )
    reader = read(page_of(table, results, 'time', 'words'))
    assert '30 of 30' in reader.text
    assert '0 of 30' in reader.text
    assert 'runs/0002/launch.log' in reader.links
    assert 'it fell' in reader.text
    assert 'In no run a number was found for: words' in reader.text
    assert 'Distribution of time' in page_of(table, results, 'time')
    assert 'time by seed' in page_of(table, results, 'time')
    assert 'svg' in reader.tags
    assert not reader.tags & {'script', 'img', 'link', 'iframe'}


def test_repeats_have_mean_and_spread() -> None:
    table = run_table({'gain': '1,2'}, repeats=3)
    results = {
        n: RunResult(n, 'succeeded', '', 2.0, {'far': f'{n}', 'once': '7'})
        for n in range(1, 7)
    }
    del results[6].metrics['once']  # type: ignore[attr-defined]
    page = page_of(table, results, 'far', 'once', 'never')
    text = read(page).text
    assert 'Mean and standard deviation of repeats' in text
    row = '23100%5 ± 17 ± 02 ± 0'
    assert row in text
    assert 'standard deviation 1.871' in text
    # and in the plot, for each value
    assert page.count('class="mean"') == 6
    assert '<title>mean 2 ± 1</title>' in page
    once = run_table({'gain': '1,2'})
    page = page_of(once, {1: results[1], 2: results[2]}, 'far')
    assert 'of repeats' not in page
    assert 'class="mean"' not in page


@pytest.mark.parametrize(
    'xs',
    [
        [1234567.0, 1234577.0],
        [-1.25e-7, 3.5e-7],
        [0.0, 99_999_999.0],
        [1.0, 2.0],
    ],
)
def test_axis_labels_do_not_overlap(xs: list[float]) -> None:
    points = [Point(x, x, True, '') for x in xs]
    for plot in (histogram(xs, 'a'), scatter(points, 'a', 'b')):
        texts = re.findall(
            r'<text x="([\d.]+)" y="([\d.]+)" text-anchor="(\w+)">([^<]*)<',
            plot,
        )
        for x, _, anchor, text in texts:
            if anchor == 'end':
                # right of the title, which is upright and 11 pixels high
                assert float(x) - 6 * len(text) > 14
        *across, title = [t for t in texts if t[2] == 'middle']
        assert title[3] == 'a'
        assert float(title[1]) - 11 > max(float(y) for _, y, _, _ in across)
        boxes = [(float(x), 3 * len(text)) for x, _, _, text in across]
        for (x, half), (other, other_half) in pairwise(boxes):
            assert x + half < other - other_half


def test_shortened_names_of_values_differ() -> None:
    names = [f'a_long_name_of_{end}' for end in ('one', 'two', 'three', 'x')]
    points = [Point(n, n, True, '') for n in range(len(names))]
    plot = scatter(points, 'a', 'b', names)
    found = re.findall(r'y="([\d.]+)" text-anchor="middle">(a_[^<]*)<', plot)
    assert len({text for _, text in found}) == len(names)
    # beside one another in two lines
    assert len({y for y, _ in found}) == 2


def test_mixed_versions_of_the_code_are_shown() -> None:
    table = run_table({'seed': '1..3'})
    results = {
        n: RunResult(n, 'succeeded', commit='abc', fingerprint=f'f{n == 3}')
        for n in (1, 2, 3)
    }
    text = read(page_of(table, results)).text
    assert 'These results are of 2 versions of the code' in text
    assert 'abc, fTrue' in text
    assert 'fingerprint' in text.split('All runs')[1]
    text = read(page_of(table, {1: results[1]})).text
    assert 'versions' not in text
    assert 'Code (commit, fingerprint): abc, fFalse' in text


def test_a_page_loads_nothing() -> None:
    page = page_of(run_table({'a': '1..3'}), {1: RunResult(1, 'succeeded')})
    assert 'http:' not in page
    assert 'https:' not in page
    assert "default-src 'none'" in page
    assert 'url(' not in page
    for part in ('prefers-color-scheme: dark', '@media print', 'viewport'):
        assert part in page


def test_all_texts_of_the_page_are_escaped() -> None:
    table = run_table({'a': f'{NASTY},b'})
    results = {
        1: RunResult(1, 'failed', NASTY, 1.0, {'<b>': '3'}),
        2: RunResult(2, 'succeeded', '', 1.0, {'<b>': '4'}),
    }
    definition = SweepDefinition(NASTY, (NASTY,), table, {}, {'<b>': ''})
    page = report_page(definition, results, lambda _: NASTY, 0.0)
    reader = read(page)
    assert 'script' not in reader.tags
    assert 'b' not in reader.tags
    assert '\x1b' not in page
    assert '\u202e' not in page


def test_page_before_the_first_result() -> None:
    reader = read(page_of(run_table({'a': '1..3'}), {}, 'm'))
    assert 'done so far' in reader.text
    assert 'svg' not in reader.tags


numbers = st.floats(-1e99, 1e99, allow_nan=False)


@given(st.lists(numbers, min_size=1, max_size=40))
def test_any_numbers_can_be_plotted(values: list[float]) -> None:
    points = [Point(v, -v, v > 0, 'x') for v in values]
    for plot in (histogram(values, 'a'), scatter(points, 'a', 'b')):
        read(plot)
        assert 'nan' not in plot.replace('meaning', '')
        assert 'inf"' not in plot


def test_numbers_are_rounded_for_people() -> None:
    shown = [number_text(v) for v in (0.1 + 0.2, 1234.5, 5e-07, 20.0, -3.0)]
    assert shown == ['0.3', '1,234', '5e-07', '20', '-3']


def results_of(
    table: RunTable, succeeds: Callable[[int], object]
) -> dict[int, RunResult]:
    outcomes = {True: 'succeeded', False: 'failed'}
    numbers = [run.number for run in table.runs]
    return {n: RunResult(n, outcomes[bool(succeeds(n))]) for n in numbers}


def test_many_values_are_binned_or_the_worst_remain() -> None:
    table = run_table({'seed': '1..1000'})
    results = results_of(table, lambda number: number % 2)
    text = read(page_of(table, results)).text.replace('\n', '')
    assert '1 to 10050%50 of 100101 to 200' in text
    assert text.count('50 of 100') == 10
    words = run_table({'w': ','.join(f'w{n}' for n in range(30))})
    results = results_of(words, lambda number: number != 30)
    text = read(page_of(words, results)).text.replace('\n', '')
    assert 'Success by argumentww290%0 of 1' in text
    assert '10 values with which more runs succeed are left out' in text
