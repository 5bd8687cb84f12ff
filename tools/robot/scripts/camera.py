#!/usr/bin/env python3
# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Log a frame twice a second; each fourth one is dark."""

import rclpy
from rclpy.node import Node


class Camera(Node):
    """Count frames."""

    def __init__(self) -> None:
        super().__init__('camera')
        self.frame = 0
        self.create_timer(0.5, self.take)

    def take(self) -> None:
        """Take a frame."""
        self.frame += 1
        if self.frame % 4:
            self.get_logger().info(f'frame {self.frame}')
        else:
            self.get_logger().warning(f'frame {self.frame} is dark')


rclpy.init()
rclpy.spin(Camera())
