# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The panes, and what each key does."""

from asyncio import get_running_loop
from collections.abc import Mapping
from dataclasses import replace
import os
from typing import Any
from typing import ClassVar
from typing import Protocol

from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.control.protocol import ProtocolError
from colcon_yamllaunch.engine.state import ComponentState
from colcon_yamllaunch.engine.state import Part
from colcon_yamllaunch.engine.state import ProcessState
from colcon_yamllaunch.observers.line_filter import Filtering
from colcon_yamllaunch.observers.log_levels import FORMAT
from colcon_yamllaunch.observers.log_levels import Level
from colcon_yamllaunch.terminal.full_screen.dialogs import LeaveQuestion
from colcon_yamllaunch.terminal.full_screen.dialogs import Leaving
from colcon_yamllaunch.terminal.full_screen.dialogs import Reading
from colcon_yamllaunch.terminal.full_screen.inspection import in_full
from colcon_yamllaunch.terminal.full_screen.inspection import in_short
from colcon_yamllaunch.terminal.full_screen.launch_model import LaunchModel
from colcon_yamllaunch.terminal.full_screen.link import Done
from colcon_yamllaunch.terminal.full_screen.link import LaunchFeed
from colcon_yamllaunch.terminal.full_screen.link import Link
from colcon_yamllaunch.terminal.full_screen.output_pane import OutputPane
from colcon_yamllaunch.terminal.full_screen.part_list import PartList
from colcon_yamllaunch.terminal.full_screen.part_rows import label_of_key
from colcon_yamllaunch.terminal.full_screen.part_rows import part_rows
from colcon_yamllaunch.terminal.full_screen.part_rows import tree_rows
from colcon_yamllaunch.terminal.full_screen.prompt import Asked
from colcon_yamllaunch.terminal.full_screen.prompt import Prompt
from colcon_yamllaunch.terminal.full_screen.screen_lines import help_table
from colcon_yamllaunch.terminal.full_screen.screen_lines import keys_text
from colcon_yamllaunch.terminal.full_screen.screen_lines import title_text
from colcon_yamllaunch.terminal.keymap import cannot_be_typed_at
from colcon_yamllaunch.terminal.keymap import ON_ALL
from colcon_yamllaunch.terminal.keymap import ON_ONE
from colcon_yamllaunch.terminal.keymap import only_its_container_writes
from rich.text import Text
from textual.app import ComposeResult
from textual.binding import Binding
from textual.binding import BindingType
from textual.containers import Horizontal
from textual.containers import Vertical
from textual.events import Resize
from textual.screen import Screen
from textual.widgets import Static

_WHILE_ASKED = 'Enter keeps what is found  Esc goes back'
#: Seconds between two times that something is drawn.
DRAWN_EVERY = 0.1
#: Seconds for which an answer is shown.
SHOWN_FOR = 6.0
#: Columns below which there is one pane at a time.
NARROW = 60

#: Said where there is nothing to switch off.
NOT_WATCHED = 'no files are watched; that is --watch'

# what keys do while somebody types
_WHILE_TYPING = ('clear', 'switch')


class Terminal(Protocol):
    """What the screen can have done outside of itself."""

    @property
    def owns_launch(self) -> bool:
        """Whether the launch was started for this screen."""

    def attach(self, label: str) -> None:
        """Connect the terminal to a process, until that is over."""

    def page(self, path: str) -> None:
        """Show a file, until the user has seen it."""

    def interrupt(self) -> None:
        """Do to the launch what Ctrl-C does, if it was started for this."""


