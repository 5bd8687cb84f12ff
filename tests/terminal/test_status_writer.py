# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is on a screen that has a block below the output."""

import math

from colcon_yamllaunch.terminal import status_writer
from colcon_yamllaunch.terminal.status_block import StatusBlock
import pytest
from support.virtual_screen import VirtualScreen


class Shown:
    """A writer on a screen, whose time passes as the test says."""

    def __init__(self, columns=40, lines=8):
        self.screen = VirtualScreen(columns, lines)
        self.now = 100.0
        self.block = StatusBlock((' one', ' two'))
        self.next = None
        self.composed = 0
        self.writer = status_writer.StatusWriter(
            self.screen.theirs, lambda: self.now
        )

    def begin(self):
        self.writer.begin(self._compose)
        return self.flush()

    def _compose(self, now):
        assert now == self.now
        self.composed += 1
        return self.block, self.next

    def write(self, text):
        self.writer.write('a', text.encode())
        return self

    def flush(self):
        self.writer.flush()
        return self

    def draws(self, *lines, cursor=None, at_once=False):
        """Have another block from now on."""
        self.block = StatusBlock(lines, cursor)
        self.writer.touch(at_once=at_once)
        return self

    def later(self, seconds=status_writer.INTERVAL):
        self.now += seconds
        return self.flush()

    @property
    def lines(self):
        return self.screen.lines


@pytest.fixture
def shown():
    made = []

    def make(*size):
        made.append(Shown(*size))
        return made[-1]

    yield make
    for one in made:
        one.writer.close()
        one.screen.close()


def test_output_scrolls_above_the_block(shown):
    one = shown().begin()
    assert one.lines == [' one', ' two']
    lines = [f'line {number}' for number in range(10)]
    for line in lines:
        one.write(f'{line}\r\n').later()
    assert one.lines[-4:] == ['line 8', 'line 9', ' one', ' two']
    assert one.screen.all_lines == [*lines, ' one', ' two']


def test_partial_line_continues_where_it_ended(shown):
    one = shown(20, 4).begin()
    for number in range(5):
        one.write(f'line {number}\r\n').later()
    for text in ('name? ', 'Ada', ' L.\r\n'):
        one.write(text).later()
    lines = one.screen.all_lines[-4:]
    assert lines == ['line 4', 'name? Ada L.', ' one', ' two']


def test_long_partial_line_wraps(shown):
    one = shown(20, 6).begin().write('x' * 50).later()
    assert one.lines == ['x' * 20, 'x' * 20, 'x' * 10, ' one', ' two']
    one.write('y' * 15 + '\r\n').later()
    assert one.lines[2:] == ['x' * 10 + 'y' * 10, 'y' * 5, ' one', ' two']


def test_line_with_carriage_return_is_rewritten_in_place(shown):
    one = shown().begin().write('50 %\r').later()
    assert one.lines == ['50 %', ' one', ' two']
    one.write('60 %\r').later()
    assert one.lines == ['60 %', ' one', ' two']
    one.writer.end()
    assert one.lines == ['60 %']


def test_unchanged_block_writes_nothing(shown):
    one = shown().begin().write('line\r\n').later()
    assert one.lines
    before = one.screen.received
    for _ in range(100):
        one.writer.touch()
        one.later()
    assert one.lines and one.screen.received == before
    assert one.writer.due() is None


def test_block_is_drawn_at_most_ten_times_a_second(shown):
    one = shown().begin()
    for number in range(100):
        one.draws(f' {number}').write(f'{number}\r\n').later(0.01)
    # the first one, and one for each tenth of a second that began since
    assert 10 <= one.composed <= 12


def test_output_waits_for_the_next_drawing(shown):
    one = shown().begin().write('first\r\n').flush()
    assert one.lines == [' one', ' two']
    assert not one.writer.waits()
    assert one.writer.due() - one.now == pytest.approx(status_writer.INTERVAL)
    one.later()
    assert one.lines == ['first', ' one', ' two']
    # after a pause it is shown at once
    one.now += 1.0
    one.write('second\r\n').flush()
    assert one.lines == ['first', 'second', ' one', ' two']


def test_changed_block_is_drawn_in_place(shown):
    one = shown().begin().write('line\r\n').later()
    for lines in ((' a', ' b', ' c'), (' d',), (), (' e', ' f')):
        one.draws(*lines).later()
        assert one.lines == ['line', *lines]
    assert one.screen.all_lines == ['line', ' e', ' f']


def test_block_at_the_bottom_grows_upwards(shown):
    one = shown(20, 4).begin()
    for number in range(6):
        one.write(f'line {number}\r\n').later()
    one.draws(' a', ' b', ' c').later()
    assert one.lines == ['line 5', ' a', ' b', ' c']
    assert one.screen.all_lines[:6] == [f'line {n}' for n in range(6)]


