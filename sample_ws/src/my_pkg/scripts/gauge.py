#!/usr/bin/env python3
# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Measure, and publish it on `level`, for as long as the node is active."""

import signal

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.lifecycle import LifecycleNode
from rclpy.lifecycle import LifecycleState
from rclpy.lifecycle import TransitionCallbackReturn
from std_msgs.msg import UInt16

SUCCESS = TransitionCallbackReturn.SUCCESS
FAILURE = TransitionCallbackReturn.FAILURE


class Gauge(LifecycleNode):
    """A node with states: each `on_…` is called for one of its transitions."""

    def __init__(self) -> None:
        super().__init__('gauge')
        self.declare_parameter('period', 1.0)
        self.level = 0

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Take what is needed, or leave the node as it was."""
        period = self.get_parameter('period').value
        if period <= 0:
            print(f'The period is {period} s, which is none')
            return FAILURE
        self.publisher = self.create_lifecycle_publisher(UInt16, 'level', 10)
        self.timer = self.create_timer(period, self.measure)
        self.timer.cancel()
        print(f'Configured for a measurement every {period} s')
        return super().on_configure(state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Begin to measure."""
        self.timer.reset()
        print('Activated')
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop measuring, but keep what is needed."""
        self.timer.cancel()
        print('Deactivated')
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Give back what was needed."""
        self.destroy_timer(self.timer)
        self.destroy_lifecycle_publisher(self.publisher)
        print('Cleaned up')
        return SUCCESS

    def measure(self) -> None:
        """Publish one number."""
        self.level += 1
        print(f'Measured {self.level}')
        self.publisher.publish(UInt16(data=self.level))


def main() -> None:
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        rclpy.init()
        rclpy.spin(Gauge())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # Ctrl-C or SIGTERM: the usual way for a node to end
    finally:
        rclpy.try_shutdown()


if __name__ == '__main__':
    main()
