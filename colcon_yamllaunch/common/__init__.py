# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
General helpers without knowledge of launches; they import nothing else.

- Data: `frozen` makes dataclasses, `codec` turns them into JSON and back.
- Files: `text_files` and `json_files` read and write them, `file_sync` makes
  them survive a power cut, `fingerprint` notices changes, `temporary_folders`
  and `search_path` find folders.
- Processes: `process_scan` reads /proc, `adoption` and `prctl` are about
  parents and children, `escalation` has the steps of stopping.
- Messages: `errors` declares exceptions, `suggestions` finds "did you mean",
  `printable` makes texts of others safe, `table` formats columns and sizes.
"""
