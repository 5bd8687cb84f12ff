# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The full screen (`--ui`), which uses only the control socket of a launch.

Start with :mod:`.session`, which opens the screen and gives the terminal back
at its end. :mod:`.launch_screen` handles the keys and draws the screen with
the widgets in :mod:`.widgets` and the texts in :mod:`.screen_texts`.
:mod:`.launch_model` receives the events and output of the launch;
:mod:`.output_store` keeps the output and selects the lines that are shown.
"""