class LaunchScreen(Screen[None]):
    """A launch: its processes left, what they write right."""

    BINDINGS: ClassVar[list[BindingType]] = [
        *(
            # with priority, as others are for who had the focus when the key
            # came: several at once, as by a slow line, would miss the prompt
            Binding(key.keys, key.action, show=False, priority=True)
            for key in (*ON_ONE, *ON_ALL)
            if key.action
        ),
        *(
            Binding(digit, f'go({digit})', show=False, priority=True)
            for digit in '1234567890'
        ),
    ]
    AUTO_FOCUS = '#parts'

    def __init__(
        self,
        feed: LaunchFeed,
        terminal: Terminal,
    ) -> None:
        super().__init__()
        self._feed = feed
        self._terminal = terminal
        self.model = LaunchModel(feed.state, os.environ.get(FORMAT))
        self._parts = PartList()
        self._output = OutputPane(self.model.view)
        self._shows_plan = False
        self._is_output = False
        self._prompt = Prompt(self._take_typed, self._ask_no_more)
        self._search_before = ''
        self._is_due = False
        self._is_asked = False
        self._drawn = 0.0
        self._lines = {
            name: Static(id=name) for name in ('title', 'short', 'keys')
        }
        self._shown: dict[str, Text] = {}
        self._said: tuple[str, str] = ('', '')
        self._link: Link | None = None
        self._stops_to_leave = False
        self._is_closed = False

    def compose(self) -> ComposeResult:
        """Make the widgets."""
        yield self._lines['title']
        with Horizontal(id='panes'):
            with Vertical(id='left'):
                yield self._parts
                yield self._lines['short']
            yield self._output
        yield self._prompt
        yield self._lines['keys']

    def on_mount(self) -> None:
        """Begin to listen."""
        self.app.app_resume_signal.subscribe(self, self._resumed)
        self._link = Link(
            self._feed,
            get_running_loop(),
            self.model,
            self.changed,
            self._ended,
        )

    def on_unmount(self) -> None:
        """Leave the launch alone, too."""
        self.close()

    def check_action(
        self,
        action: str,
        parameters: tuple[object, ...],  # noqa: ARG002
    ) -> bool | None:
        """Tell whether a key means something now, or is typed."""
        return not self._prompt.asked or action in _WHILE_TYPING

    def close(self) -> None:
        """Leave the launch alone, and draw no more."""
        self._is_closed = True
        if self._link is not None:
            self._link.close()

    def on_resize(self, event: Resize) -> None:
        """Show one pane, or both."""
        self.set_class(event.size.width < NARROW, 'narrow')
        self.set_class(self._is_output, 'output')
        self.changed()

    def changed(self) -> None:
        """Draw what is new, soon."""
        if not self._is_due:
            self._is_due = True
            loop = get_running_loop()
            due = max(loop.time(), self._drawn + DRAWN_EVERY)
            loop.call_at(due, self._draw)

    def look_again(self) -> None:
        """Draw what was measured, and ask for what others have measured."""
        if self._link is not None:
            self._link.look_again()
        self.changed()

    # -- what a key does to one

    def action_stop(self) -> None:
        """Stop what the cursor is on."""
        self._act('stop')

    def action_restart(self) -> None:
        """Start it anew."""
        self._act('restart')

    def action_kill(self) -> None:
        """Kill it."""
        self._act('kill')

    def action_debug(self) -> None:
        """Start it under a debugger."""
        self._act('debug', 'starts under a debugger: a types at it')

    def action_attach(self) -> None:
        """Type at it."""
        part = self._part()
        if part is None:
            return
        process = part if isinstance(part, ProcessState) else None
        if process is None or not process.terminal:
            why = cannot_be_typed_at(
                part.label,
                is_process=process is not None,
                runs=process is not None and process.pid is not None,
            )
            self.say(why, 'red')
            return
        with self.app.suspend():
            self._terminal.attach(part.label)
        self.app.refresh()

    def action_log(self) -> None:
        """Show its log."""
        part = self._part()
        if part is None:
            return
        if part.log is None:
            self.say(f'{part.label} has no log of its own', 'red')
            return
        with self.app.suspend():
            self._terminal.page(part.log)
        self.app.refresh()

    def action_describe(self) -> None:
        """Show what it is."""
        part = self._part()
        if part is None or self._has_ended() or self._link is None:
            return
        label = part.label

        def show(error: str | None, answer: Mapping[str, Any]) -> None:
            try:
                text = in_full(self.model, label, answer.get('description'))
            except ProtocolError as e:
                self.say(error or str(e), 'red')
            else:
                self.app.push_screen(Reading(one_line(label), text))

        self._link.ask('describe', show, process=label)

    def action_mute(self) -> None:
        """Show no output of it, or do."""
        label = self._writer()
        if label is not None:
            muted = self._filtering.muted ^ {label}
            self._filter(replace(self._filtering, muted=muted))

    def action_only(self) -> None:
        """Show its output only, or all."""
        label = self._writer()
        if label is not None:
            only = frozenset((label,)) - self._alone()
            muted = self._filtering.muted - only
            self._filter(replace(self._filtering, only=only, muted=muted))

    def action_choose(self) -> None:
        """Show its output beside that of others, or not."""
        label = self._writer()
        if label is not None:
            only = self._filtering.only ^ {label}
            muted = self._filtering.muted - only
            self._filter(replace(self._filtering, only=only, muted=muted))

    # -- what a key does to all

    def action_search(self) -> None:
        """Ask for a text that lines have."""
        self._search_before = self._filtering.search
        self._prompt.ask('search', self._filtering.search)

    def action_find(self) -> None:
        """Ask for the name of a process."""
        self._prompt.ask('find')

    def action_level(self) -> None:
        """Show less, or all again."""
        levels = tuple(Level)
        place = levels.index(self._filtering.level) + 1
        level = levels[place % len(levels)]
        self._filter(replace(self._filtering, level=level))

    def action_times(self) -> None:
        """Show when each line came, or do not."""
        self._output.timestamps = not self._output.timestamps
        self.changed()

    def action_mute_all(self) -> None:
        """Show no output, or do."""
        labels = frozenset(p.label for p in self.model.state.processes)
        muted = self._filtering.muted
        muted = frozenset() if labels <= muted else labels
        self._filter(replace(self._filtering, muted=muted))

    def action_watch(self) -> None:
        """Have nothing follow from changes of files, or again."""
        state = self.model.state
        if self._has_ended() or self._link is None:
            return
        if state.watch is None:
            self.say(NOT_WATCHED, 'red')
            return
        action = 'resume' if state.watch_paused else 'pause'
        done = 'off: w switches it on' if action == 'pause' else 'on'
        told = self._told_of(f'--watch is {done}')
        self._link.ask('watch', told, action=action)

    def action_plan(self) -> None:
        """Show the plan, or the processes."""
        self._shows_plan = not self._shows_plan
        self.changed()

    def action_go(self, digit: int) -> None:
        """Go to one of the first processes."""
        label = label_of_key(self.model, str(digit))
        if label is not None:
            self._parts.go_to(label)

    def action_failed(self) -> None:
        """Go to the next that failed."""
        if not self._parts.next_of(self.model.failed):
            self.say('nothing has failed')

    def action_switch(self) -> None:
        """Go to the other pane."""
        self._is_output = not self._is_output
        self.set_class(self._is_output, 'output')
        self._ask_no_more()

    def action_clear(self) -> None:
        """Show all again, or ask no more."""
        if self._prompt.asked == 'search':
            self._filter(replace(self._filtering, search=self._search_before))
        elif not self._prompt.asked:
            self._filter(Filtering())
        self._ask_no_more()

    def action_errors(self) -> None:
        """Show what the last build that failed has said."""
        if not self.model.errors:
            self.say('no build has failed')
            return
        text = Text('\n'.join(map(one_line, self.model.errors)))
        self.app.push_screen(Reading('Errors', text))

    def action_help(self) -> None:
        """Show what the keys do."""
        owns = self._terminal.owns_launch
        last = 'stop the launch; once more hurries' if owns else 'leave'
        self.app.push_screen(Reading('Keys', help_table(last)))

    def action_leave(self) -> None:
        """Leave, and ask what is to become of the launch."""
        if self.model.ending or not self._terminal.owns_launch:
            self.app.exit()
        else:
            self.app.push_screen(LeaveQuestion(), self._leave)

    def interrupt(self) -> None:
        """Do what Ctrl-C does."""
        if self.model.ending or not self._terminal.owns_launch:
            self.app.exit()
        else:
            self._terminal.interrupt()
            self.say('stopping; Ctrl-C again to hurry')

    def say(self, text: str, style: str = '') -> None:
        """Show a line for a moment."""
        said = one_line(text), style
        self._said = said

        def forget() -> None:
            if self._said is said:
                self._said = ('', '')
                self.changed()

        self.set_timer(SHOWN_FOR, forget)
        self.changed()

    def on_part_list_moved(self) -> None:
        """Show what the cursor is on."""
        self.changed()

    def on_descendant_focus(self) -> None:
        """Tell what keys mean to who has them now."""
        self.changed()

    def on_output_pane_followed(self) -> None:
        """Show whether the end is in sight."""
        self.changed()

    @property
    def _filtering(self) -> Filtering:
        return self.model.view.filtering

    def _filter(self, filtering: Filtering) -> None:
        self.model.view.choose(filtering)
        if self._link is not None:
            self._link.choose()
        self.changed()

    def _alone(self) -> frozenset[str]:
        """Return the process that alone is shown, if one is."""
        only = self._filtering.only
        return only if len(only) == 1 else frozenset()

    def _take_typed(self, asked: Asked, text: str) -> None:
        if asked == 'search' and text != self._filtering.search:
            self._filter(replace(self._filtering, search=text))
        elif asked == 'find' and text:
            self._parts.find(text)

    def _part(self) -> Part | None:
        """Return what the cursor is on; say what to do if it is nothing."""
        part = self.model.part(self._parts.label)
        if part is None:
            self.say('go to a process or component first', 'red')
        return part

    def _writer(self) -> str | None:
        """Return the process that the cursor is on, likewise."""
        part = self._part()
        if isinstance(part, ComponentState):
            self.say(only_its_container_writes(part.label), 'red')
            return None
        return None if part is None else part.label

    def _has_ended(self) -> bool:
        """Tell whether nothing can be done any more, and say so."""
        if self.model.ending:
            self.say(self.model.ending, 'red')
        return bool(self.model.ending)

    def _act(self, name: str, done: str = '') -> None:
        part = self._part()
        if part is None or self._has_ended() or self._link is None:
            return
        label = part.label
        told = self._told_of(f'{label}: {done or name + " requested"}')
        self._link.ask(name, told, process=label)

    def _told_of(self, done: str) -> Done:
        """Return what says that something was done, or why it was not."""

        def told(error: str | None, _: Mapping[str, Any]) -> None:
            self.say(done if error is None else error, 'red' * bool(error))

        return told

    def _leave(self, answer: Leaving | None) -> None:
        if answer == 'leave' or (answer == 'stop' and self.model.ending):
            self.app.exit()
        elif answer == 'stop':
            self._stops_to_leave = True
            self._terminal.interrupt()
            self.say('stopping, then leaving; Ctrl-C to hurry')

    def _ask_no_more(self) -> None:
        self._prompt.ask_no_more()
        self.set_focus(self._output if self._is_output else self._parts)
        self.changed()

    def _ended(self, reason: str) -> None:
        if not reason and self.model.exit_code is None:
            reason = 'the launcher is gone; colcon launch --status shows rests'
        self.model.end(reason)
        self._said = ('', '')
        self.changed()
        if self._stops_to_leave:
            self.app.exit()
        elif isinstance(self.app.screen, LeaveQuestion):
            # it has no sense any more
            self.app.screen.dismiss('stay')

    def _draw(self) -> None:
        self._is_due = False
        self._drawn = get_running_loop().time()
        if self._is_closed:
            return
        rows = tree_rows if self._shows_plan else part_rows
        self._parts.show(rows(self.model), self._filtering)
        self._output.changed()
        follows = self._output.follows
        self._put('title', title_text(self.model, follows=follows))
        self._put('keys', self._last_line())
        label = self._parts.label
        shown = Text()
        if label is not None:
            width = self._lines['short'].size.width
            shown = in_short(self.model, label, width)
        self._put('short', shown)

    def _resumed(self, _: object) -> None:
        # the terminal has been somebody else's
        get_running_loop().call_later(DRAWN_EVERY, self.app.refresh)

    def _put(self, place: str, text: Text) -> None:
        # all else stays where it is, which need not be found out anew
        if text != self._shown.get(place):
            self._shown[place] = text
            self._lines[place].update(text, layout=False)

    def _last_line(self) -> Text:
        said, style = self._said
        if not said and self.model.ending:
            said, style = f'{self.model.ending}; q leaves', 'bold'
        if said:
            return Text(said, style, no_wrap=True, overflow='ellipsis')
        if self._prompt.display:
            # the keys are text for the time being
            return Text(_WHILE_ASKED, 'dim', no_wrap=True)
        width = self.size.width
        return keys_text(
            width,
            is_narrow=width < NARROW,
            left_out=self._meaningless(),
        )

    def _meaningless(self) -> set[str]:
        """Return the actions that can do nothing now."""
        found = set()
        if self.model.state.watch is None:
            found.add('watch')
        if not self.model.errors:
            found.add('errors')
        match self.model.part(self._parts.label):
            case ComponentState():
                found |= {'kill', 'attach', 'mute', 'only', 'debug'}
            case ProcessState(terminal=False):
                found.add('attach')
        return found
