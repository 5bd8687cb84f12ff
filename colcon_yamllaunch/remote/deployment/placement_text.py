# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What runs where, for people."""

from collections import Counter
from collections.abc import Iterator
import shlex

from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.remote.deployment.deployment import Deployment
from colcon_yamllaunch.remote.deployment.machine import Machine
from colcon_yamllaunch.remote.deployment.placement import Placed

_INDENT = '    '


def placement_to_text(placed: Placed, deployment: Deployment) -> str:
    """Say which machines there are, and what runs on each."""
    return '\n'.join(map(one_line, _lines(placed, deployment)))


def way_to(machine: Machine) -> str:
    """Say how a machine is reached."""
    words = shlex.join(machine.words)
    if machine.kind == 'connect':
        return words
    return f'{machine.kind} {words}'.rstrip()


def _lines(placed: Placed, deployment: Deployment) -> Iterator[str]:
    yield 'machines:'
    for name, machine in deployment.machines.items():
        facts = [way_to(machine)]
        if machine.workspace is not None:
            facts.append(f'workspace {machine.workspace}')
        if machine.sync != 'build':
            facts.append(f'sync {machine.sync}')
        if machine.on_lost != 'stop':
            facts.append(f'on_lost {machine.on_lost}')
        if machine.lost_after is not None:
            facts.append(f'lost_after {machine.lost_after:g}')
        facts.append(_amount(placed.parts.get(name, Plan())))
        yield f'{_INDENT}{name}: {", ".join(facts)}'
    yield f'{_INDENT}here: {_amount(placed.local)}'


def _amount(plan: Plan) -> str:
    count = Counter[str]()
    count['process'] = sum(1 for _ in plan.processes())
    count['component'] = sum(1 for _ in plan.components())
    plurals = {'process': 'processes', 'component': 'components'}
    said = [
        f'{number} {word if number == 1 else plurals[word]}'
        for word, number in count.items()
        if number
    ]
    return ' and '.join(said) or 'nothing'