def test_block_is_composed_again_at_its_time(shown):
    one = shown()
    one.next = 101.0
    one.begin()
    one.block = StatusBlock((' later',))
    assert one.writer.due() - one.now == pytest.approx(1.0)
    one.later(0.5)
    assert one.lines == [' one', ' two']
    one.later(0.5)
    assert one.lines == [' later']


def test_end_erases_the_block_and_keeps_output(shown):
    one = shown().begin().write('line\r\n').flush()
    one.writer.end()
    one.write('more\r\n').flush()
    assert one.lines == ['line', 'more']
    assert one.screen.cursor == (2, 0)
    assert one.writer.due() is None


def test_missing_block_leaves_output_only(shown):
    one = shown().begin()
    one.block, one.next = None, 105.0
    one.writer.touch()
    one.later().write('line\r\n').flush()
    one.write('more\r\n').flush()
    assert one.lines == ['line', 'more']
    assert one.writer.due() == pytest.approx(105.0)
    one.block, one.next = StatusBlock((' again',)), None
    one.later(10.0)
    assert one.lines == ['line', 'more', ' again']


def test_typing_shows_each_key_and_places_the_cursor(shown):
    one = shown().begin().write('line\r\n').later()
    for typed in ('', 'h', 'he'):
        cursor = (1, 1 + len(typed))
        one.draws(' one', f'/{typed}', cursor=cursor, at_once=True).flush()
        assert one.lines == ['line', ' one', f'/{typed}']
        assert one.screen.cursor == (2, 1 + len(typed))
    one.write('more\r\n').later()
    assert one.lines == ['line', 'more', ' one', '/he']
    assert one.screen.cursor == (3, 3)
    one.write('half').later()
    assert one.lines == ['line', 'more', 'half', ' one', '/he']
    one.write(' of it\r\n').later()
    assert one.lines == ['line', 'more', 'half of it', ' one', '/he']
    one.writer.end()
    assert one.lines == ['line', 'more', 'half of it']
    assert one.screen.cursor == (3, 0)


@pytest.mark.parametrize('columns', [12, 30, 90])
def test_resized_terminal_redraws_the_block(shown, columns):
    one = shown(40, 8)
    one.block = StatusBlock((' ' + 'a' * 35, ' ' + 'b' * 35))
    one.begin().write('line\r\n').later()
    one.screen.resize(columns, 8)
    lines = [' ' + letter * (columns - 2) for letter in 'AB']
    one.draws(*lines).later().write('more\r\n').later()
    assert one.lines == ['line', 'more', *lines]


def test_too_long_block_line_is_cut_by_the_terminal(shown):
    one = shown(10, 6)
    one.block = StatusBlock((' ' + 'a' * 30, ' b'))
    one.begin().write('line\r\n').later().write('y' * 15 + '\r\n').later()
    *output, block, _ = (line[:9] for line in one.lines)
    assert output == ['line', 'y' * 9, 'y' * 5]
    assert (block, one.lines[-1]) == (' ' + 'a' * 8, ' b')


def test_the_title_does_not_move_the_block(shown):
    one = shown().begin()
    one.writer.steer(b'\x1b]2;title\x07')
    one.later()
    assert one.lines == [' one', ' two']
    # not even when the block has to be drawn anew, but later
    before = one.screen.received
    one.writer.touch()
    one.writer.steer(b'\x1b]2;other\x07')
    one.flush()
    assert not one.writer.waits()
    assert one.lines and one.screen.received > before


def test_raw_output_cannot_leave_its_line(shown):
    one = shown().begin().write('line\r\n').later()
    hostile = b'> \x1b[2J\x1b[H\x1b[5Bx\x1b[?25l\x1b7\x1b[1;1r\x1b[10A\x1bcy'
    for number in range(len(hostile)):
        one.writer.write_raw('a', hostile[number : number + 1])
    one.later()
    assert one.lines == ['line', '> xy', ' one', ' two']
    one.writer.write_raw('a', b'\b\b\x1b[Kz\x1b[31mred\x1b[0m\r\n')
    one.later()
    assert one.lines == ['line', '> zred', ' one', ' two']


def test_blocked_terminal_gets_no_more_blocks(shown, monkeypatch):
    one = shown().begin()
    with monkeypatch.context() as patch:
        patch.setattr(one.writer, '_write_some', lambda: False)
        one.write('line\r\n').later()
        composed = one.composed
        for number in range(9):
            one.draws(f' {number}').write('more\r\n')
            one.later(2 * status_writer.SLOW_INTERVAL)
        assert one.composed == composed
        # that it goes on is waited for
        assert one.writer.waits()
        assert one.writer.due() == math.inf
    one.later()
    one.later(status_writer.SLOW_INTERVAL)
    assert one.lines == ['more'] * 7 + [' 8']


