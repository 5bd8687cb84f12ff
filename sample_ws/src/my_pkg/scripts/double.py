#!/usr/bin/env python3
# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Print twice the number that arrives on `count`."""

import argparse
from pathlib import Path
import signal
import sys

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy
from rclpy.qos import QoSProfile
from rclpy.utilities import remove_ros_args
from std_msgs.msg import UInt16

# As the counter publishes: what it sent before this node was up arrives too.
COUNT_QOS = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Double(Node):
    """Listen to the counter."""

    def __init__(self) -> None:
        super().__init__('double')
        self.subscription = self.create_subscription(
            UInt16, 'count', self.print_double, COUNT_QOS
        )

    def print_double(self, message: UInt16) -> None:
        """Print one line for a number."""
        count = message.data
        print(f'Received {count} which double is {count * 2}')


def parse_arguments() -> argparse.Namespace:
    """Read the node's own command line, that is, all that ROS 2 leaves."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        '-d',
        dest='description',
        metavar='FILE',
        type=Path,
        help='print the text in this file at the start',
    )
    return parser.parse_args(remove_ros_args(sys.argv)[1:])


def main() -> None:
    arguments = parse_arguments()
    if arguments.description:
        try:
            print(arguments.description.read_text().strip())
        except OSError as error:
            sys.exit(f'double: {error}')

    # On SIGTERM, rclpy ends its context at once, maybe in the midst of a
    # callback. As KeyboardInterrupt it is as clean an end as Ctrl-C is.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        rclpy.init()
        rclpy.spin(Double())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # Ctrl-C or SIGTERM: the usual way for a node to end
    finally:
        rclpy.try_shutdown()


if __name__ == '__main__':
    main()
