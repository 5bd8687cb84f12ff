# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The full screen (`--ui`), which uses only the control socket of a launch.

Start with :mod:`.launch_screen`, which draws the screen and handles its keys.
:mod:`.link` receives the state, events and output. :mod:`.launch_model` holds
them, :mod:`.output_store` the output, and :mod:`.output_view` the lines that
are shown.
"""
