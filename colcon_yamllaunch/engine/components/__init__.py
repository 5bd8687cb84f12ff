# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Components, lifecycle nodes and ROS time.

`composition` has the components and their containers, `lifecycles` the
lifecycle nodes, and `ros_timers` the timers on `/clock`. They receive calls of
the supervisor and messages of the client program, and send it requests.
`ros_client` is that program, which alone uses ROS, and `ros_link` runs it.

A load that its container refuses is not retried. A component is loaded again
when its container starts again (`Composition.started`), and when a container
came back without it or a new ROS client has started (`_request_open`).
`ros_client` sends a call again only if the container that got it has ended
(`_repeat`).
"""
