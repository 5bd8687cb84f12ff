# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
A launch as a service of systemd.

`unit` makes the text of a unit file from a plan; `verb.services` installs it.
When systemd runs the launch, `running` adds two participants: `notify` reports
to systemd what is ready and whether the launch is healthy, and `journald`
sends output to the journal. Other launches import nothing of this. Start
reading in `unit`.
"""
