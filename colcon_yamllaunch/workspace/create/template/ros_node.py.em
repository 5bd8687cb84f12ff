@[if is_script]@
#!/usr/bin/env python3
@[end if]@
"""The node `@(node)`: it greets again and again."""

import rclpy
import rclpy.executors
import rclpy.node


class @(class_name)(rclpy.node.Node):
    """Log a greeting every so often, and count how often."""

    def __init__(self):
        super().__init__('@(node)')
        # Parameters are declared with their defaults. What the launch file or
        # `--ros-args -p period:=0.5` says goes before these.
        self.declare_parameter('greeting', 'Hello')
        self.declare_parameter('period', 1.0)  # seconds
        self.count = 0
        period = self.get_parameter('period').value
        self.timer = self.create_timer(period, self.greet)

    def greet(self):
        """Log the greeting once."""
        self.count += 1
        greeting = self.get_parameter('greeting').value
        self.get_logger().info(f'{greeting} {self.count}')


def main():
    try:
        rclpy.init()
        rclpy.spin(@(class_name)())
    except (KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
        pass  # Ctrl-C or SIGTERM: the usual way for a node to end
    finally:
        rclpy.try_shutdown()


if __name__ == '__main__':
    main()
