# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The connection to a launch, in the loop of the full screen."""

from asyncio import AbstractEventLoop
from collections.abc import Callable
from collections.abc import Mapping
from typing import Any

from colcon_yamllaunch.runtime.clients.client import ControlError
from colcon_yamllaunch.runtime.clients.client import LaunchEndedError
from colcon_yamllaunch.runtime.clients.subscription import Answered
from colcon_yamllaunch.runtime.clients.subscription import News
from colcon_yamllaunch.runtime.clients.subscription import Subscription

#: Reads in an interval, each of some 64 KiB at most. Nobody reads more than
#: that, and the launch need not prepare it: it counts what we miss.
READS = 3
#: Seconds.
INTERVAL = 0.2

#: Takes an answer: why it was refused, or None, and all of it.
Done = Callable[[str | None, Mapping[str, Any]], None]


class Link:
    """
    Reads news, as many as can be shown, and asks for things.

    :param take: Takes them, one by one
    :param settled: Is called after some were taken
    :param ended: Is told when and why there are no more: empty where the
      launch has ended as it should
    """

    def __init__(
        self,
        subscription: Subscription,
        loop: AbstractEventLoop,
        take: Callable[[News], None],
        settled: Callable[[], None],
        ended: Callable[[str], None],
    ) -> None:
        self._subscription = subscription
        self._loop = loop
        self._take = take
        self._settled = settled
        self._ended = ended
        self._waiting: dict[int, Done] = {}
        self._begin = loop.time()
        self._reads = 0
        #: Whether the launch can be asked.
        self.is_open = True
        loop.add_reader(subscription.fileno(), self._read)

    def close(self) -> None:
        """Leave the launch alone."""
        if self.is_open:
            self.is_open = False
            self._loop.remove_reader(self._subscription.fileno())
            self._subscription.close()

    def ask(self, name: str, done: Done | None = None, **more: Any) -> None:
        """
        Have something done; see `protocol`.

        :param done: Is told what came of it
        """
        if not self.is_open:
            return
        try:
            number = self._subscription.ask(name, **more)
        except ControlError as error:
            self._end(error)
            return
        if done is not None:
            self._waiting[number] = done

    def _read(self) -> None:
        now = self._loop.time()
        if now - self._begin > INTERVAL:
            self._begin = now
            self._reads = 0
        self._reads += 1
        try:
            self._subscription.read()
            self._take_news()
        except ControlError as error:
            self._end(error)
            return
        if self._reads >= READS:
            self._loop.remove_reader(self._subscription.fileno())
            self._loop.call_at(self._begin + INTERVAL, self._go_on)

    def _go_on(self) -> None:
        if self.is_open:
            self._loop.add_reader(self._subscription.fileno(), self._read)

    def _take_news(self) -> None:
        for one in self._subscription.news():
            if isinstance(one, Answered):
                done = self._waiting.pop(one.number, None)
                if done is not None:
                    done(one.error, one.answer)
            else:
                self._take(one)
        self._settled()

    def _end(self, error: ControlError) -> None:
        self.close()
        reason = '' if isinstance(error, LaunchEndedError) else str(error)
        self._ended(reason)
