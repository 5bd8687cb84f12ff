# Run them:    colcon test --packages-select @(name)
# When the node does something else, test that here instead.
"""Tests of the node `@(node)`."""

from pathlib import Path
@[if is_script]@
import sys
@[end if]@
import unittest

@[if not is_script]@
from @(module).@(node) import @(class_name)
@[end if]@
@[if is_ros]@
import rclpy
@[end if]@
@[if is_ros or not is_script]@

@[end if]@
PACKAGE = Path(__file__).parents[1]
@[if is_script]@
sys.path.insert(0, str(PACKAGE / 'scripts'))

@[if is_ros]@
from @(node) import @(class_name)  # noqa: E402
@[else]@
import @(node)  # noqa: E402
@[end if]@

@[end if]@
@[if is_ros]@
PARAMETERS = PACKAGE / 'config' / '@(name).yaml'


class @(class_name)Test(unittest.TestCase):

    def start(self, *arguments):
        rclpy.init(args=list(arguments))
        self.addCleanup(rclpy.shutdown)
        node = @(class_name)()
        self.addCleanup(node.destroy_node)
        return node

    def test_greetings_are_counted(self):
        node = self.start()
        node.greet()
        node.greet()
        self.assertEqual(node.count, 2)

    def test_parameter_file_is_read(self):
        node = self.start('--ros-args', '--params-file', str(PARAMETERS))
        greeting = node.get_parameter('greeting').value
        self.assertEqual(greeting, 'Hello from @(name)')
@[else]@
SETTINGS = PACKAGE / 'config' / '@(name).ini'


class @(class_name)Test(unittest.TestCase):

    def test_greetings_are_counted(self):
        self.assertEqual(@(node).greet({'greeting': 'Hi'}, 2), 'Hi 2')

    def test_settings_are_read(self):
        settings = @(node).read_settings(SETTINGS)
        self.assertEqual(settings['greeting'], 'Hello from @(name)')
@[end if]@


if __name__ == '__main__':
    unittest.main()
