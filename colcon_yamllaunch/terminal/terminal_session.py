# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The view of a launch in the terminal that it was started in.

It has the status block below the output, and the keyboard. While the launch is
suspended or in the background, the terminal belongs to another job.
"""

from collections.abc import Callable, Iterable, Sequence
import math
import os
from pathlib import Path
import signal
import sys
import time
from typing import Any, TYPE_CHECKING

from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.engine import commands, events
from colcon_yamllaunch.engine.channels import size_of
from colcon_yamllaunch.engine.engine import Engine
from colcon_yamllaunch.engine.exit_conditions import ExitConditions
from colcon_yamllaunch.engine.guard_link import GuardLink
from colcon_yamllaunch.engine.state import LaunchState
from colcon_yamllaunch.observers.log_levels import FORMAT
from colcon_yamllaunch.observers.presentation import Display
from colcon_yamllaunch.observers.screen import Screen
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.terminal import keys, status_block
from colcon_yamllaunch.terminal.attachment import KeysAttachment
from colcon_yamllaunch.terminal.keyboard import (
    ESCAPE_DELAY,
    is_in_foreground,
    WatchedKeyboard,
)
from colcon_yamllaunch.terminal.keymap import (
    cannot_be_typed_at,
    FOR_ALL,
    FOR_ONE,
)
from colcon_yamllaunch.terminal.line_filter import LineFilter, time_stamp
from colcon_yamllaunch.terminal.status_model import (
    CpuShares,
    description_lines,
    StatusModel,
)
from colcon_yamllaunch.terminal.status_writer import StatusWriter

if TYPE_CHECKING:
    from colcon_yamllaunch.terminal.pager import PagedOutput

#: Seconds between two measurements of CPU shares, and those for each process
#: if there are many.
LOOK_INTERVAL = 2.0
LOOK_SHARE = 0.05
#: Seconds between two checks whether the launch is in the foreground again.
FOREGROUND_INTERVAL = 0.5
#: The share of the lines of a terminal that the block takes at most, as one
#: divided by this.
BLOCK_DIVISOR = 3
#: Seconds between two checks whether a process reads lines or keys.
MODES_INTERVAL = 0.25
#: Bytes that are shown of a line that may still change.
_SEEN = 4096
# None for a key that sends no command
_COMMANDS = {key.name: key.command for key in (*FOR_ONE, *FOR_ALL)}


class TerminalSession:
    """
    The terminal of a launch, as long as that is in its foreground.

    :param state: The state of the launch
    :param display: The terminal
    :param screen: Shows what happens, in this terminal
    :param show: Shows an event, by `screen`
    :param guard: Restores the terminal if the launcher is killed
    :param conditions: What the launch waits for to end by itself
    :param clock: Returns seconds that never go back
    :param attach: The label of the process that has the keyboard at first
    :param has_keys: Whether standard input is the same terminal
    """

    def __init__(
        self,
        state: LaunchState,
        display: Display,
        screen: Screen,
        show: events.Listener,
        guard: GuardLink,
        conditions: ExitConditions,
        clock: Callable[[], float],
        attach: str | None,
        *,
        has_keys: bool,
    ) -> None:
        assert isinstance(display.writer, StatusWriter)
        #: What the block shows.
        self.model = StatusModel(state)
        self._writer = display.writer
        self._descriptor = display.writer.descriptor
        self._screen = screen
        self._show = show
        self._display = display
        self._filter = LineFilter(
            color=display.color,
            is_ascii=display.is_ascii,
            form_of=self._form_of,
        )
        self._keys = keys.Keys(self.model)
        self._attachment = KeysAttachment(
            self._keys, screen, attach if has_keys else None
        )
        # None if a process gets the keys without this session
        self._keyboard: WatchedKeyboard | None = None
        if has_keys or attach is None:
            # without keys, only switch off the echo, which would overwrite the
            # block
            descriptor = sys.stdin.fileno() if has_keys else self._descriptor
            self._keyboard = WatchedKeyboard(
                descriptor, self._typed, takes_keys=has_keys
            )
        # when a lone Esc counts as a key
        self._escape_due: float | None = None
        # while a pager has the terminal
        self._paged: PagedOutput | None = None
        # the time of the held event that is being shown after the pager
        self._time: float | None = None
        self._guard = guard
        self._conditions = conditions
        self._clock = clock
        self._shares = CpuShares()
        self._next_look = clock() + LOOK_INTERVAL
        self._drawn_version = (-1, 0)
        self._is_active = False
        # whether the cursor is in the block
        self._is_typing = False

    def connect(self, engine: Engine) -> None:
        """Use an engine, before it runs."""
        self._engine: Engine = engine
        self._attachment.connect(engine)
        if self._keyboard is not None:
            self._keyboard.connect(engine.loop)
        engine.when_suspended.append(self._suspend)
        engine.when_resized.append(self._writer.resized)
        self._writer.begin(self._compose)

    def close(self) -> None:
        """Restore the terminal."""
        self._attachment.close()
        if self._paged is not None:
            self._engine.loop.remove_child(self._paged.pager.pid)
            self._paged.pager.end()
            self._end_pager()
        self._end()

    def handle(self, event: events.Event) -> None:
        """Show an event above the block."""
        if self._paged is not None:
            self._paged.hold(event)
            return
        # most events are output
        if isinstance(event, events.Output):
            if self._attachment.shows(event.process.label):
                return
            for output in self._filter.shown(event):
                self._show(output)
            if not self._filter.is_changing:
                return
            if self._is_active:
                self._writer.touch()
            else:
                # without a block, nothing that may still change is shown
                self._show_all(self._filter.end())
            return
        if isinstance(event, events.ShuttingDown):
            # a note would hide the countdown
            self._keys.show_note('')
        self._attachment.before(event)
        if self.model.version != self._drawn_version:
            self._writer.touch()
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
        if self._paged is not None:
            return
        self._end()
        if not is_suspended:
            self._writer.begin(self._compose)

    def _follow_foreground(self) -> None:
        """Use the terminal while the launch is in its foreground."""
        if is_in_foreground(self._descriptor) == self._is_active:
            return
        self._is_active = not self._is_active
        keyboard, modes = self._keyboard, None
        if keyboard is not None and self._is_active:
            modes = keyboard.watch(keeps_early=self._attachment.is_wanted)
        elif keyboard is not None:
            keyboard.release()
        if self._is_active:
            self._guard.terminal(self._descriptor, modes)

    def _end(self) -> None:
        self._show_all(self._filter.end())
        self._is_active = False
        self._writer.leave()
        if self._keyboard is not None:
            self._keyboard.release()
        self._guard.no_terminal()

    # keys

    def _typed(self, typed: bytes) -> None:
        self._attachment.read_modes()
        self._do(self._keys.feed(typed))

    def _do(self, presses: Iterable[keys.KeyPress | keys.Typed]) -> None:
        """Carry out keys that were pressed."""
        for press in presses:
            if isinstance(press, keys.Typed):
                self._attachment.type(press.keys)
            else:
                self._press(press.name, press.label)
        filtering = self._keys.filtering
        if filtering != self._filter.filtering:
            self._show_all(self._filter.settle())
            self._filter.filtering = filtering
            self._screen.stamp = self._stamp if filtering.times else None
        self._escape_due = None
        if self._keys.is_waiting:
            self._escape_due = self._clock() + ESCAPE_DELAY
        self._writer.touch(at_once=True)

    def _press(self, name: str, label: str | None) -> None:
        """Send the command of a key, or call its method."""
        command_of = _COMMANDS.get(name)
        state = self.model.state
        if command_of is None:
            getattr(self, f'key_{name}')(label)
            return
        member = self.model.member(label)
        if (
            name in ('stop', 'kill')
            and member
            and member.condition in keys.DOWN
        ):
            self._keys.show_note(f'{label} does not run')

        command = command_of(state if label is None else label)

        def reply(response: Any) -> None:
            if isinstance(response, commands.Refused):
                self._keys.show_note(response.error)
            elif after := getattr(self, f'after_{name}', None):
                after(command, response)

        self._engine.ask(command, reply)

    def after_debug(self, command: commands.Debug, _: object) -> None:
        """Type at a process as soon as its debugger runs."""
        self._attachment.await_start(command.member)

    def after_describe(self, _: object, response: commands.Described) -> None:
        """Show what a process or component is."""
        self._show_all(self._filter.settle())
        self._screen.show_table(description_lines(response.description))

    def key_attach(self, label: str) -> None:
        """Type at a process."""
        member = self.model.member(label)
        if member is not None and not self._attachment.attach(label):
            self._keys.show_note(cannot_be_typed_at(member))

    def key_detach(self, label: str) -> None:
        """Go back from the process that is typed at."""
        self._attachment.detach(label)

    def key_log(self, label: str) -> None:
        """Show the log of a process in the pager."""
        member = self.model.member(label)
        log = None if member is None else self.model.state.log_of(member)
        if log is None:
            self._keys.show_note(f'{label} has no log')
        else:
            self._page(log)

    def key_help(self, _: None) -> None:
        """Show all keys in place of the block."""
        self._overlay(keys.help_lines)

    def key_errors(self, _: None) -> None:
        """Show the errors of the last build that failed likewise."""
        self._overlay(self._error_lines)

    def key_quit(self, _: None) -> None:
        """Stop the launch as Ctrl-C does."""
        os.kill(os.getpid(), signal.SIGINT)

    def key_break(self, _: None) -> None:
        """End a line of the output."""
        self._show_all(self._filter.settle())
        self._writer.write(None, b'\n')

    def _overlay(self, lines: Callable[[int], Sequence[str]]) -> None:
        """
        Show lines in place of the block.

        :param lines: Returns them, by the width of the terminal
        """
        size = size_of(self._descriptor)
        # one line is for the output, and one for the hint
        self._keys.show(lines(size.columns), size.lines - 2)

    def _error_lines(self, columns: int) -> Sequence[str]:
        # imported late, as few users look at errors
        import textwrap

        width = max(2, columns) - 1
        lines = (
            one_line(line.expandtabs()) for line in self.model.state.errors
        )
        return [part for line in lines for part in textwrap.wrap(line, width)]

    # the pager

    def _page(self, log: str) -> None:
        """Show the log of a process in the pager, which gets the terminal."""
        # imported late, as few users look at logs
        from colcon_yamllaunch.terminal.pager import PagedOutput, Pager

        self._end()
        try:
            pager = Pager(Path(log), self._descriptor, os.environ)
        except (OSError, ValueError) as error:
            reason = error.strerror if isinstance(error, OSError) else error
            self._keys.show_note(f'there is no pager by $PAGER: {reason}')
            self._writer.begin(self._compose)
            return
        self._paged = PagedOutput(pager)
        # no shell is there to go on with it after Ctrl-Z
        self._engine.loop.add_child(
            pager.pid, lambda _: self._end_pager(), pager.quit
        )

    def _end_pager(self) -> None:
        paged, self._paged = self._paged, None
        assert paged is not None
        paged.pager.reclaim()
        self._writer.begin(self._compose)
        if paged.lost:
            self._screen.say(
                f'{paged.lost} lines were not shown meanwhile; the logs have '
                'them'
            )
        for self._time, event in paged.held():
            self.handle(event)
        self._time = None

    def _stamp(self) -> bytes:
        """Return the time in front of a line."""
        now = time.time() if self._time is None else self._time
        return time_stamp(now).encode()

    def _form_of(self, process: Process) -> str | None:
        variables = dict(process.environment)
        return variables.get(FORMAT, self._display.environment.get(FORMAT))

    def _compose(
        self, now: float
    ) -> tuple[status_block.StatusBlock | None, float | None]:
        """Return the block, if there is one, and when to ask again."""
        self._follow_foreground()
        if not self._is_active:
            return None, now + FOREGROUND_INTERVAL
        if self._escape_due is not None and now >= self._escape_due:
            self._do(self._keys.settle())
        model, state = self.model, self.model.state
        if now >= self._next_look:
            groups = state.groups()
            pause = max(LOOK_INTERVAL, LOOK_SHARE * len(groups))
            self._next_look = now + pause
            shares = self._shares.measure(groups, now)
            model.measure({**self._engine.cpu_shares(), **shares})
        self._drawn_version = model.version
        size = size_of(self._descriptor)
        style = status_block.Style(
            size.columns,
            min(status_block.MAXIMUM_LINES, size.lines // BLOCK_DIVISOR),
            self._display.color,
            self._display.is_ascii,
            size.lines,
        )
        pending, until = self._pending(now)
        view = status_block.View(live=self._live())
        next_modes = None
        if self._keyboard is not None and self._keyboard.has_keys:
            if self._keys.attached is not None:
                # nothing reports that the process has changed its modes
                self._attachment.read_modes()
                next_modes = now + MODES_INTERVAL
            view = self._keys.view(view.live)
        block = status_block.block_of(model, view, style, now, pending)
        is_typing = block.cursor is not None
        if is_typing != self._is_typing:
            self._is_typing = is_typing
            self._guard.typing(is_typing)
        times = (
            self._next_look,
            status_block.next_change(state, now),
            until,
            self._escape_due,
            next_modes,
        )
        return block, min(time for time in times if time is not None)

    def _pending(self, now: float) -> tuple[str, float | None]:
        """Return what the launch waits for, and until when that is right."""
        state = self.model.state
        texts = []
        times = []
        seen = [f"'{text}'" for text in self._conditions.waited_for()]
        if seen:
            texts.append(f'waits for {", ".join(seen)}')
        due = self._conditions.due()
        if due is not None and due > now:
            texts.append(f'{_seconds(due - now)} left')
            times.append(status_block.next_second(due, now))
        if not state.stopping:
            due = self._engine.supervisor.next_timer()
            if due is not None and due > now:
                texts.append(f'timer in {_seconds(due - now)}')
                times.append(status_block.next_second(due, now))
            if state.watch_paused:
                texts.append('--watch is off')
            elif state.watch is not None and not any(
                process.pid for process in state.processes
            ):
                texts.append('waits for a change')
        return ', '.join(texts), min(times, default=None)

    def _live(self) -> tuple[str, ...]:
        """Return the lines of output that may still change."""
        return tuple(
            self._screen.rendered(output.process, output.data[:_SEEN])
            .decode(errors='replace')
            .rstrip('\n')
            .expandtabs()
            for output in self._filter.live
        )


def _seconds(seconds: float) -> str:
    whole = math.ceil(seconds)
    if whole < 100:
        return f'{whole} s'
    minutes, whole = divmod(whole, 60)
    return f'{minutes}:{whole:02}'
