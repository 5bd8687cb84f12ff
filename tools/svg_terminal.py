# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Pictures of terminals, as SVG.

The text is text, and the terminal brings its background along, so it can be
read on a light page and on a dark one.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
import html
import re

from recorded_terminal import Piece, Row

#: The size of a character in the picture, and the space around the text.
WIDTH, HEIGHT, MARGIN = 8.4, 18, 14
FOREGROUND, BACKGROUND = '#dcdfe4', '#1e2127'
#: The colours of a terminal, as pyte calls them: One Dark's.
COLORS = {
    'foreground': FOREGROUND,
    'background': BACKGROUND,
    'black': '#3f4451',
    'red': '#e06c75',
    'green': '#98c379',
    'brown': '#e5c07b',
    'blue': '#61afef',
    'magenta': '#c678dd',
    'cyan': '#56b6c2',
    'white': '#dcdfe4',
    'brightblack': '#959ba6',
    'brightred': '#ef7d87',
    'brightgreen': '#a9d48a',
    'brightbrown': '#f0cf8c',
    'brightblue': '#7dbff5',
    'brightmagenta': '#d291e4',
    'brightcyan': '#6cc7d2',
    'brightwhite': '#ffffff',
}
# signs that may come from another font, in which they are wider
_WORDS = re.compile(r'[\x20-\x7e]+|[^\x20-\x7e]')


@dataclass(frozen=True, slots=True)
class Frame:
    """
    What changes in a film.

    :param second: When
    :param count: How many rows of output there are from then on
    :param below: What stands below them, from then on
    """

    second: float
    count: int
    below: tuple[Row, ...]


@dataclass(slots=True)
class Film:
    """
    What a terminal shows over time.

    :param output: The rows that stay, in order
    :param frames: The first one has the second 0
    :param poster: The index of the frame with which the film starts, and which
      a viewer without animations shows
    """

    columns: int
    rows: int
    output: list[Row] = field(default_factory=list)
    frames: list[Frame] = field(default_factory=list)
    poster: int = 0


def still(rows: Sequence[Row], columns: int, title: str) -> str:
    """
    Draw a screen.

    :param title: What it shows, for who cannot see it
    """
    return _picture(columns, len(rows), title, '', '\n'.join(_drawn(rows)))


def film(reel: Film, rest: float, title: str) -> str:
    """
    Draw a film, which is repeated without end.

    :param rest: How many seconds the last frame is shown
    :param title: What the film shows, for a screen reader
    """
    frames = reel.frames
    poster = frames[reel.poster]
    total = frames[-1].second + rest
    percents = [f'{100 * frame.second / total:.2f}%' for frame in frames]
    tops = list(_tops(reel))
    # a row of output stands where it is written, and all of them move up;
    # what is below them follows their end
    rules = [
        '.a { animation: 1s step-end infinite; '
        f'animation-duration: {total:.2f}s; '
        f'animation-delay: -{poster.second:.2f}s; }}',
        _moves('scroll', percents, tops),
        _moves('end', percents, [-frame.count for frame in frames]),
    ]
    drawn, later, known = [], [], 0
    for percent, frame in zip(percents, frames, strict=True):
        if frame.count > known:
            name = f'o{known}'
            rules.append(
                f'@keyframes {name} {{ 0% {{ opacity: 0; }} '
                f'{percent} {{ opacity: 1; }} }}'
            )
            rows = _drawn(reel.output[known : frame.count], known)
            drawn.append(_animated(name, rows))
            if frame.count > poster.count:
                later.append(f'#{name}')
            known = frame.count
    blocks = dict.fromkeys(frame.below for frame in frames if frame.below)
    below = []
    for number, block in enumerate(blocks):
        name = f'b{number}'
        seen = [int(frame.below == block) for frame in frames]
        steps = _steps(percents, seen, 'opacity: {};')
        rules.append(f'@keyframes {name} {{ {steps} }}')
        below.append(_animated(name, _drawn(block)))
    shown = f'b{list(blocks).index(poster.below)}'
    rules += [
        '@media (prefers-reduced-motion) { .a { animation: none; } }',
        f'{", ".join([*later, "#end .a"])} {{ opacity: 0; }}',
        f'#end #{shown} {{ opacity: 1; }}',
        f'#scroll {{ {_up(tops[reel.poster])} }}',
        f'#end {{ {_up(-poster.count)} }}',
    ]
    end = _animated('end', below)
    body = _animated('scroll', [*drawn, end])
    return _picture(
        reel.columns, reel.rows, title, '\n'.join(rules), body, is_clipped=True
    )


