# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The full screen: the panes, and what each key does."""

from asyncio import get_running_loop
from dataclasses import replace
import os
from typing import Any
from typing import ClassVar
from typing import Protocol

from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.control.client import RunningLaunch
from colcon_yamllaunch.engine.commands import Command
from colcon_yamllaunch.engine.commands import Described
from colcon_yamllaunch.engine.commands import PartCommand
from colcon_yamllaunch.engine.commands import Refused
from colcon_yamllaunch.engine.commands import Watch
from colcon_yamllaunch.engine.state import ComponentState
from colcon_yamllaunch.engine.state import Part
from colcon_yamllaunch.observers.log_levels import FORMAT
from colcon_yamllaunch.terminal.full_screen.launch_model import LaunchModel
from colcon_yamllaunch.terminal.full_screen.screen_texts import help_table
from colcon_yamllaunch.terminal.full_screen.screen_texts import in_full
from colcon_yamllaunch.terminal.full_screen.screen_texts import in_short
from colcon_yamllaunch.terminal.full_screen.screen_texts import keys_text
from colcon_yamllaunch.terminal.full_screen.screen_texts import title_text
from colcon_yamllaunch.terminal.full_screen.widgets import Asked
from colcon_yamllaunch.terminal.full_screen.widgets import LeaveQuestion
from colcon_yamllaunch.terminal.full_screen.widgets import Leaving
from colcon_yamllaunch.terminal.full_screen.widgets import OutputPane
from colcon_yamllaunch.terminal.full_screen.widgets import PartList
from colcon_yamllaunch.terminal.full_screen.widgets import Prompt
from colcon_yamllaunch.terminal.full_screen.widgets import Reading
from colcon_yamllaunch.terminal.keymap import cannot_be_typed_at
from colcon_yamllaunch.terminal.keymap import ON_ALL
from colcon_yamllaunch.terminal.keymap import ON_ONE
from colcon_yamllaunch.terminal.keymap import only_its_container_writes
from colcon_yamllaunch.terminal.keymap import without_effect
from colcon_yamllaunch.terminal.line_filter import Filtering
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

_KEYS = {key.name: key for key in (*ON_ONE, *ON_ALL)}
# those that are no text while somebody types
_WHILE_TYPING = frozenset(('clear', 'switch'))


