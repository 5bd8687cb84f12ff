# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
`--watch`: changes of files become changes of the running launch.

- `watcher` is a process that watches files, and the launcher's side of it. It
  reports changes; `watched_files` compares the contents of files.
- `dependencies` finds the files that the launch uses; `python_syntax` finds
  syntax errors in those of Python.
- `consequences` returns what follows from changes, as data.
- `preparer` is a process that prepares the launch again: it builds and
  evaluates.
- `change_loop` ties these together and changes the launch; start reading
  there. `pending_changes` are the changes that it is handling.
- `until_checks` checks `--until` after each change.

`verb/watch_launch.py` does the jobs of the preparer.
"""
