# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the guard does with the terminal of a killed launcher."""

import json
import os
import termios

from colcon_yamllaunch.engine.channels import as_numbers, HeldTerminal
from colcon_yamllaunch.terminal.keyboard import Keyboard
from colcon_yamllaunch.terminal.status_block import StatusBlock
from colcon_yamllaunch.terminal.status_writer import drawn
import pytest
from support.virtual_screen import VirtualScreen


@pytest.fixture
def held():
    """Return a terminal whose keyboard was grabbed, and its modes before."""
    ours, theirs = os.openpty()
    before = termios.tcgetattr(theirs)
    keyboard = Keyboard(theirs)
    assert keyboard.grab()
    # as they get to the guard
    modes = json.loads(json.dumps([*map(as_numbers, keyboard.modes)]))
    yield HeldTerminal(theirs, *modes), before, ours
    os.close(ours)
    os.close(theirs)


def test_it_is_as_it_was_before(held):
    terminal, before, ours = held
    assert termios.tcgetattr(terminal.descriptor) != before
    terminal.restore()
    assert termios.tcgetattr(terminal.descriptor) == before
    assert os.read(ours, 100).endswith(b'\x1b[J')


def test_modes_that_a_shell_has_set_stay(held):
    terminal, _, _ = held
    shell = termios.tcgetattr(terminal.descriptor)
    shell[6][termios.VMIN] = 2
    termios.tcsetattr(terminal.descriptor, termios.TCSANOW, shell)
    shell = termios.tcgetattr(terminal.descriptor)
    terminal.restore()
    assert termios.tcgetattr(terminal.descriptor) == shell


def test_modes_that_were_not_changed_stay(held):
    terminal, _, _ = held
    modes = termios.tcgetattr(terminal.descriptor)
    HeldTerminal(terminal.descriptor, None, None).restore()
    assert termios.tcgetattr(terminal.descriptor) == modes


def test_a_terminal_that_is_gone_is_no_matter(held):
    terminal, _, _ = held
    reader, writer = os.pipe()
    os.close(reader)
    HeldTerminal(writer, terminal.before, terminal.now).restore()
    os.close(writer)


def test_a_shell_that_has_it_before_does_not_see_an_end(held):
    # it would read nothing at once, and take that for the end of its input
    terminal, _, ours = held
    assert termios.tcgetattr(terminal.descriptor)[6][termios.VMIN] == 1
    keyboard = Keyboard(terminal.descriptor)
    assert keyboard.keys() == b''
    os.write(ours, b'x')
    assert keyboard.keys() == b'x'


def test_what_is_left_of_a_block_and_a_scroll_region_is_gone():
    screen = VirtualScreen(20, 6)
    text = 'a\r\nb\r\nc\r\nd\r\n one\r\n two\x1b[1;4r\x1b[4;1H\r\nlast'
    os.write(screen.theirs, text.encode())
    assert screen.lines == ['b', 'c', 'd', 'last', ' one', ' two']
    HeldTerminal(screen.theirs, None, None).restore()
    assert screen.lines == ['b', 'c', 'd', 'last']
    # all of the screen scrolls again
    os.write(screen.theirs, b'\r\n$' * 4)
    assert screen.lines == ['d', 'last', '$', '$', '$', '$']
    screen.close()


def test_where_somebody_types_all_of_the_block_is_gone():
    screen = VirtualScreen(20, 6)
    os.write(screen.theirs, b'a\r\n')
    block = StatusBlock((' one', '/typed'), (1, 6))
    os.write(screen.theirs, drawn(block, is_mid_line=False))
    assert screen.lines == ['a', ' one', '/typed']
    HeldTerminal(screen.theirs, None, None).restore(goes_back=True)
    assert screen.lines == ['a']
    screen.close()
