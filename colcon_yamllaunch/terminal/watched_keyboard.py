# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The keyboard of a launch, while the terminal is its own."""

from collections.abc import Callable
import termios
from typing import Any

from colcon_yamllaunch.engine.loop import Loop
from colcon_yamllaunch.terminal.keyboard import Keyboard


class WatchedKeyboard:
    """
    Has keys taken as they come, from the loop of the launch.

    :param keyboard: That, None if somebody else has its keys
    :param take: Takes what was typed
    """

    def __init__(
        self, keyboard: Keyboard | None, take: Callable[[bytes], None]
    ) -> None:
        self._keyboard = keyboard
        self._take = take
        self._loop: Loop | None = None
        self._is_grabbed = False
        self._has_had_keys = False

    def connect(self, loop: Loop) -> None:
        """Use the loop of a launch, before it runs."""
        self._loop = loop

    @property
    def has_keys(self) -> bool:
        """Whether keys are taken now."""
        keyboard = self._keyboard
        return (
            self._is_grabbed and keyboard is not None and keyboard.takes_keys
        )

    def grab(self, *, keeps_early: bool) -> tuple[list[Any], list[Any]] | None:
        """
        Take keys from now on.

        Return the modes that the terminal had, and those that it has now, or
        None if they are as they were.

        :param keeps_early: Whether what was typed before the first time is
          for somebody, and not what nobody could know the meaning of
        """
        keyboard, loop = self._keyboard, self._loop
        if keyboard is None or loop is None or not keyboard.grab():
            return None
        self._is_grabbed = True
        modes = keyboard.modes
        if keyboard.takes_keys:
            if not self._has_had_keys and not keeps_early:
                termios.tcflush(keyboard.descriptor, termios.TCIFLUSH)
            self._has_had_keys = True
            loop.add_reader(keyboard.descriptor, self._readable)
            loop.add_hangup_handler(keyboard.descriptor, self._hung_up)
        return modes

    def let_go(self) -> None:
        """Leave the keys to others."""
        if self._is_grabbed and self._keyboard and self._loop:
            self._is_grabbed = False
            self._loop.remove(self._keyboard.descriptor)
            self._keyboard.release()

    def _hung_up(self) -> None:
        if not self._readable():
            self.let_go()

    def _readable(self) -> bool:
        """Take what was typed, and return whether there was something."""
        assert self._keyboard is not None
        try:
            keys = self._keyboard.keys()
        except OSError:
            keys = b''
        if keys:
            self._take(keys)
        return bool(keys)
