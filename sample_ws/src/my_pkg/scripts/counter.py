#!/usr/bin/env python3
# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Publish a number on `count` once a second."""

import signal
import sys
from typing import Any

import rclpy
from rclpy.exceptions import InvalidParameterTypeException
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy
from rclpy.qos import QoSProfile
from std_msgs.msg import UInt16

PERIOD = 1.0  # seconds
UINT16_RANGE = 2**16

# The last ten numbers are kept for a listener that starts later than this.
COUNT_QOS = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Counter(Node):
    """Count in steps of the parameter `delta`, and start with 1."""

    def __init__(self) -> None:
        super().__init__('counter')
        # A node declares each parameter before it can read it: with a default,
        # which also fixes the type, or with a type alone.
        self.declare_parameter('my_int', 42)
        self.declare_parameter('my_array', rclpy.Parameter.Type.DOUBLE_ARRAY)
        self.declare_parameter('delta', 1)
        for name in ('my_int', 'my_array', 'delta'):
            print(f'{name}: {self.read(name)}')

        self.count = 1
        self.publisher = self.create_publisher(UInt16, 'count', COUNT_QOS)
        self.timer = self.create_timer(PERIOD, self.publish_count)

    def read(self, name: str) -> Any:
        """Return a parameter's value, None if it has none."""
        return self.get_parameter_or(name).value

    def publish_count(self) -> None:
        """Publish the count, then step it."""
        print(f'Publishing {self.count}')
        self.publisher.publish(UInt16(data=self.count))
        # Read each time, so that `ros2 param set` works while the node runs.
        # UInt16 ends at 65535: go on from 0, as its arithmetic does.
        self.count = (self.count + self.read('delta')) % UINT16_RANGE


def main() -> None:
    # On SIGTERM, rclpy ends its context at once, maybe in the midst of a
    # callback. As KeyboardInterrupt it is as clean an end as Ctrl-C is.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        rclpy.init()
        rclpy.spin(Counter())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # Ctrl-C or SIGTERM: the usual way for a node to end
    except InvalidParameterTypeException as error:
        sys.exit(f'counter: {error}')
    finally:
        rclpy.try_shutdown()


if __name__ == '__main__':
    main()
