#!/usr/bin/env python3
# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Take most of a processor, and tell of it once a second."""

import time

import rclpy
from rclpy.node import Node

rclpy.init()
node = Node('planner')
plan = 0
while rclpy.ok():
    plan += 1
    node.get_logger().info(f'plan {plan} has {12 + plan % 5} steps')
    due = time.monotonic() + 1.0
    while time.monotonic() < due - 0.05:
        pass
    time.sleep(0.05)