def _tops(reel: Film) -> Iterator[int]:
    """Return the number of rows that have left the screen, at each frame."""
    top = 0
    for frame in reel.frames:
        # a terminal does not scroll back
        top = max(top, frame.count + len(frame.below) - reel.rows)
        yield top


def _animated(name: str, content: Iterable[str]) -> str:
    style = f'animation-name: {name}'
    return '\n'.join(
        [f'<g id="{name}" class="a" style="{style}">', *content, '</g>']
    )


def _moves(name: str, percents: Sequence[str], rows: Sequence[int]) -> str:
    steps = _steps(percents, [_up(row) for row in rows], '{}')
    return f'@keyframes {name} {{ {steps} }}'


def _up(rows: int) -> str:
    return f'transform: translateY({-rows * HEIGHT}px);'


def _steps(
    percents: Sequence[str], values: Sequence[object], form: str
) -> str:
    """Return the steps at which a value is another one."""
    steps: dict[str, object] = {}
    for percent, value in zip(percents, values, strict=True):
        steps[percent] = value
    before, found = None, []
    for percent, value in steps.items():
        if value != before:
            found.append(f'{percent} {{ {form.format(value)} }}')
        before = value
    return ' '.join(found)


def _picture(
    columns: int,
    rows: int,
    title: str,
    rules: str,
    body: str,
    *,
    is_clipped: bool = False,
) -> str:
    width = round(columns * WIDTH + 2 * MARGIN)
    height = rows * HEIGHT + 2 * MARGIN
    if is_clipped:
        body = (
            f'<clipPath id="screen"><rect y="{MARGIN}" width="{width}" '
            f'height="{rows * HEIGHT}"/></clipPath>\n'
            f'<g clip-path="url(#screen)">\n{body}\n</g>'
        )
    return f"""\
<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" \
width="{width}" height="{height}" role="img" \
aria-label="{html.escape(title)}">
<style>
text {{ font: 14px ui-monospace, Menlo, Consolas, 'DejaVu Sans Mono', \
monospace; fill: {FOREGROUND}; white-space: pre; }}
.b {{ font-weight: bold; }}
{rules}
</style>
<rect width="{width}" height="{height}" rx="8" fill="{BACKGROUND}"/>
{body}
</svg>
"""


def _drawn(rows: Sequence[Row], first: int = 0) -> Iterator[str]:
    for number, row in enumerate(rows, first):
        top = MARGIN + number * HEIGHT
        for piece in row:
            if piece.ground != 'default':
                yield (
                    f'<rect x="{_x(piece.column)}" y="{top}" '
                    f'width="{len(piece.text) * WIDTH:.1f}" '
                    f'height="{HEIGHT}" fill="{_color(piece.ground)}"/>'
                )
        spans = ''.join(span for piece in row for span in _spans(piece))
        if spans:
            y = top + round(HEIGHT * 0.75)
            yield f'<text y="{y}" xml:space="preserve">{spans}</text>'


def _spans(piece: Piece) -> Iterator[str]:
    look = ''
    if piece.color != 'default':
        look += f' fill="{_color(piece.color)}"'
    if piece.is_bold:
        look += ' class="b"'
    for word in _WORDS.finditer(piece.text):
        text = word[0]
        if not text.strip():
            continue
        column = piece.column + word.start()
        column += len(text) - len(text.lstrip())
        yield (
            f'<tspan x="{_x(column)}"{look}>{html.escape(text.strip())}'
            '</tspan>'
        )


def _x(column: int) -> str:
    return f'{MARGIN + column * WIDTH:.1f}'.removesuffix('.0')


def _color(name: str) -> str:
    return COLORS.get(name, f'#{name}')
