# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The tables of the language: actions, substitutions, types of values.

`actions` and `substitutions` are the tables, `parameter` has the values of
node parameters, and `json_schema` makes a schema for editors from the tables.
"""
