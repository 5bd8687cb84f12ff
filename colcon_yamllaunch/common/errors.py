# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What goes wrong in a workspace."""


class WorkspaceError(RuntimeError):
    """
    Something that the user can put right, told in one message.

    It is a RuntimeError because colcon shows these without a traceback.
    """
