# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The full screen: the program, its panes, and what each key does."""

import asyncio
from asyncio import get_running_loop
from codecs import getincrementaldecoder
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import partial
import os
import signal
from typing import Any, ClassVar, Protocol

from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.control.client import RunningLaunch
from colcon_yamllaunch.control.resource_usage import Usage, usage_of
from colcon_yamllaunch.engine import commands
from colcon_yamllaunch.engine.state import ComponentState, MemberState
from colcon_yamllaunch.observers.log_levels import FORMAT
from colcon_yamllaunch.terminal import keymap
from colcon_yamllaunch.terminal.full_screen import screen_texts, widgets
from colcon_yamllaunch.terminal.full_screen.launch_model import LaunchModel
from colcon_yamllaunch.terminal.keyboard import is_in_foreground
from colcon_yamllaunch.terminal.line_filter import Filtering
from rich.text import Text
from textual.app import App, ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.drivers import linux_driver
from textual.events import Resize
from textual.screen import Screen

_PROMPT_HINT = 'Enter keeps what is found  Esc goes back'
#: Seconds between two drawings.
DRAWN_EVERY = 0.1
#: Seconds for which an answer is shown.
SHOWN_FOR = 6.0
#: Columns below which there is one pane at a time.
NARROW = 60
#: Seconds between two measurements of CPU and memory.
MEASURED_EVERY = 2.0

_KEYS = {key.name: key for key in (*keymap.ON_ONE, *keymap.ON_ALL)}
# keys that keep their effect in a prompt
_PROMPT_KEYS = frozenset(('clear', 'switch'))

Measure = Callable[[Collection[int]], Mapping[int, Usage]]

# input that is not UTF-8 is replaced, and no error
linux_driver.getincrementaldecoder = (  # type: ignore[attr-defined]
    lambda name: partial(getincrementaldecoder(name), 'replace')
)


class Terminal(Protocol):
    """The terminal and the launch, as far as the screen needs them."""

    @property
    def owns_launch(self) -> bool:
        """Whether the launch was started for this screen."""

    def attach(self, label: str) -> None:
        """Connect the terminal to a process, until that is over."""

    def page(self, path: str) -> None:
        """Show a file, until the user has seen it."""

    def interrupt(self) -> None:
        """Interrupt the launch as Ctrl-C does, if the screen owns it."""


