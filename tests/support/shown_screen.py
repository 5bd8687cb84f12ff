# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The full screen in memory, which a test types at."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

from colcon_yamllaunch.terminal.full_screen.launch_screen import LaunchApp
from textual.pilot import Pilot

#: Seconds after which something will not be seen any more.
DEADLINE = 60.0


class Around:
    """What is around the screen, and what it was asked for."""

    def __init__(self, *, owns_launch: bool = False) -> None:
        self.owns_launch = owns_launch
        self.asked: list[str] = []

    def attach(self, label: str) -> None:
        self.asked.append(f'attach {label}')

    def page(self, path: str) -> None:
        self.asked.append(f'page {path}')

    def interrupt(self) -> None:
        self.asked.append('interrupt')


class Shown:
    """An app that runs, and what is on its screen."""

    def __init__(self, app: LaunchApp, pilot: Pilot[None]) -> None:
        self.app = app
        self.pilot = pilot

    @property
    def text(self) -> str:
        """All that is to be seen."""
        strips = self.app.screen._compositor.render_strips()
        return '\n'.join(strip.text for strip in strips)

    async def types(self, *keys: str) -> 'Shown':
        await self.pilot.press(*keys)
        return self

    async def until(self, condition: Callable[[], object]) -> None:
        loop = asyncio.get_running_loop()
        deadline = loop.time() + DEADLINE
        while not condition():
            assert loop.time() < deadline, self.text
            await self.pilot.pause(0.02)

    async def shows(self, *texts: str) -> 'Shown':
        await self.until(lambda: all(text in self.text for text in texts))
        return self

    async def hides(self, text: str) -> 'Shown':
        await self.until(lambda: text not in self.text)
        return self


def run_app(
    app: LaunchApp,
    act: Callable[[Shown], Awaitable[Any]],
    size: tuple[int, int] = (100, 24),
) -> None:
    """Run the app on a screen in memory."""

    async def run() -> None:
        async with app.run_test(size=size) as pilot:
            await act(Shown(app, pilot))
            app.panes.close()

    asyncio.run(run())
    assert app.error is None, app.error