def test_colours_of_raw_output_are_reset(shown):
    one = shown().begin()
    one.block = StatusBlock((' one', '> '), (1, 2))
    one.writer.write_raw('a', b'\x1b[41;32mred')
    one.later().write('\r\nplain\r\n').later()
    assert one.screen.colour_of('red') == 'green'
    assert one.screen.colour_of('plain') == 'default'
    assert one.screen.colour_of('one') == 'default'
    one.writer.write_raw('a', b'\x1b[41;32mred\r\n')
    one.later().writer.end()
    one.write('a prompt').flush()
    assert one.screen.colour_of('a prompt') == 'default'
    assert one.screen.background_of(5) == 'default'


@pytest.fixture
def flooded(shown, monkeypatch):
    """Return a writer that much has been written to already, and its lines."""
    monkeypatch.setattr(status_writer, 'HELD', 100)

    def make(*size):
        one = shown(*size).begin()
        written = [f'{number:09}' for number in range(40)]
        for line in written:
            one.write(f'{line}\r\n')
        one.flush().later()
        return one, written

    return make


def test_flood_scrolls_above_the_block(flooded):
    one, written = flooded(40, 8)
    composed = one.composed
    for number in range(40):
        lines = [f'{number} {n}' for n in range(3 + number)]
        # of several processes
        one.write(''.join(f'{line}\r\n' for line in lines[:2]))
        one.write(''.join(f'{line}\r\n' for line in lines[2:])).flush()
        written += lines
        assert one.lines == [*written[-6:], ' one', ' two']
        assert one.screen.cursor == (6, 0)
    assert one.screen.all_lines == [*written, ' one', ' two']
    assert one.composed == composed
    # what changes is drawn in its place, and not more often
    one.draws(' 1', ' 2').write('more\r\n').flush()
    assert one.lines[-3:] == ['more', ' one', ' two']
    one.later()
    assert one.lines[-3:] == ['more', ' 1', ' 2']
    # what comes slowly again, too
    one.later().write('slow\r\n').flush().later()
    assert one.lines[-3:] == ['slow', ' 1', ' 2']
    one.writer.end()
    assert one.screen.all_lines == [*written, 'more', 'slow']


def test_long_line_of_a_flood_wraps(flooded):
    one, written = flooded(10, 8)
    one.write('x' * 25 + '\r\n' + 'y' * 10 + '\r\n').flush()
    one.write('z' * 20 + '\r\n').flush()
    parts = ['x' * 10, 'x' * 10, 'x' * 5, 'y' * 10, 'z' * 10, 'z' * 10]
    assert one.lines == [*parts, ' one', ' two']
    assert one.screen.all_lines[:-2] == [*written, *parts]


def test_flood_keeps_the_cursor_while_typing(flooded):
    one, _ = flooded(40, 8)
    one.draws(' one', '/he', cursor=(1, 3), at_once=True).flush()
    for number in range(20):
        one.write(f'{number}\r\n' * 9).flush()
        assert one.lines == [str(number)] * 6 + [' one', '/he']
        assert one.screen.cursor == (7, 3)
    one.writer.end()
    assert one.screen.all_lines[-1] == '19'
    assert one.screen.cursor == (6, 0)


def test_partial_line_in_a_flood_continues(flooded):
    one, written = flooded(40, 8)
    one.write('more\r\nname? ').flush().later()
    one.write('Ada\r\n' + 'last\r\n' * 9).flush().later()
    lines = [*written, 'more', 'name? Ada', *['last'] * 9]
    assert one.screen.all_lines == [*lines, ' one', ' two']


@pytest.mark.parametrize('size', [(40, 20), (12, 8), (90, 9)])
def test_resized_terminal_keeps_all_lines_of_a_flood(flooded, size):
    one, written = flooded(40, 8)
    # before anybody has told us
    one.screen.resize(*size)
    for number in range(3):
        one.write('x\r\n' * 20).flush()
        written += ['x'] * 20
        if number == 1:
            one.writer.resized()
        one.later()
    assert one.screen.all_lines == [*written, ' one', ' two']


def test_block_height_changes_during_a_flood(flooded):
    one, written = flooded(40, 8)
    for block in ((' a', ' b', ' c'), (' d',), (), (' e', ' f')):
        one.draws(*block).later()
        for _ in range(3):
            one.write('x\r\n' * 20).flush().later()
            written += ['x'] * 20
            above = ['x'] * (8 - len(block) - (not block))
            assert one.lines == [*above, *block]
    assert one.screen.all_lines == [*written, ' e', ' f']


def test_slow_terminal_keeps_the_block(flooded, monkeypatch):
    one, written = flooded(40, 8)
    one.later().later()
    with monkeypatch.context() as patch:
        patch.setattr(one.writer, '_write_some', lambda: False)
        one.write('held up\r\n').flush()
    one.write('behind\r\n')
    one.flush()
    assert one.lines[-4:] == ['held up', 'behind', ' one', ' two']
    assert one.screen.all_lines[:-4] == written
