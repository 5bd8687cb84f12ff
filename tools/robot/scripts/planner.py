#!/usr/bin/env python3
# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Take most of a processor, also of a busy one, and log once a second."""

import hashlib
import threading
import time

import rclpy
from rclpy.node import Node

THREADS, SHARE = 4, 0.22
MAP = bytes(1_000_000)


class Planner(Node):
    """Count plans."""

    def __init__(self) -> None:
        super().__init__('planner')
        self.plan = 0
        self.create_timer(1.0, self.tell)

    def tell(self) -> None:
        """Tell of a plan."""
        self.plan += 1
        steps = 12 + self.plan % 5
        self.get_logger().info(f'plan {self.plan} has {steps} steps')


def spend() -> None:
    """Take a share of a processor."""
    while True:
        due = time.monotonic() + 1.0
        end = time.thread_time() + SHARE
        while time.thread_time() < end and time.monotonic() < due:
            # other threads run meanwhile
            hashlib.sha256(MAP).digest()
        time.sleep(max(0.0, due - time.monotonic()))


for _ in range(THREADS):
    threading.Thread(target=spend, daemon=True).start()
rclpy.init()
rclpy.spin(Planner())
