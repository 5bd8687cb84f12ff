# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The full screen as a program of its own."""

import asyncio
from codecs import getincrementaldecoder
from collections.abc import Callable
from collections.abc import Collection
from collections.abc import Mapping
from contextlib import suppress
from functools import partial
import os
import signal
from typing import Any
from typing import ClassVar

from colcon_yamllaunch.control.client import RunningLaunch
from colcon_yamllaunch.control.resource_usage import Usage
from colcon_yamllaunch.control.resource_usage import usage_of
from colcon_yamllaunch.terminal.full_screen.launch_screen import LaunchScreen
from colcon_yamllaunch.terminal.full_screen.launch_screen import Terminal
from colcon_yamllaunch.terminal.keyboard import is_in_foreground
from textual.app import App
from textual.binding import Binding
from textual.binding import BindingType
from textual.drivers import linux_driver

#: Seconds between two looks at what processes use.
MEASURED_EVERY = 2.0

Measure = Callable[[Collection[int]], Mapping[int, Usage]]


# keys of another encoding than UTF-8 are none, and no errors
linux_driver.getincrementaldecoder = (  # type: ignore[attr-defined]
    lambda name: partial(getincrementaldecoder(name), 'replace')
)


class LaunchApp(App[None]):
    """
    Shows a launch until somebody leaves.

    :param launch: The launch, which was subscribed to
    :param terminal: What is outside of the screen
    :param measure: Tells what process groups use; it may take some time
    :param shown: Is told when the terminal is the app's, and when it is not
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
    #parts { height: 1fr; overflow-x: hidden; scrollbar-size: 0 1; }
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
        # the colours of the terminal, and none of ours
        super().__init__(driver_class=_Driver, ansi_color=True)
        self._measure = measure
        #: Is told when the terminal is ours, and when it is not.
        self.tell_shown = shown
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
        loop.set_exception_handler(self._take_loop_error)
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
        # one line, after all, instead of screens full of a traceback
        self.error = self.error or error
        self.exit(return_code=1)

    def _take_loop_error(
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
            # a process may end in the middle of it
            with suppress(OSError):
                model.add_usage(await asyncio.to_thread(self._measure, pids))
            model.ask_for_usage()
            self.panes.changed()
            await asyncio.sleep(MEASURED_EVERY)


class _Driver(linux_driver.LinuxDriver):
    """The terminal, which others have while we are stopped."""

    _app: LaunchApp

    def start_application_mode(self) -> None:
        """Take the terminal."""
        super().start_application_mode()  # type: ignore[no-untyped-call]
        self._app.tell_shown(True)

    def stop_application_mode(self) -> None:
        """Give it back as it was."""
        super().stop_application_mode()
        self._app.tell_shown(False)

    def run_input_thread(self) -> None:
        """Read keys."""
        try:
            super().run_input_thread()
        except Exception as e:  # noqa: BLE001
            self._app.call_later(self._app._handle_exception, e)

    def _sigcont_application(self, *_: object) -> None:
        # a process, or the pager, may have the terminal; or it is gone, which
        # is told by this signal, too
        if not (self._auto_restart and os.isatty(self.fileno)):
            return
        if not is_in_foreground(self.fileno):
            os.kill(os.getpid(), signal.SIGSTOP)
        elif self._must_signal_resume:
            super()._sigcont_application()
        else:
            # nobody could give it back before a SIGSTOP
            loop = asyncio.get_running_loop()
            loop.call_soon_threadsafe(self._begin_anew)

    def _begin_anew(self) -> None:
        self.suspend_application_mode()
        self._must_signal_resume = True
        self.resume_application_mode()
