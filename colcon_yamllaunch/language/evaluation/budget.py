# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The limits of a launch, so that no launch file takes all time or memory."""

from collections.abc import Callable, Sequence

from colcon_yamllaunch.language.evaluation.scope import joined, Value
from colcon_yamllaunch.language.syntax.diagnostics import error, LaunchError
from colcon_yamllaunch.plan.position import Position

#: How many launch files may be open inside of one another.
MAXIMUM_INCLUDE_DEPTH = 40
#: How many actions a launch may have.
MAXIMUM_ACTIONS = 200_000
#: How many characters a text may have, and all texts that a launch makes.
#: A text that is twice what it was has 10^17 times as many after 59 steps.
MAXIMUM_TEXT = 16_000_000
MAXIMUM_TEXTS = 128_000_000
#: What is wrong when launch files include one another without end.
DEPTH_PROBLEM = (
    f'more than {MAXIMUM_INCLUDE_DEPTH} launch files include one another'
)
_RECURSION_HINT = 'does a launch file include itself?'


class EndlessError(Exception):
    """The launch exceeds a limit, which was reported."""


def too_deep(position: Position) -> LaunchError:
    """Return the error of launch files that include one another for ever."""
    return error(DEPTH_PROBLEM, position, hint=_RECURSION_HINT)


class Budget:
    """
    Counts what a launch makes towards the limits.

    :param report: Reports the error when it exceeds one
    :param adds_up: Whether all texts count together; a check, which may
      evaluate a text several times, limits each one
    """

    def __init__(
        self, report: Callable[[LaunchError], object], *, adds_up: bool
    ) -> None:
        self._report = report
        self._adds_up = adds_up
        self._actions = 0
        self._characters = 0

    def count_action(self, position: Position) -> None:
        """
        Count an action or a loop iteration.

        :raises EndlessError: when there are too many
        """
        self._actions += 1
        if self._actions > MAXIMUM_ACTIONS:
            self._end(
                f'the launch has more than {MAXIMUM_ACTIONS} actions',
                position,
                _RECURSION_HINT,
            )

    def join(
        self, pieces: Sequence[Value | str], position: Callable[[], Position]
    ) -> Value:
        """
        Return values and texts one behind the other.

        :param position: Gives the place that makes it
        :raises EndlessError: when that is too long
        """
        characters = 0
        for piece in pieces:
            text = piece if isinstance(piece, str) else piece.text
            characters += 0 if text is None else len(text)
        self.spend(characters, position)
        return joined(pieces)

    def spend(self, characters: int, position: Callable[[], Position]) -> None:
        """
        Count a text that is about to be created.

        :param position: Gives the place that makes it
        :raises EndlessError: when it is too long
        """
        if self._adds_up:
            self._characters += characters
        if characters > MAXIMUM_TEXT:
            self._end(
                f'this makes a text of more than {MAXIMUM_TEXT} characters',
                position(),
                'does each value have the one before it more than once?',
            )
        if self._characters > MAXIMUM_TEXTS:
            self._end(
                f'the launch makes texts of more than {MAXIMUM_TEXTS} '
                'characters in all',
                position(),
            )

    def _end(
        self, message: str, position: Position, hint: str | None = None
    ) -> None:
        self._report(error(message, position, hint=hint))
        raise EndlessError