class LaunchScreen(Screen[None]):
    """A launch: its processes left, what they write right."""

    BINDINGS: ClassVar[list[BindingType]] = [
        # without priority, keys go to the widget that had the focus when they
        # came: of several at once, as over a slow line, none would reach the
        # prompt
        Binding(
            name,
            f'press("{key.name}", "{name}")',
            show=False,
            priority=True,
        )
        for key in _KEYS.values()
        for name in (key.names or key.key).split(',')
    ]
    AUTO_FOCUS = '#members'

    def __init__(
        self,
        launch: RunningLaunch,
        terminal: Terminal,
    ) -> None:
        super().__init__()
        self._launch = launch
        self._terminal = terminal
        self.model = LaunchModel(launch, os.environ.get(FORMAT))
        self._members = widgets.MemberList()
        self._output = widgets.OutputPane(self.model.view)
        self._shows_plan = False
        self._is_output = False
        self._prompt = widgets.Prompt(self._use_typed, self._close_prompt)
        self._search_before = ''
        self._is_due = False
        self._drawn = 0.0
        self._lines = {
            name: widgets.FixedText(name)
            for name in ('title', 'short', 'keys')
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
                yield self._members
                yield self._lines['short']
            yield self._output
        yield self._prompt
        yield self._lines['keys']

    def on_mount(self) -> None:
        """Begin to listen."""
        # another program had the terminal
        loop = get_running_loop()
        self.app.app_resume_signal.subscribe(
            self, lambda _: loop.call_later(DRAWN_EVERY, self.app.refresh)
        )
        self.model.open(loop, self.changed, self._ended)

    def check_action(
        self,
        action: str,  # noqa: ARG002
        parameters: tuple[object, ...],
    ) -> bool | None:
        """Return whether a key has an effect now; otherwise it is text."""
        return not self._prompt.asked or not _PROMPT_KEYS.isdisjoint(
            parameters
        )

    def close(self) -> None:
        """Close the connection, and draw no more."""
        self._is_closed = True
        self.model.close()

    on_unmount = close

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

    # the cursor, the focus, and whether the output follows are all shown
    on_member_list_moved = on_descendant_focus = changed
    on_output_pane_followed = changed

    # -- keys

    def action_press(self, name: str, pressed: str) -> None:
        """
        Send the command of a key, change the filter, or call its method.

        :param pressed: The key itself, as it may be one of several
        """
        key = _KEYS[name]
        subject: Any = self.model.state
        argument: Any = pressed
        if key in keymap.ON_ONE:
            member = self.model.member(self._members.label)
            if member is None:
                self.say('go to a process or component first', 'red')
                return
            if key.filter and isinstance(member, ComponentState):
                self.say(keymap.only_its_container_writes(member.label), 'red')
                return
            subject, argument = member.label, member
        if key.filter is not None:
            self._filter(key.filter(self._filtering, subject))
        elif key.command is not None:
            self._send(name, key.command(subject))
        else:
            getattr(self, f'key_{name}')(argument)

    def _send(self, name: str, command: commands.Command[Any]) -> None:
        def reply(response: Any) -> None:
            if isinstance(response, commands.Refused):
                self.say(response.error, 'red')
            elif after := getattr(self, f'after_{name}', None):
                after(command, response)
            elif isinstance(command, commands.MemberCommand):
                self.say(f'{command.member}: {name} requested')

        if self.model.ending:
            self.say(self.model.ending, 'red')
        else:
            self.model.send(self._launch.ask, command, reply)

    def after_debug(
        self, command: commands.MemberCommand[Any], _: object
    ) -> None:
        """Show how to type at the debugger."""
        text = 'starts under a debugger: a types at it'
        self.say(f'{command.member}: {text}')

    def after_describe(
        self,
        command: commands.MemberCommand[Any],
        response: commands.Described,
    ) -> None:
        """Show what a process or component is."""
        text = screen_texts.in_full(
            self.model, command.member, response.description
        )
        self.app.push_screen(
            widgets.TextScreen(one_line(command.member), text)
        )

    def after_watch(self, command: commands.Watch, _: object) -> None:
        """Show whether `--watch` is on."""
        is_off = command.action == 'pause'
        self.say(f'--watch is {"off: w switches it on" if is_off else "on"}')

    def key_attach(self, member: MemberState) -> None:
        """Type at a process."""
        if isinstance(member, ComponentState) or not member.terminal:
            self.say(keymap.cannot_be_typed_at(member), 'red')
            return
        with self.app.suspend():
            self._terminal.attach(member.label)
        self.app.refresh()

    def key_log(self, member: MemberState) -> None:
        """Show its log."""
        if member.log is None:
            self.say(f'{member.label} has no log of its own', 'red')
            return
        with self.app.suspend():
            self._terminal.page(member.log)
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
            self._members.go_to(lambda row: row.label == label)

    def key_failed(self, _: str) -> None:
        """Go to the next that failed."""
        failed = self.model.failed
        if not self._members.go_to(
            lambda row: row.label in failed, after=True
        ):
            self.say('nothing has failed')

    def key_switch(self, _: str) -> None:
        """Go to the other pane."""
        self._is_output = not self._is_output
        self.set_class(self._is_output, 'output')
        self._close_prompt()

    def key_clear(self, _: str) -> None:
        """Show all again, or ask no more."""
        if self._prompt.asked == 'search':
            self._filter(replace(self._filtering, search=self._search_before))
        elif not self._prompt.asked:
            self._filter(self._filtering.cleared())
        self._close_prompt()

    def key_errors(self, _: str) -> None:
        """Show what the last build that failed has said."""
        errors = self.model.state.errors
        if not errors:
            self.say('no build has failed')
            return
        text = Text('\n'.join(map(one_line, errors)))
        self.app.push_screen(widgets.TextScreen('Errors', text))

    def key_help(self, _: str) -> None:
        """Show what the keys do."""
        owns = self._terminal.owns_launch
        last = 'stop the launch; again to force' if owns else 'leave'
        self.app.push_screen(
            widgets.TextScreen('Keys', screen_texts.help_table(last))
        )

    def key_leave(self, _: str = '') -> None:
        """Leave; if the screen owns the launch, ask whether to stop it."""
        if self.model.ending or not self._terminal.owns_launch:
            self.app.exit()
        else:
            self.app.push_screen(widgets.LeaveQuestion(), self._leave)

    def interrupt(self) -> None:
        """Do what Ctrl-C does."""
        if self.model.ending or not self._terminal.owns_launch:
            self.app.exit()
        else:
            self._terminal.interrupt()
            self.say('stopping; Ctrl-C again to force')

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

    @property
    def _filtering(self) -> Filtering:
        return self.model.view.filtering

    def _filter(self, filtering: Filtering) -> None:
        self.model.choose(filtering)
        self.changed()

    def _use_typed(self, asked: widgets.Asked, text: str) -> None:
        if asked == 'search' and text != self._filtering.search:
            self._filter(replace(self._filtering, search=text))
        elif asked == 'find' and text:
            name = text.lower()
            self._members.go_to(lambda row: name in (row.label or '').lower())

    def _leave(self, answer: widgets.Leaving | None) -> None:
        if answer == 'leave' or (answer == 'stop' and self.model.ending):
            self.app.exit()
        elif answer == 'stop':
            self._stops_to_leave = True
            self._terminal.interrupt()
            self.say('stopping, then leaving; Ctrl-C to force')

    def _close_prompt(self) -> None:
        self._prompt.close_prompt()
        self.set_focus(self._output if self._is_output else self._members)
        self.changed()

    def _ended(self, reason: str) -> None:
        if not reason and self.model.state.exit_code is None:
            reason = 'the launcher is gone; colcon launch --status shows rests'
        self.model.end(reason)
        self._said = ('', '')
        self.changed()
        if self._stops_to_leave:
            self.app.exit()
        elif isinstance(self.app.screen, widgets.LeaveQuestion):
            # the question is pointless now
            self.app.screen.dismiss('stay')

    def _draw(self) -> None:
        self._is_due = False
        self._drawn = get_running_loop().time()
        if self._is_closed:
            return
        model = self.model
        rows = model.plan_rows() if self._shows_plan else model.rows()
        self._members.show(rows, self._filtering)
        self._output.changed()
        title = screen_texts.title_text(model, follows=self._output.follows)
        self._update_line('title', title)
        self._update_line('keys', self._last_line())
        label = self._members.label
        shown = Text()
        if label is not None:
            width = self._lines['short'].size.width
            shown = screen_texts.in_short(model, label, width)
        self._update_line('short', shown)

    def _update_line(self, place: str, text: Text) -> None:
        if text != self._shown.get(place):
            self._shown[place] = text
            self._lines[place].show(text)

    def _last_line(self) -> Text:
        said, style = self._said
        if not said and self.model.ending:
            said, style = f'{self.model.ending}; q leaves', 'bold'
        if said:
            return Text(said, style, no_wrap=True, overflow='ellipsis')
        if self._prompt.display:
            # while a text is typed, most keys are part of it
            return Text(_PROMPT_HINT, 'dim', no_wrap=True)
        width = self.size.width
        return screen_texts.keys_text(
            width,
            is_narrow=width < NARROW,
            left_out=keymap.without_effect(
                self.model.state, self.model.member(self._members.label)
            ),
        )


class LaunchApp(App[None]):
    """
    Shows a launch until somebody leaves.

    :param launch: The launch, which was subscribed to
    :param terminal: What is outside of the screen
    :param measure: Returns what process groups use; it may take a while
    :param shown: Is called with whether the terminal is the app's
    """

    TITLE = 'colcon launch'
    ENABLE_COMMAND_PALETTE = False
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding('ctrl+c', 'interrupt', show=False, priority=True),
        Binding('ctrl+q', 'leave', show=False, priority=True),
        Binding('ctrl+z', 'suspend_process', show=False, priority=True),
    ]
    CSS = """
    Screen { layout: vertical; }
    #title, #keys, #prompt { height: 1; }
    #title, #keys, #short { text-wrap: nowrap; text-overflow: ellipsis; }
    #prompt { border: none; padding: 0; }
    #panes { height: 1fr; }
    #left { width: 34%; max-width: 60; min-width: 24;
            border-right: solid ansi_bright_black; }
    #members { height: 1fr; overflow-x: hidden; scrollbar-size: 0 1; }
    #short { height: 4; }
    #output { width: 1fr; scrollbar-size: 0 1; overflow-y: scroll;
              overflow-x: hidden; }
    .narrow #left { width: 1fr; max-width: 100%; border-right: none; }
    .narrow #output { display: none; }
    .narrow.output #left { display: none; }
    .narrow.output #output { display: block; }
    ModalScreen { align: center middle; }
    .box { width: 90%; max-width: 100; height: auto; max-height: 90%;
           border: round ansi_bright_black; padding: 0 1; }
    """

    def __init__(
        self,
        launch: RunningLaunch,
        terminal: Terminal,
        measure: Measure = usage_of,
        shown: Callable[[bool], None] = lambda _: None,
    ) -> None:
        # use the colours of the terminal
        super().__init__(driver_class=_Driver, ansi_color=True)
        self._measure = measure
        #: Is called with whether the terminal is ours.
        self.notify_shown = shown
        self.panes = LaunchScreen(launch, terminal)
        #: The signal that ended it, None where the user left.
        self.signal: int | None = None
        #: The defect of ours that ended it, if one did.
        self.error: Exception | None = None
        self._mounted_in: asyncio.AbstractEventLoop | None = None

    def get_default_screen(self) -> LaunchScreen:
        """Return what is shown at first."""
        return self.panes

    def on_mount(self) -> None:
        """Begin to measure."""
        loop = asyncio.get_running_loop()
        loop.set_exception_handler(self._handle_loop_error)
        self._mounted_in = loop
        if self.signal is not None:
            self.exit()
        self.run_worker(self._measure_on())

    def action_interrupt(self) -> None:
        """Do what Ctrl-C does."""
        self.panes.interrupt()

    def action_leave(self) -> None:
        """Do what q does."""
        self.panes.key_leave()

    def end_by(self, number: int) -> None:
        """End as a signal came; its handler may call this at any time."""
        self.signal = number
        if self._mounted_in is not None:
            self._mounted_in.call_soon_threadsafe(self.exit)

    def _handle_exception(self, error: Exception) -> None:
        # the caller reports it in one line, without a traceback
        self.error = self.error or error
        self.exit(return_code=1)

    def _handle_loop_error(
        self, _: asyncio.AbstractEventLoop, context: dict[str, Any]
    ) -> None:
        error = context.get('exception')
        if isinstance(error, Exception):
            self._handle_exception(error)

    async def _measure_on(self) -> None:
        model = self.panes.model
        while not model.ending:
            processes = model.state.processes
            pids = {p.local_pid for p in processes if p.local_pid is not None}
            # a process may end during the measurement
            with suppress(OSError):
                model.add_usage(await asyncio.to_thread(self._measure, pids))
            model.ask_for_usage()
            self.panes.changed()
            await asyncio.sleep(MEASURED_EVERY)


