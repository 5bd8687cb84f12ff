# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The plan of a launch with event handlers, which grows while it runs."""

from collections import deque

from colcon_yamllaunch.language.evaluation.budget import EndlessError
from colcon_yamllaunch.language.evaluation.request import WorkerMessage
from colcon_yamllaunch.language.evaluation.scope import AlreadyReportedError
from colcon_yamllaunch.language.evaluation.walk import Walk
from colcon_yamllaunch.language.python_files.python_visit import python_error
from colcon_yamllaunch.language.python_files.worker_dialogue import (
    Intake,
    WorkerDialogue,
)
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError, render
from colcon_yamllaunch.plan.labels import with_labels
from colcon_yamllaunch.plan.plan import Growth, Message, Plan
from colcon_yamllaunch.plan.position import Position


class GrowingLaunch:
    """
    Turns the messages of the worker into plan while the plan runs.

    The owner of the connection to the worker sends events with :meth:`ask` and
    passes messages to :meth:`handle`, in order.

    :param plan: The plan before it runs
    """

    def __init__(
        self, walk: Walk, dialogue: WorkerDialogue, plan: Plan
    ) -> None:
        self._walk = walk
        self._dialogue = dialogue
        self._start = Position(next(iter(walk.files.python), ''), 1, 1)
        self._labels: set[str] = set()
        self._reserve_labels(plan)
        walk.draft.entries = []
        # what has a name may have ended when something else gets it
        walk.nodes.clear()
        dialogue.passed.clear()
        self._reported_count = len(walk.diagnostics)
        # the requests without an answer, with the blocks that asked
        self._asked: deque[tuple[int, int | None]] = deque()
        self._intake: Intake | None = None

    @property
    def has_handlers(self) -> bool:
        """Whether there are event handlers now."""
        return self._dialogue.has_handlers

    @property
    def wants_output(self) -> frozenset[str]:
        """What ROS 2 calls the processes whose output the worker wants."""
        return self._dialogue.wants_output

    @property
    def is_busy(self) -> bool:
        """Whether the end of an answer is still to come."""
        return bool(self._asked)

    def id_of(self, name: str) -> int | None:
        """
        Return the number by which the worker knows a process.

        :param name: Its `ros_name`; None is returned for one of a YAML file
        """
        return self._dialogue.ids.get(name)

    def ask(self, request: WorkerMessage) -> None:
        """
        Send a request, `event` or `call`, without its number.

        :raises WorkerError: when there is no worker any more
        """
        block = None
        if self._walk.draft.blocks:
            # that of the launch itself
            block = 0
        if request['do'] == 'call':
            block = self._dialogue.calls.pop(request['number'], block)
        self._asked.append((self._dialogue.send(request), block))

    def handle(self, message: WorkerMessage) -> Growth | None:
        """
        Handle a message, and return what a whole answer adds to the plan.

        It waits for the worker only where a YAML or XML file that is included
        now includes one in Python.

        :return: None for all messages but `done`
        :raises WorkerError: when there is no worker any more
        """
        if self._intake is None:
            if self._asked:
                self._walk.draft.reopen_block(self._asked[0][1])
            self._intake = Intake(self._dialogue, self._start)
        if message.get('say') != 'done':
            self._intake.receive(message)
            return None
        # others may have been answered while a YAML file that was included
        # asked for something
        ends, self._dialogue.passed = [*self._dialogue.passed, message], []
        # answers come in order
        last = max(end.get('id', 0) for end in ends)
        while self._asked and self._asked[0][0] <= last:
            self._asked.popleft()
        problems = []
        try:
            self._intake.finish()
        except LaunchError as e:
            located, ends = self._walk.located(e), []
            problems = [render(located.diagnostics, self._walk.cwd)]
        except (AlreadyReportedError, EndlessError):
            pass
        for end in ends:
            problems += self._problems(end)
        return self._growth(problems)

    def lost(self, reason: str) -> Growth:
        """
        Note that the worker has ended; unfinished answers count.

        :param reason: What became of it, as a line; empty if it was to end
        """
        self._asked.clear()
        self._dialogue.forget_handlers()
        self._dialogue.calls.clear()
        return self._growth([reason] if reason else [])

    def _problems(self, message: WorkerMessage) -> list[str]:
        if 'error' in message:
            problem = python_error(self._walk, message['error'], self._start)
            return [render(problem.diagnostics, self._walk.cwd)]
        if 'refused' in message:
            return [f'{self._start.path}: {message["refused"]}']
        return []

    def _growth(self, problems: list[str]) -> Growth:
        walk = self._walk
        if self._intake is not None:
            self._intake.close()
            self._intake = None
        entries, walk.draft.entries = walk.draft.entries, []
        for diagnostic in walk.diagnostics[self._reported_count :]:
            text = render([diagnostic], walk.cwd)
            if diagnostic.severity == 'error':
                problems.append(text)
            else:
                entries.insert(0, Message('WARNING', text))
        self._reported_count = len(walk.diagnostics)
        walk.nodes.clear()
        grown = with_labels(Plan(tuple(entries)), self._labels)
        self._reserve_labels(grown)
        return Growth(grown.entries, tuple(problems), tuple(walk.draft.blocks))

    def _reserve_labels(self, plan: Plan) -> None:
        self._labels.update(p.label for p in plan.processes())
        self._labels.update(c.label for c in plan.components())
        self._walk.draft.reserve_labels(self._labels)
