# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
How a launch started: when each member was ready, and what it waited for.

It is read from the records of `events.jsonl`, and shown as the chain of those
that took longest, and as a page with a drawing. The page is one HTML file,
which loads nothing and runs nothing; text from launch files is escaped.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import field
from html import escape
import math
from typing import Any

from colcon_yamllaunch.common.frozen import dataclass, mutable
from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.common.table import without_end

# pixels of the drawing
_WIDTH, _LABELS, _RIGHT, _TOP, _ROW, _BAR = 1000, 220, 90, 30, 24, 14
_CHARACTERS = 30
#: Marks of the axis of time, about.
_TICKS = 10
#: Seconds that the drawing shows at least.
_LEAST_SECONDS = 0.1
# nothing is loaded or run, whatever gets into the page
_POLICY = "default-src 'none'; style-src 'unsafe-inline'"
_STYLE = """\
:root { color-scheme: light dark; --text: #1d2329; --faint: #5c6670;
  --line: #d9dee3; --wait: #b9c2cb; --start: #e0a100; --run: #2e9e5b;
  --bad: #c9372c; --page: #ffffff; }
@media (prefers-color-scheme: dark) { :root { --text: #e4e8ec;
  --faint: #9aa5b0; --line: #343c45; --wait: #55606b; --page: #14181c; } }
body { margin: 0 auto; max-width: 70rem; padding: 1rem; color: var(--text);
  background: var(--page); font: 1rem system-ui, sans-serif; }
h1 { font-size: 1.4rem; overflow-wrap: anywhere; }
h2 { font-size: 1.1rem; margin-top: 2rem; }
svg { width: 100%; height: auto; }
svg text { fill: var(--text); font-size: 12px; }
svg .faint { fill: var(--faint); }
.grid { stroke: var(--line); }
.awaited { stroke: var(--faint); fill: none; stroke-dasharray: 3 2; }
.waiting { fill: var(--wait); } .starting { fill: var(--start); }
.ready { fill: var(--run); } .failed { fill: var(--bad); }
.critical { font-weight: 700; }
pre { overflow-x: auto; } .wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: 0.9rem; width: 100%; }
td, th { text-align: left; padding: 0.2rem 0.6rem 0.2rem 0;
  border-bottom: 1px solid var(--line); vertical-align: top; }
.key { display: inline-block; width: 0.9rem; height: 0.9rem; margin: 0 0.3rem
  0 1rem; vertical-align: -0.1rem; }
.key.waiting { background: var(--wait); }
.key.starting { background: var(--start); }
.key.ready { background: var(--run); }
"""


@mutable
class Start:
    """
    The first start of a process or component.

    Times are seconds from the start of the launch.

    :param label: Its label
    :param waited_from: Since when it waited for others, None if it did not
    :param awaited: The labels of those
    :param started: When it started or was loaded, None if it did not
    :param ready: When it was ready, None if it was not or that is not known
    :param ended: When it ended, None if it did not before the launch
    :param problem: Why it was not ready, as a part of a sentence; or empty
    """

    label: str
    waited_from: float | None = None
    awaited: dict[str, None] = field(default_factory=dict)
    started: float | None = None
    ready: float | None = None
    ended: float | None = None
    problem: str = ''

    @property
    def done(self) -> float | None:
        """When the members that wait for it could start, None if unknown."""
        return self.started if self.ready is None else self.ready


@dataclass(frozen=True, slots=True)
class Timeline:
    """
    How a launch started.

    :param starts: Those of its processes and components, the first one first
    :param seconds: For how long it is known
    :param knows_readiness: Whether it is known when they were ready
    """

    starts: tuple[Start, ...]
    seconds: float
    knows_readiness: bool

    @property
    def chain(self) -> tuple[Start, ...]:
        """The last member to be ready, the last that it waited for, etc."""
        by_label = {start.label: start for start in self.starts}
        waiting = [s for s in self.starts if s.done is not None]
        chain: list[Start] = []
        while waiting:
            # of two that were ready at once, the one that started later
            last = max(waiting, key=lambda s: (s.done, s.started or 0.0))
            chain.append(last)
            waiting = [
                by_label[label]
                for label in last.awaited
                if label in by_label
                and by_label[label].done is not None
                and by_label[label] not in chain
            ]
        return tuple(chain)


