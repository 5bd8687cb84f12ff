#!/usr/bin/env python3
# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Publish on `throttle` what the keyboard says, key by key."""

from collections.abc import Iterator
from contextlib import contextmanager
import os
import re
import select
import signal
import sys
import termios

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import Int16

HELP = 'up or + for more, down or - for less, 0 for none, q to end'
LIMIT = 100  # per cent, forwards and backwards
STEP = 10
# What terminals send for a key is one byte or a sequence of them, and fast
# keys come together.
KEY = re.compile(rb'\x1b\[[A-D]|.', re.DOTALL)
STEPS = {
    b'+': STEP,
    b'\x1b[A': STEP,  # the key up
    b'-': -STEP,
    b'\x1b[B': -STEP,  # the key down
}
PATIENCE = 0.1  # seconds without a key before ROS gets its turn


class Throttle(Node):
    """Keep the throttle where the last key left it."""

    def __init__(self) -> None:
        super().__init__('throttle')
        self.publisher = self.create_publisher(Int16, 'throttle', 10)
        self.value = 0

    def press(self, key: bytes) -> None:
        """Do what a key says; other keys say nothing."""
        if key == b'0':
            self.value = 0
        elif key in STEPS:
            value = self.value + STEPS[key]
            self.value = max(-LIMIT, min(LIMIT, value))
        else:
            return
        print(f'Throttle at {self.value} %')
        self.publisher.publish(Int16(data=self.value))


@contextmanager
def single_keys(keyboard: int) -> Iterator[None]:
    """Get each key at once and unseen; leave the terminal as it was."""
    before = termios.tcgetattr(keyboard)
    now = termios.tcgetattr(keyboard)
    now[3] &= ~(termios.ICANON | termios.ECHO)
    termios.tcsetattr(keyboard, termios.TCSANOW, now)
    try:
        yield
    finally:
        termios.tcsetattr(keyboard, termios.TCSANOW, before)


def follow(node: Throttle, keyboard: int) -> None:
    """Pass on keys until one ends the program."""
    while rclpy.ok():
        ready, _, _ = select.select([keyboard], [], [], PATIENCE)
        keys = os.read(keyboard, 1024) if ready else b''
        if ready and not keys:
            return
        for key in KEY.findall(keys):
            if key == b'q':
                return
            node.press(key)
        rclpy.spin_once(node, timeout_sec=0)


def main() -> None:
    keyboard = sys.stdin.fileno()
    if not os.isatty(keyboard):
        sys.exit(
            'throttle: there is no keyboard; launch it so: '
            'colcon launch --attach throttle my_pkg throttle.yaml'
        )
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        rclpy.init()
        node = Throttle()
        print(HELP)
        with single_keys(keyboard):
            follow(node, keyboard)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # Ctrl-C or SIGTERM: the usual way for a node to end
    finally:
        rclpy.try_shutdown()


if __name__ == '__main__':
    main()
