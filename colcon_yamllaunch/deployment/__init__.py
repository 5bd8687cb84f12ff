# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The deployment file of `--deploy`, and what it does to a plan.

Only launches with `--deploy` or `--on` import this.

- :mod:`.deployment_file` reads the file into a :mod:`.deployment`: machines,
  and rules for processes. :mod:`.process_settings` reads what a rule sets,
  :mod:`.machine_settings` what a machine has, and :mod:`.values` the values in
  both, with their errors.
- :mod:`.applied_settings` gives the processes and components of a plan their
  settings, and puts what waits for others behind that
  (`plan.plan.AfterReady`).
- :mod:`.json_schema` describes the file to editors.
- :mod:`.placement` divides a plan into the parts of the machines.
"""
