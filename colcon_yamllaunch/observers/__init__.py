# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The observers of a launch: each receives its events through `handle(event)`.

:mod:`.screen` shows the launch on a stream, with the :mod:`.start_table` on a
terminal; :mod:`.presentation` describes the stream and selects what is shown.
:mod:`.log_levels` finds the level of a line. :mod:`.log_files` writes the logs
of a launch, and :mod:`.log_store` deletes those of earlier ones.
:mod:`.failures` collects what failed, :mod:`.failure_advice` says what to do
about it, and :mod:`.junit` writes the report. :mod:`.timeline` shows how a
launch that has ended, or runs, has started, from its event log.
"""