def timeline_of(records: Iterable[Mapping[str, Any]]) -> Timeline:
    """
    Return how a launch started.

    :param records: Those of `events.jsonl`; what is no record is ignored
    """
    starts: dict[str, Start] = {}
    begin = end = None
    knows_readiness = False
    for record in records:
        time, name = record.get('time'), record.get('event')
        if not isinstance(time, int | float) or not isinstance(name, str):
            continue
        begin = time if begin is None else begin
        end = time - begin
        knows_readiness |= name in ('ready', 'waiting')
        label = record.get('label')
        if isinstance(label, str):
            start = starts.setdefault(label, Start(label))
            _apply(start, name, record, end)
    begun = [s for s in starts.values() if _first_time(s) is not None]
    return Timeline(
        tuple(sorted(begun, key=lambda s: (_first_time(s), s.started or 0.0))),
        end or 0.0,
        knows_readiness,
    )


def _first_time(start: Start) -> float | None:
    return start.started if start.waited_from is None else start.waited_from


def _apply(
    start: Start, name: str, record: Mapping[str, Any], time: float
) -> None:
    """Apply an event about a member."""
    match name:
        case 'waiting' if start.started is None:
            if start.waited_from is None:
                start.waited_from = time
            labels = record.get('labels')
            if isinstance(labels, list):
                start.awaited |= dict.fromkeys(map(str, labels))
        case 'started' | 'loaded' if start.started is None:
            start.started = time
        case 'ready' if start.ready is None:
            start.ready = time
            start.problem = ''
        case 'not_ready' if start.ready is None:
            conditions = record.get('conditions') or ['it to go on']
            what = ' and '.join(map(str, conditions))
            start.problem = f'waited for {what}'
        case 'not_started':
            start.problem = 'not started'
        case 'start_failed' | 'load_failed' if start.started is None:
            start.problem = str(record.get('reason', 'failed'))
            start.started = start.ended = time
        case 'exited' | 'unloaded' if start.ended is None:
            start.ended = time
        case _:
            return


def chain_as_text(timeline: Timeline) -> str:
    """Return the longest chain, as `systemd-analyze critical-chain` does."""
    what = 'ready' if timeline.knows_readiness else 'started'
    lines = [
        f'The time at which each was {what} is behind "@", the time that it '
        'took to be ready behind "+".'
    ]
    for depth, start in enumerate(timeline.chain):
        branch = '  ' * (depth - 1) + '└─' if depth else ''
        taken = (start.done or 0.0) - (start.started or 0.0)
        took = f' +{taken:.3f} s' if timeline.knows_readiness else ''
        name = f'{branch}{one_line(start.label)}'
        lines.append(f'{name} @{start.done:.3f} s{took}')
    lines += (
        f'{one_line(s.label)} was not ready: {one_line(s.problem)}'
        for s in timeline.starts
        if s.problem
    )
    return '\n'.join(lines)


def page(timeline: Timeline, title: str) -> str:
    """
    Return an HTML page with a drawing and a table.

    :param title: What was launched, or its log folder
    """
    heading = escape(f'How {one_line(title)} started')
    ready = sum(start.ready is not None for start in timeline.starts)
    count = len(timeline.starts)
    facts = f'{count} processes and components'
    if timeline.knows_readiness:
        facts += f', {ready} of them ready'
    if timeline.chain:
        facts += f', the last one after {timeline.chain[0].done:.3f} s'
    legend = ''.join(
        f'<span class="key {kind}"></span>{kind}'
        for kind in ('waiting', 'starting', 'ready')
    )
    return '\n'.join(
        (
            '<!DOCTYPE html>',
            '<html lang="en"><head><meta charset="utf-8">',
            '<meta http-equiv="Content-Security-Policy" '
            f'content="{escape(_POLICY)}">',
            '<meta name="viewport" content="width=device-width">',
            f'<title>{heading}</title><style>{_STYLE}</style></head><body>',
            f'<h1>{heading}</h1>',
            f'<p>{escape(facts)}.{legend}</p>',
            f'<div class="wide">{_drawing(timeline)}</div>',
            '<h2>The longest chain</h2>',
            f'<pre>{escape(chain_as_text(timeline))}</pre>',
            '<h2>Times</h2>',
            *_table(timeline),
            '</body></html>',
            '',
        )
    )


def _table(timeline: Timeline) -> Iterator[str]:
    yield (
        '<div class="wide"><table><tr><th>name</th><th>waited for</th>'
        '<th>started (s)</th><th>ready (s)</th><th>took (s)</th><th></th></tr>'
    )
    for start in timeline.starts:
        taken = None
        if start.ready is not None and start.started is not None:
            taken = start.ready - start.started
        cells = (
            start.label,
            ', '.join(start.awaited),
            *map(_number, (start.started, start.ready, taken)),
            start.problem,
        )
        shown = ''.join(f'<td>{escape(one_line(cell))}</td>' for cell in cells)
        yield f'<tr>{shown}</tr>'
    yield '</table></div>'


