# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What goes wrong, and is told in one message."""


class UserError(RuntimeError):
    """
    Something that the user can put right, such as the command line.

    It is a RuntimeError because colcon shows these without a traceback.

    :param problem: What is wrong
    :param hint: How to fix it, if that is known
    :param place: The file that is wrong, with the line if that is known
    """

    def __init__(
        self,
        problem: str,
        hint: str | None = None,
        *,
        place: str | None = None,
    ) -> None:
        super().__init__(': '.join(filter(None, (place, problem, hint))))
        self.problem = problem
        self.hint = hint
        self.place = place

    def lines(self, command: str) -> str:
        """
        Return what to show, in the format of errors in launch files.

        :param command: What stands in front where no file is wrong
        """
        text = f'{self.place or command}: error: {self.problem}'
        if self.hint is None:
            return text
        # further lines, such as those of a list, belong to it
        hint = self.hint.replace('\n', '\n  ')
        return f'{text}\n  help: {hint}'


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


class RefusedError(Exception):
    """A launch refuses a command; the text says why, in one line."""
