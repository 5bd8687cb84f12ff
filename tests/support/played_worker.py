# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A worker of launch files in Python that is played, within the test."""

from collections.abc import Callable, Generator, Mapping
from typing import Any

Message = dict[str, Any]
#: What comes of a request: messages, of which those that ask get an answer;
#: at last the end of the answer, or None to leave the scope as it is.
Play = Generator[Message, Message, Message | None]


class PlayedWorker:
    """
    Answers as the program of the worker does.

    :param play: Plays the answer to a request
    """

    def __init__(self, play: Callable[[Message], Play]) -> None:
        self._play = play
        #: The requests in order, without their numbers.
        self.requests: list[Message] = []
        # the answers that have no end, innermost last
        self._open: list[tuple[Message, Play]] = []
        self._answers: list[Message] = []
        self.where: Message = {}

    def send(self, message: Mapping[str, Any]) -> None:
        """Take a message of the launcher."""
        message = dict(message)
        if 'answer' in message:
            self._answers.append(message)
            return
        number = message.pop('id')
        self.requests.append(message)
        if message['do'] != 'start':
            request = {**message, 'id': number}
            self._open.append((request, self._play(message)))

    def receive(self) -> Message:
        """Return the next message."""
        request, play = self._open[-1]
        try:
            if self._answers:
                return play.send(self._answers.pop())
            return next(play)
        except StopIteration as end:
            self._open.pop()
            done = end.value or {'scope': request.get('scope')}
            return {'say': 'done', 'id': request['id'], **done}

    def doing(self) -> Message:
        """Return what it is doing, as the test says."""
        return self.where

    def overtaken(self) -> Play:
        """Answer the request before the one that is being answered."""
        request, play = self._open.pop(-2)
        end = yield from play
        yield {'say': 'done', 'id': request['id'], **(end or {})}
        return None

    def answers(self) -> list[Message]:
        """Return all that comes of what was sent, up to its end."""
        messages = []
        while self._open:
            messages.append(self.receive())
        return messages


def process(number: int, program: str = 'talker', **fields: Any) -> Message:
    """Return what is told of a process."""
    return {
        'say': 'process',
        'id': number,
        'program': program,
        'argv': [f'/bin/{program}'],
        'cwd': None,
        'environment': {},
        'output': 'screen',
        'package': None,
        'node': None,
        **fields,
    }


def position(file: object, line: int = 1, column: int = 1) -> list[object]:
    """Return a position as messages have them."""
    return [str(file), line, column]
