#!/usr/bin/env python3
# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Ask for the names of places."""

import rclpy
from rclpy.node import Node

rclpy.init()
node = Node('mapper')
place = input('Name of this place: ')
while place:
    node.get_logger().info(f'this is the {place}')
    place = input('Name of the next place: ')
