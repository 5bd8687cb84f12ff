#!/usr/bin/env python3
# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Launch demo.yaml of sample_ws and stop it when its nodes have talked a while.

The exit code is 0 only if a message crossed and the launch ended with 0.
"""

import os
from pathlib import Path
import pty
import random
import select
import signal
import subprocess
import sys
import time

SAMPLE_WS = Path(__file__).resolve().parents[1] / 'sample_ws'
COMMAND = ('colcon', 'launch', 'my_pkg', 'demo.yaml')
#: What `double` prints for the first message that it receives.
FIRST_MESSAGE = b' which double is '
#: Seconds that the nodes talk for.
TALK_TIME = 15
#: Seconds until the first message, which on a first run wait for the build.
START_TIMEOUT = 600
#: Seconds from Ctrl-C to the end of the output.
STOP_TIMEOUT = 60
#: Seconds from the end of the output to the end of the process.
EXIT_TIMEOUT = 10


class Demo:
    """
    A running launch and the output that it makes.

    :ivar at_end: Whether the output has ended
    """

    def __init__(self) -> None:
        self.at_end = False
        # A terminal for a terminal, so that the launch shows its colours.
        self._output, child_end = (
            pty.openpty() if sys.stdout.isatty() else os.pipe()
        )
        domain_id = os.environ.get('ROS_DOMAIN_ID') or str(
            random.randint(1, 101)
        )
        self._launch = subprocess.Popen(
            COMMAND,
            cwd=SAMPLE_WS,
            env=os.environ
            | {
                'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
                'ROS_DOMAIN_ID': domain_id,
            },
            stdin=subprocess.DEVNULL,
            stdout=child_end,
            stderr=child_end,
            start_new_session=True,
        )
        os.close(child_end)

    def show(self, seconds: float, until: bytes | None = None) -> bool:
        """
        Pass the output on for so long, or until some text was in it.

        :returns: Whether the text was there
        """
        deadline = time.monotonic() + seconds
        recent = b''
        while (left := deadline - time.monotonic()) > 0:
            if not select.select([self._output], [], [], left)[0]:
                break
            chunk = self._read()
            if not chunk:
                self.at_end = True
                break
            sys.stdout.buffer.write(chunk)
            sys.stdout.flush()
            if until is not None:
                recent = recent[-len(until) :] + chunk
                if until in recent:
                    return True
        return False

    def _read(self) -> bytes:
        try:
            return os.read(self._output, 65536)
        except OSError:
            # Linux's word for the end of what a terminal's other side says.
            return b''

    def press_ctrl_c(self) -> None:
        """Do to the launch what Ctrl-C does."""
        self._launch.send_signal(signal.SIGINT)

    def end(self) -> int:
        """Wait for the end, show what is left, return the exit code."""
        self.show(STOP_TIMEOUT)
        try:
            return self._launch.wait(EXIT_TIMEOUT)
        except subprocess.TimeoutExpired:
            self._launch.kill()
            return self._launch.wait()


def main() -> int | str:
    """Run the demo and return 0, or what went wrong."""
    # Also where SIGINT is ignored, as in a script's background job: the launch
    # would inherit that and not hear the Ctrl-C below.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    demo = Demo()
    crossed = False
    try:
        crossed = demo.show(START_TIMEOUT, FIRST_MESSAGE)
        if crossed:
            demo.show(TALK_TIME)
    except KeyboardInterrupt:
        print('demo: stopping')
    ended_early = demo.at_end
    demo.press_ctrl_c()
    code = demo.end()
    if not crossed:
        return f'demo: no message crossed (exit code {code})'
    if ended_early or code != 0:
        return f'demo: the launch failed with exit code {code}'
    if not demo.at_end:
        return 'demo: the launch ended and left a process running'
    print('demo: messages crossed, everything is stopped')
    return 0


if __name__ == '__main__':
    sys.exit(main())