def _number(seconds: float | None) -> str:
    return '' if seconds is None else f'{seconds:.3f}'


def _drawing(timeline: Timeline) -> str:
    """Draw the starts as bars, and what waited for what as lines."""
    end = _shown_seconds(timeline)
    critical = {start.label for start in timeline.chain}
    rows = {s.label: number for number, s in enumerate(timeline.starts)}
    height = _TOP + _ROW * len(rows) + 6

    def across(seconds: float) -> float:
        part = min(max(seconds / end, 0.0), 1.0)
        return _LABELS + part * (_WIDTH - _LABELS - _RIGHT)

    def middle(number: int) -> float:
        return _TOP + _ROW * (number + 0.5)

    lines = list(_axis(end, height))
    for number, start in enumerate(timeline.starts):
        for other in (rows[label] for label in start.awaited if label in rows):
            done = timeline.starts[other].done
            if done is None:
                continue
            x, target = across(done), across(start.started or done)
            lines.append(
                f'<path class="awaited" d="M{x:.1f} {middle(other):.1f} '
                f'V{middle(number):.1f} H{target:.1f}"/>'
            )
    for number, start in enumerate(timeline.starts):
        top = _TOP + _ROW * number
        kind = 'critical' if start.label in critical else ''
        label = without_end(one_line(start.label), _CHARACTERS)
        lines.append(
            f'<text class="{kind}" x="4" y="{top + 16}">{escape(label)}</text>'
        )
        spans = list(_spans(start, end))
        for span, begin, finish in spans:
            left, right = across(begin), across(finish)
            text = f'{one_line(start.label)}: {span} {begin:.3f} s'
            text += f' to {finish:.3f} s' if finish < end else ' on'
            lines.append(
                f'<rect class="{span}" x="{left:.1f}" y="{top + 5}" '
                f'width="{max(1.0, right - left):.1f}" height="{_BAR}">'
                f'<title>{escape(text)}</title></rect>'
            )
        done = start.done
        if spans and done is not None:
            lines.append(
                f'<text class="faint" x="{_WIDTH - _RIGHT + 6}" '
                f'y="{top + 16}">@{done:.3f} s</text>'
            )
    return (
        f'<svg viewBox="0 0 {_WIDTH} {height}" role="img" '
        f'aria-label="When each process started and was ready">'
        f'{"".join(lines)}</svg>'
    )


def _shown_seconds(timeline: Timeline) -> float:
    """Return where the drawing ends: a bit after all were ready."""
    times = [
        time
        for start in timeline.starts
        for time in (start.waited_from, start.started, start.ready)
        if time is not None
    ]
    last = max(times, default=0.0)
    if timeline.knows_readiness and any(
        start.ready is None for start in timeline.starts
    ):
        last = timeline.seconds
    return max(last * 1.05, _LEAST_SECONDS)


def _spans(start: Start, end: float) -> Iterator[tuple[str, float, float]]:
    """Iterate over what a member did, with its begin and end."""
    if start.waited_from is not None:
        until = end if start.started is None else start.started
        yield 'waiting', start.waited_from, until
    if start.started is None:
        return
    finish = end if start.ended is None else start.ended
    if start.ready is None:
        yield 'failed' if start.problem else 'starting', start.started, finish
        return
    yield 'starting', start.started, start.ready
    if finish > start.ready:
        yield 'ready', start.ready, finish


def _axis(end: float, height: int) -> Iterator[str]:
    for tick in _ticks(end):
        x = _LABELS + tick / end * (_WIDTH - _LABELS - _RIGHT)
        yield (
            f'<line class="grid" x1="{x:.1f}" y1="{_TOP - 6}" '
            f'x2="{x:.1f}" y2="{height}"/>'
            f'<text class="faint" x="{x:.1f}" y="{_TOP - 12}" '
            f'text-anchor="middle">{tick:g} s</text>'
        )


def _ticks(end: float) -> Sequence[float]:
    """Return round times up to the end."""
    rough = end / _TICKS
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(m * power for m in (1, 2, 5, 10) if m * power >= rough)
    return [round(n * step, 9) for n in range(int(end / step) + 1)]
