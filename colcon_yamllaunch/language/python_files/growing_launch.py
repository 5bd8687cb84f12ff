# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What comes to a plan while it runs."""

from collections import deque
from dataclasses import replace

from colcon_yamllaunch.language.evaluation.launch_worker import WorkerMessage
from colcon_yamllaunch.language.evaluation.values import AlreadyReportedError
from colcon_yamllaunch.language.evaluation.walk import EndlessError
from colcon_yamllaunch.language.evaluation.walk import Walk
from colcon_yamllaunch.language.python_files.python_errors import python_error
from colcon_yamllaunch.language.python_files.worker_dialogue import Intake
from colcon_yamllaunch.language.python_files.worker_dialogue import (
    WorkerDialogue,
)
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.diagnostics import render
from colcon_yamllaunch.plan.labels import with_labels
from colcon_yamllaunch.plan.plan import Growth
from colcon_yamllaunch.plan.plan import Message
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.position import Position


class GrowingLaunch:
    """
    Goes on with a walk while its plan runs; see `Growing`.

    :param plan: What came of the walk so far
    """

    def __init__(
        self, walk: Walk, dialogue: WorkerDialogue, plan: Plan
    ) -> None:
        self._walk = walk
        self._dialogue = dialogue
        self._start = Position(next(iter(walk.python_files), ''), 1, 1)
        self._labels = {p.label for p in plan.processes()}
        self._labels |= {c.label for c in plan.components()}
        walk.draft.reserve_labels(self._labels)
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
        """See `Growing`."""
        return self._dialogue.has_handlers

    @property
    def wants_output(self) -> frozenset[str]:
        """See `Growing`."""
        return self._dialogue.wants_output

    @property
    def is_busy(self) -> bool:
        """See `Growing`."""
        return bool(self._asked)

    def id_of(self, name: str) -> int | None:
        """See `Growing`."""
        return self._dialogue.ids.get(name)

    def ask(self, request: WorkerMessage) -> None:
        """See `Growing`."""
        block = None
        if self._walk.draft.blocks:
            # that of the launch itself
            block = 0
        if request['do'] == 'call':
            block = self._dialogue.calls.pop(request['number'], block)
        self._asked.append((self._dialogue.send(request), block))

    def take(self, message: WorkerMessage) -> Growth | None:
        """See `Growing`."""
        if self._intake is None:
            if self._asked:
                self._walk.draft.go_on_in(self._asked[0][1])
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
        problems = self._failure(self._intake)
        for end in () if problems else ends:
            problems += self._problems(end)
        return self._growth(problems)

    def lost(self, reason: str) -> Growth:
        """See `Growing`."""
        self._asked.clear()
        self._dialogue.forget_handlers()
        self._dialogue.calls.clear()
        return self._growth([reason] if reason else [])

    def _failure(self, intake: Intake) -> list[str]:
        try:
            intake.finish()
        except LaunchError as e:
            located = self._walk.located(e)
            return [render(located.diagnostics, self._walk.cwd)]
        except (AlreadyReportedError, EndlessError):
            pass
        return []

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
        labels = {p.label for p in grown.processes()}
        labels |= {c.label for c in grown.components()}
        self._labels |= labels
        walk.draft.reserve_labels(labels)
        return Growth(grown.entries, tuple(problems), walk.draft.blocks)


def growing_launch(
    walk: Walk, plan: Plan
) -> tuple[Plan, GrowingLaunch | None]:
    """
    Return a plan with its event handlers, and what makes more of it.

    The latter is None when nothing does.
    """
    dialogue = walk.dialogue
    if dialogue is None or not dialogue.goes_on:
        return plan, None
    growing = GrowingLaunch(walk, dialogue, plan)
    return replace(plan, handlers=dialogue.handlers), growing
