# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Print the square of the number that arrives on `number`."""

import signal

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import UInt16


class Square(Node):
    """Listen to numbers."""

    def __init__(self) -> None:
        super().__init__('square')
        self.subscription = self.create_subscription(
            UInt16, 'number', self.print_square, 10
        )

    def print_square(self, message: UInt16) -> None:
        """Print one line for a number."""
        number = message.data
        print(f'Received {number} whose square is {number**2}')


def main() -> None:
    """Run the node until it is stopped."""
    # On SIGTERM, rclpy ends its context at once, maybe in the midst of a
    # callback. As KeyboardInterrupt it is as clean an end as Ctrl-C is.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        rclpy.init()
        rclpy.spin(Square())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # Ctrl-C or SIGTERM: the usual way for a node to end
    finally:
        rclpy.try_shutdown()
