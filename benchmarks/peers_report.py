# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The tables and plots of `benchmarks/peers.py`."""

from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
import os
from pathlib import Path
import platform
import re
import statistics
from typing import TypeAlias
from xml.sax.saxutils import escape, quoteattr

#: What a run measured, by the key of the work.
Measured: TypeAlias = dict[str, float]

OURS = 'colcon launch'
BEGIN = '<!-- begin: written by benchmarks/peers.py -->'
END = '<!-- end: written by benchmarks/peers.py -->'
#: Pixels of a plot.
WIDTH, LABEL, BAR, ROW, TITLE = 700, 130, 400, 20, 34
STYLE = """\
<style>
text { font: 13px system-ui, sans-serif; fill: #57606a; }
.title { font-weight: bold; }
rect { fill: #9aa5b1; }
.ours { fill: #2f6fde; }
</style>
"""


@dataclass(frozen=True)
class Work:
    """
    A row of the table, where less is better.

    :param key: Its key in the measurements
    :param title: Its title
    :param unit: The unit of its figures
    :param plot: The plot that shows it, if any
    """

    key: str
    title: str
    unit: str
    plot: str = ''


WORKS = (
    Work('one', 'start one program', 's', 'times'),
    Work('many', 'start 144 processes', 's', 'times'),
    Work(
        'edit', 'edit a script of 144 processes, until it runs', 's', 'times'
    ),
    Work('stop', 'stop 144 processes with Ctrl-C', 's', 'times'),
    Work('lines', 'write 1,000,000 lines to a file', 's', 'times'),
    Work('lost', 'of these lines, lost', '%'),
    Work('left', 'processes left 12 s after SIGKILL', '', 'costs'),
    Work('memory', 'memory at rest (PSS), 144 processes', 'MiB', 'costs'),
    Work('cpu', 'CPU at rest, 144 processes', '%', 'costs'),
    Work('arguments', "show the arguments of Autoware's simulator", 's'),
    Work('check', "check all of Autoware's launch files", 's'),
)
PLOTS = {
    'times': 'Times of several launchers, in seconds; shorter is better',
    'costs': 'Costs of several launchers; less is better',
}


@dataclass
class Report:
    """
    All measurements.

    :param figures: The figures of all runs, by work and launcher
    :param failures: What a launcher failed to do, by work and launcher
    :param versions: The version of each launcher, or why there is none
    :param machine: What measured, as lines of a table
    """

    figures: dict[str, dict[str, list[float]]] = field(
        default_factory=lambda: defaultdict(lambda: defaultdict(list))
    )
    failures: dict[tuple[str, str], str] = field(default_factory=dict)
    versions: dict[str, str] = field(default_factory=dict)
    machine: dict[str, str] = field(default_factory=dict)

    def add(self, name: str, measured: Measured) -> None:
        """Add what one run of a launcher measured."""
        for key, figure in measured.items():
            self.figures[key][name].append(figure)

    def fail(self, name: str, keys: Iterable[str], reason: str) -> None:
        """Note that a launcher failed, and why."""
        for key in keys:
            self.failures[key, name] = reason

    def names(self) -> list[str]:
        """Return the launchers that measured something, ours first."""
        measured = {name for works in self.figures.values() for name in works}
        known = [name for name in self.versions if name in measured]
        return known or sorted(measured, key=lambda n: (n != OURS, n))

    def table(self) -> str:
        """Return the figures as a table in Markdown."""
        names = self.names()
        works = [work for work in WORKS if self.figures.get(work.key)]
        rows = [[work.title, *self._cells(work, names)] for work in works]
        return markdown(['', *names], rows)

    def worse(self) -> Iterator[str]:
        """Return a line for each work that others do with less."""
        for work in WORKS:
            figures = self.figures.get(work.key, {})
            medians = {n: statistics.median(f) for n, f in figures.items()}
            ours = medians.get(OURS)
            if ours is None:
                continue
            better = sorted(
                (median, name)
                for name, median in medians.items()
                if median < ours
            )
            if better:
                others = ', '.join(
                    f'{name} {amount(median, work.unit)}'
                    for median, name in better
                )
                yield f'{work.title}: {amount(ours, work.unit)}; {others}'

    def plot(self, name: str) -> str:
        """Return a plot of several works as SVG."""
        body, height = '', 0
        for work in WORKS:
            figures = self.figures.get(work.key)
            if work.plot == name and figures:
                panel, rows = self._panel(work, height)
                body += panel
                height += rows
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" '
            f'viewBox="0 0 {WIDTH} {height + 8}" width="{WIDTH}" '
            f'height="{height + 8}" role="img" '
            f'aria-label={quoteattr(PLOTS[name])}>\n'
            f'{STYLE}{body}</svg>\n'
        )

    def block(self) -> str:
        """Return what is written into the page."""
        versions = [[name, text] for name, text in self.versions.items()]
        parts = [
            markdown(['machine', ''], map(list, self.machine.items())),
            markdown(['what', 'version'], versions),
            self.table(),
            *(f'![{text}](benchmarks_{n}.svg)' for n, text in PLOTS.items()),
            '### Where others need less',
            '\n'.join(f'- {line}' for line in self.worse()) or 'Nowhere.',
        ]
        failures = sorted({(n, r) for (_, n), r in self.failures.items()})
        if failures:
            lines = '\n'.join(f'- {name}: {r}' for name, r in failures)
            parts += ['### What failed', lines]
        return '\n\n'.join(parts)

    def _cells(self, work: Work, names: list[str]) -> Iterator[str]:
        for name in names:
            figures = self.figures[work.key].get(name)
            if figures:
                yield cell(figures, work.unit)
            else:
                failed = (work.key, name) in self.failures
                yield 'failed' if failed else '–'

    def _panel(self, work: Work, top: int) -> tuple[str, int]:
        figures = self.figures[work.key]
        medians = {
            name: statistics.median(figures[name])
            for name in self.names()
            if figures.get(name)
        }
        longest = max(medians.values()) or 1
        title = work.title + (f' ({work.unit})' if work.unit else '')
        text = f'<text class="title" x="8" y="{top + 24}">{title}</text>\n'
        for number, (name, median) in enumerate(medians.items()):
            y = top + TITLE + number * ROW
            width = max(1, BAR * median / longest)
            ours = ' class="ours"' if name == OURS else ''
            text += (
                f'<text x="{LABEL - 8}" y="{y + 13}" text-anchor="end">'
                f'{escape(name)}</text>'
                f'<rect{ours} x="{LABEL}" y="{y + 2}" width="{width:.1f}" '
                f'height="{ROW - 6}"/>'
                f'<text x="{LABEL + width + 6:.1f}" y="{y + 13}">'
                f'{amount(median, work.unit)}</text>\n'
            )
        return text, TITLE + ROW * len(medians)


