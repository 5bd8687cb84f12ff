# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the launcher has the engine of a part do."""

import base64
from collections.abc import Callable
from collections.abc import Mapping
from dataclasses import asdict
import math
import termios
import time
from typing import Any

from colcon_yamllaunch.common.errors import RefusedError
from colcon_yamllaunch.control.resource_usage import INTERVAL
from colcon_yamllaunch.control.resource_usage import Look
from colcon_yamllaunch.control.resource_usage import look
from colcon_yamllaunch.control.resource_usage import usage_between
from colcon_yamllaunch.engine import commands
from colcon_yamllaunch.engine.engine import Engine
from colcon_yamllaunch.engine.state import to_json
from colcon_yamllaunch.plan.plan_json import plan_from_json
from colcon_yamllaunch.plan.plan_json import PlanFormatError

#: Seconds between two looks at how a terminal reads that somebody types at.
_MODES_INTERVAL = 0.05

_ACTIONS = {
    kind.name: kind
    for kind in (
        commands.Stop,
        commands.Restart,
        commands.Kill,
        commands.Debug,
    )
}

#: Takes a message for the launcher.
Tell = Callable[[Mapping[str, Any]], None]


class PartOrders:
    """
    Does what messages say.

    :param tell: Sends the answers
    """

    def __init__(self, engine: Engine, tell: Tell) -> None:
        self._engine = engine
        self._tell = tell
        # who somebody is attached to, and how the terminals of these read
        self._attached: set[str] = set()
        self._modes: dict[str, int] = {}
        # how processors were used when somebody asked, and who it was
        self._looks: list[tuple[float, object, dict[str, int], Look]] = []

    def carry_out(self, content: Mapping[str, Any]) -> None:
        """
        Do what a message says, and answer if it has an `id`.

        What cannot be done is answered with the reason.
        """
        number = content.get('id')
        try:
            answer = self._do(str(content.get('do')), content)
        except RefusedError as error:
            answer = {'error': str(error)}
        except (PlanFormatError, KeyError, TypeError, ValueError) as error:
            answer = {'error': f'{type(error).__name__}: {error}'}
        if number is not None and answer is not None:
            self._tell({'reply': number, 'error': None, **answer})

    def advance(self) -> None:
        """Answer what takes a moment."""
        while self._looks and self._looks[0][0] <= time.monotonic():
            _, number, groups, before = self._looks.pop(0)
            now = look(groups.values())
            used = usage_between(before, now)
            usage = {
                label: [used[group].cpu, used[group].memory]
                for label, group in groups.items()
                if group in used
            }
            self._tell({'reply': number, 'error': None, 'usage': usage})

        for label in self._attached:
            modes = self._engine.terminals.input_modes(label)
            if modes is not None and modes != self._modes.get(label):
                self._modes[label] = modes
                told = {
                    'label': label,
                    'lines': bool(modes & termios.ICANON),
                    'echo': bool(modes & termios.ECHO),
                }
                self._tell({'modes': told})

    def seconds_to_wait(self) -> float:
        """Return the seconds until :meth:`advance` is to be called again."""
        wait = _MODES_INTERVAL if self._attached else math.inf
        if self._looks:
            wait = min(wait, self._looks[0][0] - time.monotonic())
        return wait

    def rows(self) -> dict[str, dict[str, Mapping[str, Any]]]:
        """Return the states of all processes and components by label."""
        state = to_json(self._engine.state)
        return {
            kind: {part['label']: part for part in state[kind]}
            for kind in ('processes', 'components')
        }

    def _do(
        self, what: str, content: Mapping[str, Any]
    ) -> dict[str, Any] | None:
        """
        Return the answer, or None if it is given later.

        :raises RefusedError: when it cannot be done
        """
        engine = self._engine
        do = engine.dispatcher.do
        match what:
            case 'stop':
                do(
                    commands.Shutdown(
                        str(content.get('reason')),
                        bool(content.get('interactive')),
                        bool(content.get('drop_timers')),
                    )
                )
            case 'hurry':
                do(commands.Escalate())
            case 'act':
                do(_ACTIONS[content['action']](content['name']))
            case 'describe':
                described = do(commands.Describe(content['name']))
                found = asdict(described.description)
                found['environment'] = dict(found['environment'])
                return {'description': found}
            case 'change_state':
                self._change_state(content)
                return None
            case 'attach':
                self._attached.add(content['label'])
            case 'detach':
                self._attached.discard(content['label'])
                self._modes.pop(content['label'], None)
            case 'type':
                keys = base64.b64decode(content['keys'])
                do(commands.Type(content['label'], keys))
            case 'resize':
                do(commands.Resize(content['columns'], content['rows']))
            case 'suspend' | 'continue':
                do(commands.Hold(what == 'suspend'))
            case 'extend':
                entries = plan_from_json(content['entries']).entries
                do(commands.Extend(entries))
            case 'revise':
                at_once = bool(content.get('at_once'))
                for part in plan_from_json(content['plan']).entries:
                    do(commands.Revise(part, at_once))  # type: ignore[arg-type]
            case 'restart_changed':
                command = commands.RestartChanged(tuple(content['labels']))
                return {'labels': list(do(command).labels)}
            case 'drop':
                do(commands.Drop(content['label']))
            case 'forget':
                entries = plan_from_json(content['plan']).entries
                do(commands.Forget(entries))
            case 'usage':
                groups = dict(engine.groups())
                due = time.monotonic() + INTERVAL
                before = look(groups.values())
                self._looks.append((due, content.get('id'), groups, before))
                return None
            case _:
                raise RefusedError(f"'{what}' is not known there")
        return {}

    def _change_state(self, content: Mapping[str, Any]) -> None:
        def answer(response: commands.Done | commands.Refused) -> None:
            error = getattr(response, 'error', None)
            self._tell({'reply': content.get('id'), 'error': error})

        command = commands.ChangeState(content['name'], content['transition'])
        self._engine.dispatcher.ask(command, answer)
