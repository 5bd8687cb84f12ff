# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Components, well-behaved ones and others."""

import os
import time

from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String


def _value(node, name, default):
    """Return a parameter that may have been given or not."""
    if not node.has_parameter(name):
        node.declare_parameter(name, default)
    return node.get_parameter(name).value


class Talker(Node):
    """Publishes and prints a line every `period` seconds."""

    def __init__(self, **options):
        super().__init__('talker', **options)
        self._count = 0
        self._publisher = self.create_publisher(String, 'chatter', 10)
        self.create_timer(_value(self, 'period', 1.0), self._talk)

    def _talk(self):
        self._count += 1
        text = f'Hello World: {self._count}'
        print(f"{self.get_fully_qualified_name()}: '{text}'", flush=True)
        self._publisher.publish(String(data=text))


class Listener(Node):
    """Prints what it hears."""

    def __init__(self, **options):
        super().__init__('listener', **options)
        self.create_subscription(String, 'chatter', self._hear, 10)

    def _hear(self, message):
        name = self.get_fully_qualified_name()
        print(f'{name}: I heard: [{message.data}]', flush=True)


class Slow(Node):
    """Takes `seconds` for its constructor."""

    def __init__(self, **options):
        super().__init__('slow', **options)
        time.sleep(_value(self, 'seconds', 1.0))


class Throwing(Node):
    """Throws `text` in its constructor."""

    def __init__(self, **options):
        super().__init__('throwing', **options)
        raise RuntimeError(_value(self, 'text', 'no such device'))


class Crashing(Node):
    """Ends the container by its constructor."""

    def __init__(self, **options):
        super().__init__('crashing', **options)
        os._exit(_value(self, 'code', 7))


class CrashingLater(Node):
    """Ends the container after `seconds`."""

    def __init__(self, **options):
        super().__init__('crashing_later', **options)
        self.create_timer(_value(self, 'seconds', 0.5), self._crash)

    def _crash(self):
        os._exit(_value(self, 'code', 7))


class Lifecycle(LifecycleNode):
    """
    Has states.

    A transition takes `seconds`; the one named by the parameter `fails` fails,
    the one named by `throws` throws an exception. The first answer of the
    service named by `loses` gets lost.
    """

    def __init__(self, **options):
        super().__init__('lifecycle', **options)
        loses = _value(self, 'loses', '')
        for service in self.services:
            if loses and service.srv_name.endswith(f'/{loses}'):
                self._lose_answer(service)

    def _lose_answer(self, service):
        def lose(*_):
            del service.send_response

        service.send_response = lose

    def on_configure(self, state):
        return self._change('configure')

    def on_activate(self, state):
        return self._change('activate')

    def on_deactivate(self, state):
        return self._change('deactivate')

    def on_cleanup(self, state):
        return self._change('cleanup')

    def on_shutdown(self, state):
        return self._change('shutdown')

    def _change(self, transition):
        name = self.get_fully_qualified_name()
        print(f'{name}: {transition}', flush=True)
        time.sleep(_value(self, 'seconds', 0.0))
        if _value(self, 'throws', '') == transition:
            raise RuntimeError(f'{transition} threw')
        if _value(self, 'fails', '') == transition:
            return TransitionCallbackReturn.FAILURE
        return TransitionCallbackReturn.SUCCESS


class Ticking(Node):
    """Publishes the time of a simulation on /clock, from second 10 on."""

    def __init__(self, **options):
        super().__init__('ticking', **options)
        self._ticks = 0
        self._publisher = self.create_publisher(Clock, '/clock', 10)
        self.create_timer(0.005, self._tick)

    def _tick(self):
        self._ticks += 1
        clock = Clock()
        clock.clock.sec, milliseconds = divmod(10_000 + 5 * self._ticks, 1000)
        clock.clock.nanosec = milliseconds * 1_000_000
        self._publisher.publish(clock)


class Parameters(Node):
    """Prints its parameters, one a line."""

    def __init__(self, **options):
        super().__init__('parameters', **options)
        for name, one in sorted(self._parameters.items()):
            print(f'{name}: {one.type_.name} {one.value}', flush=True)