def number(figure: float) -> str:
    """Return a figure with two or three digits that count."""
    if figure >= 100 or figure == int(figure):
        return f'{figure:,.0f}'
    return f'{figure:.2g}' if figure < 10 else f'{figure:.3g}'


def amount(figure: float, unit: str) -> str:
    """Return a figure with its unit."""
    return f'{number(figure)} {unit}'.strip()


def cell(figures: list[float], unit: str) -> str:
    """Return the median and, if they are different, the quartiles."""
    median = amount(statistics.median(figures), unit)
    if len(figures) < 2:
        return median
    low, _, high = statistics.quantiles(figures, method='inclusive')
    if number(low) == number(high):
        return median
    return f'{median} ({number(low)}–{number(high)})'


def markdown(head: list[str], rows: Iterable[list[str]]) -> str:
    """Return a table in Markdown."""
    lines = [head, ['---'] * len(head), *rows]
    return '\n'.join(f'| {" | ".join(line)} |' for line in lines)


def machine(runs: int) -> dict[str, str]:
    """Return what measures, without its names and paths."""
    processor = re.search(
        r'^model name\s*: (.+)$',
        Path('/proc/cpuinfo').read_text(encoding='utf-8'),
        re.MULTILINE,
    )
    kernel = re.match(r'[\d.]+', platform.release())
    memory = os.sysconf('SC_PAGE_SIZE') * os.sysconf('SC_PHYS_PAGES')
    return {
        'processor': processor[1] if processor else platform.machine(),
        'cores': str(os.cpu_count()),
        'memory': f'{memory / 2**30:.0f} GiB',
        'system': platform.freedesktop_os_release()['PRETTY_NAME'],
        'kernel': f'Linux {kernel[0]}' if kernel else 'Linux',
        'Python': platform.python_version(),
        'load before': f'{os.getloadavg()[0]:.1f}',
        'runs': str(runs),
    }


def write_report(report: Report, docs: Path) -> None:
    """Write the plots, and replace the block in the page."""
    for name in PLOTS:
        path = docs / f'benchmarks_{name}.svg'
        path.write_text(report.plot(name), encoding='utf-8')
    page = docs / 'benchmarks.md'
    text = page.read_text(encoding='utf-8')
    before, _, rest = text.partition(BEGIN)
    _, _, after = rest.partition(END)
    block = f'{BEGIN}\n\n{report.block()}\n\n{END}'
    page.write_text(before + block + after, encoding='utf-8')
