#!/usr/bin/env python3
# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Fail after a moment, as hardware does that is not plugged in."""

import sys
import time

import rclpy
from rclpy.node import Node

rclpy.init()
node = Node('gripper')
node.get_logger().info('closing')
time.sleep(1.0)
node.get_logger().error('no answer from the motor')
sys.exit(1)
