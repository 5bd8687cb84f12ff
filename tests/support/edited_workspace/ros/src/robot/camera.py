#!/usr/bin/env python3
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.lifecycle import LifecycleNode

class Camera(LifecycleNode):
    def on_activate(self, state):
        word = self.declare_parameter('word', '').value
        print('camera says', 'v0', word, flush=True)
        return super().on_activate(state)

try:
    rclpy.init()
    rclpy.spin(Camera('camera'))
except (KeyboardInterrupt, ExternalShutdownException):
    pass
