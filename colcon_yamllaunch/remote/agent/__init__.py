# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The program on a machine.

It needs only Python's standard library. :mod:`.machine_agent` answers requests
before the launch, through :mod:`.launcher_channel`. :mod:`.part` runs a part
while the launcher holds it, and stops it when the launcher is lost (`on_lost:
stop`); the guard does so if the engine hangs (the lease, see
`control/service`). :mod:`.part_link` is the relay between the connection and
the control socket of the part. :mod:`.part_sockets` finds parts that run, and
stops what is left of others.
"""
