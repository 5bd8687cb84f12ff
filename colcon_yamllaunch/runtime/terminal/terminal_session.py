# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What a launch has of the terminal that it was started in.

That is the status block below the output, and the keyboard. Both are somebody
else's while the launch is suspended or in the background.
"""

from collections.abc import Callable
from collections.abc import Iterable
import math
import select

from colcon_yamllaunch.language.plan.plan import Entry
from colcon_yamllaunch.runtime.control.keyboard import is_in_foreground
from colcon_yamllaunch.runtime.control.keyboard import Keyboard
from colcon_yamllaunch.runtime.core import events
from colcon_yamllaunch.runtime.course.engine import Engine
from colcon_yamllaunch.runtime.course.exit_conditions import ExitConditions
from colcon_yamllaunch.runtime.stopping.guard_link import GuardLink
from colcon_yamllaunch.runtime.streams.channels import size_of
from colcon_yamllaunch.runtime.terminal.board import Board
from colcon_yamllaunch.runtime.terminal.cpu_shares import CpuShares
from colcon_yamllaunch.runtime.terminal.foot import Foot
from colcon_yamllaunch.runtime.terminal.status_block import Block
from colcon_yamllaunch.runtime.terminal.status_block import block_of
from colcon_yamllaunch.runtime.terminal.status_block import MAXIMUM_LINES
from colcon_yamllaunch.runtime.terminal.status_block import next_change
from colcon_yamllaunch.runtime.terminal.status_block import Style
from colcon_yamllaunch.runtime.terminal.status_block import View

#: Seconds between two looks at what takes much of a processor, and those for
#: each process where they are many: a look takes some 30 µs for each.
LOOK_INTERVAL = 2.0
LOOK_SHARE = 0.05
#: The part of the lines of a terminal that the block takes at most, as one
#: divided by this.
PART = 3


class TerminalSession:
    """
    Has the terminal of a launch, as long as that is in its foreground.

    :param entries: Those of the plan
    :param foot: Writes to the terminal
    :param guard: Is told of the terminal
    :param keyboard: The same terminal, None if somebody else has its keys
    :param color: Whether the block is coloured
    :param is_plain: Whether the terminal has nothing but ASCII
    :param conditions: What the launch waits for to end by itself
    :param clock: Returns seconds that never go back
    """

    def __init__(
        self,
        entries: Iterable[Entry],
        foot: Foot,
        guard: GuardLink,
        keyboard: Keyboard | None,
        *,
        color: bool,
        is_plain: bool,
        conditions: ExitConditions,
        clock: Callable[[], float],
    ) -> None:
        #: What the block tells.
        self.board = Board(entries, clock)
        #: What the keys have made of it.
        self.view = View()
        self._foot = foot
        self._guard = guard
        self._keyboard = keyboard
        self._color = color
        self._is_plain = is_plain
        self._conditions = conditions
        self._clock = clock
        self._engine: Engine | None = None
        self._shares = CpuShares()
        self._next_look = clock() + LOOK_INTERVAL
        self._drawn_version = 0
        self._is_active = False
        self._is_grabbed = False

    def showing(self, show: events.Listener) -> events.Listener:
        """
        Return who shows what happens.

        :param show: Shows it above the block
        """

        def handle(event: events.Event) -> None:
            # most of what happens is output
            if isinstance(event, events.Output):
                show(event)
                return
            self.board.handle(event)
            if self.board.version != self._drawn_version:
                self._foot.touch()
            if self._is_active and isinstance(event, events.StillRunning):
                # the block counts down
                return
            show(event)

        return handle

    def connect(self, engine: Engine) -> None:
        """Use an engine, before it runs."""
        self._engine = engine
        engine.when_suspended.append(self._suspend)
        engine.when_resized.append(self._foot.touch)
        self._foot.begin(self._compose)

    def close(self) -> None:
        """Give the terminal back as it was."""
        self._end()
        self._engine = None

    def show(self, view: View) -> None:
        """Show at once what a key has made of the block."""
        if view != self.view:
            self.view = view
            self._foot.touch(at_once=True)

    def _suspend(self, is_suspended: bool) -> None:
        self._end()
        if not is_suspended:
            self._foot.begin(self._compose)

    def _mind_foreground(self) -> None:
        """Take the terminal, or leave it to another job that has it."""
        if is_in_foreground(self._foot.descriptor) == self._is_active:
            return
        if self._is_active:
            self._is_active = False
            self._let_keys_go()
            return
        self._is_active = True
        keyboard, engine = self._keyboard, self._engine
        before = None
        if keyboard is not None and engine is not None and keyboard.grab():
            self._is_grabbed = True
            before = keyboard.modes
            if keyboard.takes_keys:
                engine.watches.add(keyboard.descriptor, self._readable)
        self._guard.terminal(self._foot.descriptor, before)

    def _end(self) -> None:
        self._is_active = False
        self._foot.leave()
        self._let_keys_go()
        self._guard.no_terminal()

    def _let_keys_go(self) -> None:
        if self._is_grabbed and self._keyboard and self._engine:
            self._is_grabbed = False
            self._engine.watches.remove(self._keyboard.descriptor)
            self._keyboard.release()

    def _readable(self, mask: int) -> None:
        assert self._keyboard is not None
        try:
            keys, _ = self._keyboard.read()
        except OSError:
            keys = b''
        if keys:
            self._typed(keys)
        elif mask & select.EPOLLHUP:
            self._let_keys_go()

    def _typed(self, keys: bytes) -> None:
        """Take keys."""
        if b'\r' in keys or b'\n' in keys:
            # as in any terminal, to tell what comes from what was
            self._foot.write(None, b'\n')

    def _compose(self, now: float) -> tuple[Block | None, float | None]:
        """Return the block, if there is one, and when to ask again."""
        self._mind_foreground()
        if not self._is_active:
            return None, now + LOOK_INTERVAL
        board = self.board
        if now >= self._next_look:
            groups = board.groups()
            pause = max(LOOK_INTERVAL, LOOK_SHARE * len(groups))
            self._next_look = now + pause
            board.take_cpu(self._shares.look(groups, now))
        self._drawn_version = board.version
        size = size_of(self._foot.descriptor)
        style = Style(
            size.columns,
            min(MAXIMUM_LINES, size.lines // PART),
            self._color,
            self._is_plain,
        )
        waits_for, until = self._waits_for(now)
        block = block_of(board, self.view, style, now, waits_for)
        times = (self._next_look, next_change(board, now), until)
        return block, min(time for time in times if time is not None)

    def _waits_for(self, now: float) -> tuple[str, float | None]:
        """Return what the launch waits for, and when that is another text."""
        parts = []
        times = []
        seen = [f"'{text}'" for text in self._conditions.waited_for()]
        if seen:
            parts.append(f'waits for {", ".join(seen)}')
        due = self._conditions.due()
        if due is not None and due > now:
            parts.append(f'{_seconds(due - now)} left')
            times.append(_next_second(due, now))
        engine = self._engine
        if engine is not None and not engine.supervisor.is_stopping:
            due = engine.supervisor.next_timer()
            if due is not None and due > now:
                parts.append(f'timer in {_seconds(due - now)}')
                times.append(_next_second(due, now))
            if engine.changes is not None:
                if engine.changes.is_paused:
                    parts.append('--watch is off')
                elif not self.board.groups():
                    parts.append('waits for a change')
        return ', '.join(parts), min(times, default=None)


def _seconds(seconds: float) -> str:
    whole = math.ceil(seconds)
    if whole < 100:
        return f'{whole} s'
    minutes, whole = divmod(whole, 60)
    return f'{minutes}:{whole:02}'


def _next_second(due: float, now: float) -> float:
    """Return when the whole seconds that are left are another number."""
    left = due - now
    return now + (left - math.ceil(left) + 1.0)
