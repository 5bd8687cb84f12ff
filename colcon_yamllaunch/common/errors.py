# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What goes wrong, and is told in one message."""


class UserError(RuntimeError):
    """
    Something that the user can put right, such as the command line.

    It is a RuntimeError because colcon shows these without a traceback.
    """


class WorkspaceError(UserError):
    """What goes wrong in a workspace."""


class OutputError(UserError):
    """
    Standard output does not take what it is to show.

    That nobody reads it any more, as behind `| head`, is none.
    """

    def __init__(self, reason: OSError) -> None:
        super().__init__(
            f'the output cannot be written: {reason.strerror or reason}'
        )
