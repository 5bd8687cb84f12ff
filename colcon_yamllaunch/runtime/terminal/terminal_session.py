# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What a launch has of the terminal that it was started in.

That is the status block below the output, and the keyboard. Both are somebody
else's while the launch is suspended or in the background.
"""

from collections import deque
from collections.abc import Callable
from collections.abc import Iterable
from collections.abc import Mapping
import math
import os
from pathlib import Path
import select
import signal
import termios
import time
from typing import TYPE_CHECKING

from colcon_yamllaunch.language.plan.plan import Entry
from colcon_yamllaunch.language.plan.plan import Process
from colcon_yamllaunch.runtime.acts.acts import Acts
from colcon_yamllaunch.runtime.core import events
from colcon_yamllaunch.runtime.core.tasks import RefusedError
from colcon_yamllaunch.runtime.course.engine import Engine
from colcon_yamllaunch.runtime.course.exit_conditions import ExitConditions
from colcon_yamllaunch.runtime.keys.key_decoder import ESCAPE_DELAY
from colcon_yamllaunch.runtime.keys.keyboard import is_in_foreground
from colcon_yamllaunch.runtime.keys.keyboard import Keyboard
from colcon_yamllaunch.runtime.keys.keys import Act
from colcon_yamllaunch.runtime.keys.keys import Command
from colcon_yamllaunch.runtime.keys.keys import DOWN
from colcon_yamllaunch.runtime.keys.keys import help_lines
from colcon_yamllaunch.runtime.keys.keys import Keys
from colcon_yamllaunch.runtime.keys.keys import Typed
from colcon_yamllaunch.runtime.screen.line_filter import LineFilter
from colcon_yamllaunch.runtime.screen.log_levels import FORMAT
from colcon_yamllaunch.runtime.screen.screen import Screen
from colcon_yamllaunch.runtime.status.board import Board
from colcon_yamllaunch.runtime.status.cpu_shares import CpuShares
from colcon_yamllaunch.runtime.status.foot import Foot
from colcon_yamllaunch.runtime.status.status_block import Block
from colcon_yamllaunch.runtime.status.status_block import block_of
from colcon_yamllaunch.runtime.status.status_block import MAXIMUM_LINES
from colcon_yamllaunch.runtime.status.status_block import next_change
from colcon_yamllaunch.runtime.status.status_block import next_second
from colcon_yamllaunch.runtime.status.status_block import Style
from colcon_yamllaunch.runtime.status.status_block import View
from colcon_yamllaunch.runtime.stopping.guard_link import GuardLink
from colcon_yamllaunch.runtime.streams.channels import size_of
from colcon_yamllaunch.runtime.terminal.attachment import Attachment

if TYPE_CHECKING:
    from colcon_yamllaunch.runtime.terminal.pager import Pager

#: Seconds between two looks at what takes much of a processor, and those for
#: each process where they are many: a look takes some 30 µs for each.
LOOK_INTERVAL = 2.0
LOOK_SHARE = 0.05
#: Seconds between two looks at whether the terminal is ours again.
FOREGROUND_INTERVAL = 0.5
#: The part of the lines of a terminal that the block takes at most, as one
#: divided by this.
PART = 3
#: Seconds between two looks at whether a process takes lines or keys.
MODES_INTERVAL = 0.25
#: Bytes of output that are kept while a pager has the terminal, and those
#: that a piece of it counts for beside its own.
KEPT = 256 * 1024
PIECE = 256
#: Bytes of a line that may change that are looked at.
_SEEN = 4096


class TerminalSession:
    """
    Has the terminal of a launch, as long as that is in its foreground.

    :param entries: Those of the plan
    :param foot: Writes to the terminal
    :param screen: Shows what happens, by `foot`
    :param guard: Is told of the terminal
    :param keyboard: The same terminal, None if somebody else has its keys
    :param color: Whether the block is coloured
    :param is_plain: Whether the terminal has nothing but ASCII
    :param environment: The environment for all processes
    :param conditions: What the launch waits for to end by itself
    :param clock: Returns seconds that never go back
    :param attach: The label of the process that has the keyboard at first
    """

    def __init__(
        self,
        entries: Iterable[Entry],
        foot: Foot,
        screen: Screen,
        guard: GuardLink,
        keyboard: Keyboard | None,
        *,
        color: bool,
        is_plain: bool,
        environment: Mapping[str, str],
        conditions: ExitConditions,
        clock: Callable[[], float],
        attach: str | None = None,
    ) -> None:
        #: What the block tells.
        self.board = Board(entries, clock)
        self._foot = foot
        self._screen = screen
        self._environment = environment
        self._filter = LineFilter(
            color=color, is_ascii=is_plain, form_of=self._form_of
        )
        self._keys = Keys(self.board, self._names_of)
        self._attachment = Attachment(self._keys, screen, attach)
        # when an Esc has been a key
        self._escape_due: float | None = None
        # what has the terminal now, and what is shown after that
        self._pager: Pager | None = None
        self._held: deque[tuple[float, events.Event]] = deque()
        self._held_size = 0
        self._lost = 0
        # when that came, while it is shown
        self._time: float | None = None
        self._guard = guard
        self._keyboard = keyboard
        self._color = color
        self._is_plain = is_plain
        self._conditions = conditions
        self._clock = clock
        self._engine: Engine | None = None
        self._acts: Acts | None = None
        self._show: events.Listener = screen.handle
        self._shares = CpuShares()
        self._next_look = clock() + LOOK_INTERVAL
        self._drawn_version = 0
        self._is_active = False
        self._is_grabbed = False
        self._has_had_keys = False
        # whether the cursor is in the block
        self._is_typing = False

    def showing(self, show: events.Listener) -> events.Listener:
        """
        Return who shows what happens.

        :param show: Shows it above the block
        """
        self._show = show
        return self._handle

    def connect(self, engine: Engine, acts: Acts) -> None:
        """
        Use an engine, before it runs.

        :param acts: What is done with its processes
        """
        self._engine = engine
        self._acts = acts
        self._attachment.connect(engine)
        engine.when_suspended.append(self._suspend)
        engine.when_resized.append(self._foot.resized)
        self._foot.begin(self._compose)

    def close(self) -> None:
        """Give the terminal back as it was."""
        self._attachment.close()
        pager, engine = self._pager, self._engine
        if pager is not None and engine is not None:
            del engine.helpers[pager.pid]
            pager.end()
            self._end_pager()
        self._end()
        self._engine = None

    def _handle(self, event: events.Event) -> None:
        if self._pager is not None:
            self._hold(event)
            return
        # most of what happens is output
        if isinstance(event, events.Output):
            if self._attachment.shows(event.process.label):
                return
            for output in self._filter.take(event):
                self._show(output)
            if not self._filter.is_changing:
                return
            if self._is_active:
                self._foot.touch()
            else:
                # there is no place for what may still change
                self._show_all(self._filter.end())
            return
        if isinstance(event, events.ShuttingDown):
            # what was told last is in the way now
            self._keys.tell('')
        self._attachment.before(event)
        self.board.handle(event)
        if self.board.version != self._drawn_version:
            self._foot.touch()
        if self._is_active and isinstance(event, events.StillRunning):
            # the block counts down
            return
        if isinstance(event, events.Exited):
            self._show_all(self._filter.end(event.process.label))
        self._show_all(self._filter.settle())
        self._show(event)
        self._attachment.after(event)

    def _show_all(self, outputs: Iterable[events.Output]) -> None:
        for output in outputs:
            self._show(output)

    def _suspend(self, is_suspended: bool) -> None:
        if self._pager is not None:
            return
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
                self._drop_early_keys(keyboard)
                engine.watches.add(keyboard.descriptor, self._readable)
        self._guard.terminal(self._foot.descriptor, before)

    def _drop_early_keys(self, keyboard: Keyboard) -> None:
        """Forget what was typed before anybody could know its meaning."""
        if not self._has_had_keys and not self._attachment.is_wanted:
            termios.tcflush(keyboard.descriptor, termios.TCIFLUSH)
        self._has_had_keys = True

    def _end(self) -> None:
        self._show_all(self._filter.end())
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
            keys = self._keyboard.keys()
        except OSError:
            keys = b''
        if keys:
            self._attachment.mind_modes()
            self._do(self._keys.feed(keys))
        elif mask & select.EPOLLHUP:
            self._let_keys_go()

    def _do(self, commands: Iterable[Command]) -> None:
        """Do what keys have been pressed for."""
        for command in commands:
            match command:
                case Typed():
                    self._attachment.type(command.keys)
                case Act():
                    self._act(command)
                case 'watch':
                    self._switch_watch()
                case 'help':
                    size = size_of(self._foot.descriptor)
                    self._tell(help_lines(size.columns))
                case 'quit':
                    os.kill(os.getpid(), signal.SIGINT)
                case 'break':
                    self._show_all(self._filter.settle())
                    self._foot.write(None, b'\n')
        filtering = self._keys.filtering
        if filtering != self._filter.filtering:
            self._show_all(self._filter.settle())
            self._filter.filtering = filtering
            self._screen.stamp = self._stamp if filtering.times else None
        self._escape_due = None
        if self._keys.is_waiting:
            self._escape_due = self._clock() + ESCAPE_DELAY
        self._foot.touch(at_once=True)

    def _act(self, act: Act) -> None:
        assert self._acts is not None
        label = act.label
        row = self.board.row(label)
        if act.action in ('stop', 'kill') and row and row.phase in DOWN:
            self._keys.tell(f'{label} does not run')
        try:
            match act.action:
                case 'stop':
                    self._acts.stop(label)
                case 'restart':
                    self._acts.restart(label)
                case 'kill':
                    self._acts.kill(label)
                case 'debug':
                    self._acts.debug(label)
                    self._attachment.await_start(label)
                case 'attach':
                    if not self._attachment.attach(label):
                        self._keys.tell(_no_keyboard(self.board, label))
                case 'detach':
                    self._attachment.detached(label)
                case 'log':
                    self._page(label, self._acts.describe(label).log)
                case 'describe':
                    self._describe(label)
        except RefusedError as error:
            self._keys.tell(str(error))

    def _tell(self, lines: Iterable[str]) -> None:
        self._show_all(self._filter.settle())
        self._screen.show_table(lines)

    def _describe(self, label: str) -> None:
        # few are asked for it
        from colcon_yamllaunch.runtime.acts.description_lines import (
            description_lines,
        )

        assert self._acts is not None
        self._tell(description_lines(self._acts.describe(label)))

    def _switch_watch(self) -> None:
        assert self._acts is not None
        try:
            self._acts.watch(paused=not self._acts.is_watch_paused)
        except RefusedError as error:
            self._keys.tell(str(error))

    # the pager

    def _page(self, label: str, log: str | None) -> None:
        """Leave the terminal to the pager, with the log of a process."""
        if log is None or self._engine is None:
            self._keys.tell(f'{label} has no log')
            return
        # few are looked at
        from colcon_yamllaunch.runtime.terminal.pager import Pager

        self._end()
        try:
            self._pager = Pager(Path(log), self._foot.descriptor, os.environ)
        except (OSError, ValueError) as error:
            reason = error.strerror if isinstance(error, OSError) else error
            self._keys.tell(f'there is no pager by $PAGER: {reason}')
            self._foot.begin(self._compose)
            return
        self._engine.helpers[self._pager.pid] = self._mind_pager

    def _mind_pager(self, has_ended: bool) -> None:
        if self._pager is None:
            return
        if has_ended:
            self._end_pager()
        else:
            # Ctrl-Z; no shell is there to go on with it
            self._pager.quit()

    def _end_pager(self) -> None:
        assert self._pager is not None
        self._pager.take_back()
        self._pager = None
        self._foot.begin(self._compose)
        if self._lost:
            self._screen.say(
                f'{self._lost} lines were not shown meanwhile; the logs have '
                'them'
            )
        self._lost = self._held_size = 0
        while self._held:
            self._time, event = self._held.popleft()
            self._handle(event)
        self._time = None

    def _hold(self, event: events.Event) -> None:
        """Keep what is to be shown after the pager, the output in part."""
        self._held.append((time.time(), event))
        if isinstance(event, events.Output):
            self._held_size += PIECE + len(event.data)
        while self._held_size > KEPT:
            self._drop_oldest()

    def _drop_oldest(self) -> None:
        for index, (_, event) in enumerate(self._held):
            if isinstance(event, events.Output):
                del self._held[index]
                self._held_size -= PIECE + len(event.data)
                self._lost += event.data.count(b'\n')
                return

    def _stamp(self) -> bytes:
        """Return the time in front of a line."""
        now = time.time() if self._time is None else self._time
        clock = time.strftime('%H:%M:%S', time.localtime(now))
        return f'{clock}.{int(now * 1000) % 1000:03} '.encode()

    def _form_of(self, process: Process) -> str | None:
        variables = dict(process.environment)
        return variables.get(FORMAT, self._environment.get(FORMAT))

    def _names_of(self, label: str) -> Iterable[str]:
        """Return the names that `--status` lists, and others that it takes."""
        # few ask
        from colcon_yamllaunch.runtime.clients.process_names import (
            ProcessNames,
        )

        engine = self._engine
        if engine is None:
            return ()
        for task in engine.supervisor.tasks:
            if task.process.label == label:
                return tuple(ProcessNames.of_plan(task.process))
        composition = engine.composition
        for part in () if composition is None else composition.tasks:
            if part.label == label:
                node = part.full_name or part.component.node_name
                plugin = part.component.plugin
                return tuple(ProcessNames(label, label, plugin, node))
        return ()

    def _compose(self, now: float) -> tuple[Block | None, float | None]:
        """Return the block, if there is one, and when to ask again."""
        self._mind_foreground()
        if not self._is_active:
            return None, now + FOREGROUND_INTERVAL
        if self._escape_due is not None and now >= self._escape_due:
            self._do(self._keys.settle())
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
            size.lines,
        )
        waits_for, until = self._waits_for(now)
        view = View(live=self._live())
        keyboard = self._keyboard
        next_modes = None
        if self._is_grabbed and keyboard is not None and keyboard.takes_keys:
            if self._keys.attached is not None:
                # the process may have changed them without a word
                self._attachment.mind_modes()
                next_modes = now + MODES_INTERVAL
            changes = None if self._engine is None else self._engine.changes
            self._keys.can_watch = changes is not None
            view = self._keys.view(view.live)
        block = block_of(board, view, style, now, waits_for)
        is_typing = block.cursor is not None
        if is_typing != self._is_typing:
            self._is_typing = is_typing
            self._guard.typing(is_typing)
        times = (
            self._next_look,
            next_change(board, now),
            until,
            self._escape_due,
            next_modes,
        )
        return block, min(time for time in times if time is not None)

    def _live(self) -> tuple[str, ...]:
        """Return the lines of output that may still change."""
        return tuple(
            self._screen.rendered(output.process, output.data[:_SEEN])
            .decode(errors='replace')
            .rstrip('\n')
            .expandtabs()
            for output in self._filter.live
        )

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
            times.append(next_second(due, now))
        engine = self._engine
        if engine is not None and not engine.supervisor.is_stopping:
            due = engine.supervisor.next_timer()
            if due is not None and due > now:
                parts.append(f'timer in {_seconds(due - now)}')
                times.append(next_second(due, now))
            if engine.changes is not None:
                if engine.changes.is_paused:
                    parts.append('--watch is off')
                elif not self.board.groups():
                    parts.append('waits for a change')
        return ', '.join(parts), min(times, default=None)


def _no_keyboard(board: Board, label: str) -> str:
    row = board.row(label)
    if row is None or not row.group:
        return f'{label} does not run'
    return f'{label} has no terminal; emulate_tty or --tty gives it one'


def _seconds(seconds: float) -> str:
    whole = math.ceil(seconds)
    if whole < 100:
        return f'{whole} s'
    minutes, whole = divmod(whole, 60)
    return f'{minutes}:{whole:02}'
