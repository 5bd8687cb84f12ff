# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The plan of a launch: data, ready to be run, shown or stored.

Start with :mod:`.plan`, which has the plan and its parts. :mod:`.labels` names
its processes and components, and :mod:`.position` says where they are written.
:mod:`.plan_difference` compares two plans. A plan is written as text
(:mod:`.plan_text`), JSON (:mod:`.plan_json`, which also reads it), a script
for bash (:mod:`.plan_script`) or a drawing (:mod:`.plan_graph`).
"""