class Terminal(Protocol):
    """What is outside of the screen."""

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
        # with priority, as others are for who had the focus when the key
        # came: several at once, as by a slow line, would miss the prompt
        Binding(
            name,
            f'press("{key.name}", "{name}")',
            show=False,
            priority=True,
        )
        for key in _KEYS.values()
        for name in (key.names or key.key).split(',')
    ]
    AUTO_FOCUS = '#parts'

    def __init__(
        self,
        launch: RunningLaunch,
        terminal: Terminal,
    ) -> None:
        super().__init__()
        self._launch = launch
        self._terminal = terminal
        self.model = LaunchModel(launch, os.environ.get(FORMAT))
        self._parts = PartList()
        self._output = OutputPane(self.model.view)
        self._shows_plan = False
        self._is_output = False
        self._prompt = Prompt(self._take_typed, self._ask_no_more)
        self._search_before = ''
        self._is_due = False
        self._drawn = 0.0
        self._lines = {
            name: Static(id=name) for name in ('title', 'short', 'keys')
        }
        self._shown: dict[str, Text] = {}
        self._said: tuple[str, str] = ('', '')
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
        self.model.open(get_running_loop(), self.changed, self._ended)

    def on_unmount(self) -> None:
        """Close the connection."""
        self.close()

    def check_action(
        self,
        action: str,  # noqa: ARG002
        parameters: tuple[object, ...],
    ) -> bool | None:
        """Return whether a key has an effect now; otherwise it is text."""
        return not self._prompt.asked or not _WHILE_TYPING.isdisjoint(
            parameters
        )

    def close(self) -> None:
        """Close the connection, and draw no more."""
        self._is_closed = True
        self.model.close()

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

    # -- keys

    def action_press(self, name: str, pressed: str) -> None:
        """
        Send the command of a key, change the filter, or call its method.

        :param pressed: The key itself, as it may be one of several
        """
        key = _KEYS[name]
        subject: Any = self.model.state
        if key in ON_ONE:
            part = self._part()
            if part is None:
                return
            if key.filter and isinstance(part, ComponentState):
                self.say(only_its_container_writes(part.label), 'red')
                return
            subject = part.label
        if key.filter is not None:
            self._filter(key.filter(self._filtering, subject))
        elif key.command is not None:
            self._send(name, key.command(subject))
        elif key in ON_ONE:
            getattr(self, f'key_{name}')(part)
        else:
            getattr(self, f'key_{name}')(pressed)

    def _send(self, name: str, command: Command[Any]) -> None:
        def reply(response: Any) -> None:
            if isinstance(response, Refused):
                self.say(response.error, 'red')
            elif after := getattr(self, f'after_{name}', None):
                after(command, response)
            elif isinstance(command, PartCommand):
                self.say(f'{command.process}: {name} requested')

        if not self._has_ended():
            self.model.send(self._launch.ask, command, reply)

    def after_debug(self, command: PartCommand[Any], _: object) -> None:
        """Say how to go on."""
        text = 'starts under a debugger: a types at it'
        self.say(f'{command.process}: {text}')

    def after_describe(
        self, command: PartCommand[Any], response: Described
    ) -> None:
        """Show what a process or component is."""
        text = in_full(self.model, command.process, response.description)
        self.app.push_screen(Reading(one_line(command.process), text))

    def after_watch(self, command: Watch, _: object) -> None:
        """Say whether changes of files have consequences."""
        is_off = command.action == 'pause'
        self.say(f'--watch is {"off: w switches it on" if is_off else "on"}')

    def key_attach(self, part: Part) -> None:
        """Type at a process."""
        if isinstance(part, ComponentState) or not part.terminal:
            self.say(cannot_be_typed_at(part), 'red')
            return
        with self.app.suspend():
            self._terminal.attach(part.label)
        self.app.refresh()

    def key_log(self, part: Part) -> None:
        """Show its log."""
        if part.log is None:
            self.say(f'{part.label} has no log of its own', 'red')
            return
        with self.app.suspend():
            self._terminal.page(part.log)
        self.app.refresh()

    def key_search(self, _: str) -> None:
        """Ask for a text that lines have."""
        self._search_before = self._filtering.search
        self._prompt.ask('search', self._filtering.search)

    def key_find(self, _: str) -> None:
        """Ask for the name of a process."""
        self._prompt.ask('find')

    def key_plan(self, _: str) -> None:
        """Show the plan, or the processes."""
        self._shows_plan = not self._shows_plan
        self.changed()

    def key_go(self, digit: str) -> None:
        """Go to one of the first processes."""
        label = self.model.label_of(digit)
        if label is not None:
            self._parts.go_to(label)

    def key_failed(self, _: str) -> None:
        """Go to the next that failed."""
        if not self._parts.next_of(self.model.failed):
            self.say('nothing has failed')

    def key_switch(self, _: str) -> None:
        """Go to the other pane."""
        self._is_output = not self._is_output
        self.set_class(self._is_output, 'output')
        self._ask_no_more()

    def key_clear(self, _: str) -> None:
        """Show all again, or ask no more."""
        if self._prompt.asked == 'search':
            self._filter(replace(self._filtering, search=self._search_before))
        elif not self._prompt.asked:
            self._filter(self._filtering.cleared())
        self._ask_no_more()

    def key_errors(self, _: str) -> None:
        """Show what the last build that failed has said."""
        errors = self.model.state.errors
        if not errors:
            self.say('no build has failed')
            return
        text = Text('\n'.join(map(one_line, errors)))
        self.app.push_screen(Reading('Errors', text))

    def key_help(self, _: str) -> None:
        """Show what the keys do."""
        owns = self._terminal.owns_launch
        last = 'stop the launch; once more hurries' if owns else 'leave'
        self.app.push_screen(Reading('Keys', help_table(last)))

    def key_leave(self, _: str = '') -> None:
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
        self.model.choose(filtering)
        self.changed()

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

    def _has_ended(self) -> bool:
        """Return whether the launch has ended, and say so."""
        if self.model.ending:
            self.say(self.model.ending, 'red')
        return bool(self.model.ending)

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
        if not reason and self.model.state.exit_code is None:
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
        model = self.model
        rows = model.plan_rows() if self._shows_plan else model.rows()
        self._parts.show(rows, self._filtering)
        self._output.changed()
        title = title_text(model, follows=self._output.follows)
        self._put('title', title)
        self._put('keys', self._last_line())
        label = self._parts.label
        shown = Text()
        if label is not None:
            width = self._lines['short'].size.width
            shown = in_short(model, label, width)
        self._put('short', shown)

    def _resumed(self, _: object) -> None:
        # another program had the terminal
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
            left_out=without_effect(
                self.model.state, self.model.part(self._parts.label)
            ),
        )
