# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
From the bytes of a launch file to the tree of its actions.

- `source_text` knows where each text stands. `yaml_reader` and `xml_reader`
  make the same values, and `text` finds the substitutions in them.
- `launch_tree` makes actions of the values. It also reports unknown
  attributes, with "did you mean" (`_report_unknown`).
- `diagnostics` shows problems, and `errors` explains syntax errors.
"""