class _Driver(linux_driver.LinuxDriver):
    """The terminal, which other programs use while this one is stopped."""

    _app: LaunchApp

    def start_application_mode(self) -> None:
        """Set the modes of the terminal."""
        super().start_application_mode()  # type: ignore[no-untyped-call]
        self._app.notify_shown(True)

    def stop_application_mode(self) -> None:
        """Restore the modes of the terminal."""
        super().stop_application_mode()
        self._app.notify_shown(False)

    def run_input_thread(self) -> None:
        """Read keys."""
        try:
            super().run_input_thread()
        except Exception as e:  # noqa: BLE001
            self._app.call_later(self._app._handle_exception, e)

    def _sigcont_application(self, *_: object) -> None:
        # a process or the pager may have the terminal; this signal also comes
        # when the terminal is gone
        if not (self._auto_restart and os.isatty(self.fileno)):
            return
        if not is_in_foreground(self.fileno):
            os.kill(os.getpid(), signal.SIGSTOP)
        elif self._must_signal_resume:
            super()._sigcont_application()
        else:
            # SIGSTOP left no chance to restore the terminal
            loop = asyncio.get_running_loop()
            loop.call_soon_threadsafe(self._begin_anew)

    def _begin_anew(self) -> None:
        self.suspend_application_mode()
        self._must_signal_resume = True
        self.resume_application_mode()
