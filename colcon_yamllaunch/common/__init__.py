# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
General helpers without knowledge of launches; they import nothing else.

- Data: `frozen` makes dataclasses, `codec` turns them into JSON and back.
- Files: `files` reads and writes them and finds folders for temporary ones,
  `fingerprint` notices changes.
- Processes: `process_scan` reads /proc, `adoption` is about parents and
  children, `escalation` has the steps of stopping.
- Messages: `messages` prints them, `errors` declares exceptions, `suggestions`
  finds "did you mean", `printable` makes texts of others safe, `table` formats
  columns and sizes.
"""
