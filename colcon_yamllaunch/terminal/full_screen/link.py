# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The connection to a launch, in the loop of the full screen."""

from asyncio import AbstractEventLoop
from collections.abc import Callable
from collections.abc import Iterator
from collections.abc import Mapping
from contextlib import suppress
from typing import Any
from typing import Protocol

from colcon_yamllaunch.control.client import ControlError
from colcon_yamllaunch.control.client import LaunchEndedError
from colcon_yamllaunch.control.protocol import launch_of
from colcon_yamllaunch.control.protocol import ProtocolError
from colcon_yamllaunch.control.subscription import Answered
from colcon_yamllaunch.control.subscription import News
from colcon_yamllaunch.engine.state import LaunchState
from colcon_yamllaunch.terminal.full_screen.launch_model import LaunchModel

#: Reads in an interval, each of some 64 KiB at most. Nobody reads more than
#: that, and the launch need not prepare it: it counts what we miss.
READS = 3
#: Seconds.
INTERVAL = 0.2
#: Seconds between two questions for the state of the launch: short enough to
#: look like at once, long enough for many events to be asked about together.
ASKED_EVERY = 0.25
#: Bytes of output that the screen may be behind before it misses some. So it
#: shows all of a burst, and stays up to date beside an endless flood.
BEHIND = 8 * 1024 * 1024

#: Takes an answer: why it was refused, or None, and all of it.
Done = Callable[[str | None, Mapping[str, Any]], None]


class LaunchFeed(Protocol):
    """What is told of a launch, and asked of it; see `Subscription`."""

    @property
    def state(self) -> LaunchState:
        """What the launch was at first."""

    def fileno(self) -> int:
        """Return what is readable when there may be news."""

    def close(self) -> None:
        """Leave the launch alone."""

    def ask(self, name: str, **more: Any) -> int:
        """Have something done, and return the number of the answer."""

    def read(self) -> None:
        """Read what has come, once."""

    def news(self) -> Iterator[News]:
        """Return what has been read."""


class Link:
    """
    Keeps what is known of a launch up to date, and asks for things.

    :param changed: Is called after something has changed
    :param ended: Is told when and why nothing more will: empty where the
      launch has ended as it should
    """

    def __init__(
        self,
        feed: LaunchFeed,
        loop: AbstractEventLoop,
        model: LaunchModel,
        changed: Callable[[], None],
        ended: Callable[[str], None],
    ) -> None:
        self._feed = feed
        self._loop = loop
        self._model = model
        self._changed = changed
        self._ended = ended
        self._waiting: dict[int, Done] = {}
        self._begin = loop.time()
        self._reads = 0
        self._is_asked = False
        # the processes whose output is read, None for all; and what was
        # missed when somebody last chose what is shown
        self._wanted: frozenset[str] | None = None
        self._missed_before = 0
        #: Whether the launch can be asked.
        self.is_open = True
        loop.add_reader(feed.fileno(), self._read)
        self._settle()

    def close(self) -> None:
        """Leave the launch alone."""
        if self.is_open:
            self.is_open = False
            self._loop.remove_reader(self._feed.fileno())
            self._feed.close()

    def ask(self, name: str, done: Done | None = None, **more: Any) -> None:
        """
        Have something done; see `protocol`.

        :param done: Is told what came of it
        """
        if not self.is_open:
            return
        try:
            number = self._feed.ask(name, **more)
        except ControlError as error:
            self._end(error)
            return
        if done is not None:
            self._waiting[number] = done

    def choose(self) -> None:
        """Take into account that somebody chose what is shown."""
        self._missed_before = self._model.missed_bytes
        self._narrow()

    def look_again(self) -> None:
        """Ask for the state of the launch if that is wanted."""
        if self.is_open:
            self._settle()

    def _read(self) -> None:
        now = self._loop.time()
        if now - self._begin > INTERVAL:
            self._begin = now
            self._reads = 0
        self._reads += 1
        try:
            self._feed.read()
            self._take_news()
        except ControlError as error:
            self._end(error)
            return
        if self.is_open and self._reads >= READS:
            self._loop.remove_reader(self._feed.fileno())
            self._loop.call_at(self._begin + INTERVAL, self._go_on)

    def _go_on(self) -> None:
        if self.is_open:
            self._loop.add_reader(self._feed.fileno(), self._read)

    def _take_news(self) -> None:
        for one in self._feed.news():
            if isinstance(one, Answered):
                done = self._waiting.pop(one.number, None)
                if done is not None:
                    done(one.error, one.answer)
            else:
                self._model.take(one)
        self._settle()

    def _settle(self) -> None:
        """Ask for what the news have not told."""
        model = self._model
        if model.wants_state and not self._is_asked:
            self._is_asked = True
            self._loop.call_later(ASKED_EVERY, self._ask_for_state)
        if model.wants_tree:
            model.wants_tree = False
            self.ask('tree', self._take_tree)
        self._narrow()
        self._changed()

    def _ask_for_state(self) -> None:
        self._model.wants_state = False
        self.ask('status', self._take_state)

    def _take_state(
        self, error: str | None, answer: Mapping[str, Any]
    ) -> None:
        self._is_asked = False
        if error is None:
            # one of another version says something else
            with suppress(ProtocolError):
                self._model.state = launch_of(answer)

    def _take_tree(self, error: str | None, answer: Mapping[str, Any]) -> None:
        tree = answer.get('tree')
        if error is None and isinstance(tree, list):
            self._model.tree = tree

    def _narrow(self) -> None:
        """
        Read what is shown only, where all of it is too much.

        Else all is read, so that it is there when somebody wants to see it.
        """
        model = self._model
        wanted = None
        if not model.shows_all and (
            self._wanted is not None
            or model.missed_bytes > self._missed_before
        ):
            wanted = model.shown_labels
        if wanted == self._wanted:
            return
        if self._wanted is None:
            model.say('… too much: of what is not shown, nothing is read …')
        elif wanted is None:
            model.say('… all is read again …')
        self._wanted = wanted
        processes = None if wanted is None else sorted(wanted)
        self.ask('subscribe', processes=processes, behind=BEHIND, raw=True)

    def _end(self, error: ControlError) -> None:
        self.close()
        reason = '' if isinstance(error, LaunchEndedError) else str(error)
        self._ended(reason)
