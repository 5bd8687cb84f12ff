# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Drawings of a plan: its launch files, groups, processes and components."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.plan.plan import Block, Member, Plan
from colcon_yamllaunch.plan.plan_text import when
from colcon_yamllaunch.plan.position import shown_path
from colcon_yamllaunch.plan.start_order import dependencies_of


def plan_to_mermaid(plan: Plan, cwd: str) -> str:
    """
    Draw a plan as a Mermaid flowchart.

    :param cwd: The folder that paths are shown relative to
    """
    return '\n'.join(['flowchart TB', *_drawn(plan, cwd, _MERMAID)])


def plan_to_dot(plan: Plan, cwd: str) -> str:
    """
    Draw a plan in the language of Graphviz.

    :param cwd: The folder that paths are shown relative to
    """
    lines = ['digraph launch {', '  node [shape=box];']
    return '\n'.join([*lines, *_drawn(plan, cwd, _DOT), '}'])


class _Language(NamedTuple):
    """
    How a language of drawings writes what all have.

    :param opening: The start of a block with a number and title
    :param closing: The end of a block
    :param process: A process with a number and text
    :param component: A component with a number and text
    :param handler: What is done when something happens, with a number and text
    :param loaded: An arrow from the process with a number to the component
      with another one
    :param handled: An arrow from the process with a number to what is done
      when something happens to it, with another one
    :param awaited: An arrow from what has a name in the drawing to what waits
      for it, with that name and a text
    :param line_end: What separates the lines of a text
    :param escaped: Makes a text one that means nothing to the language
    """

    opening: str
    closing: str
    process: str
    component: str
    handler: str
    loaded: str
    handled: str
    awaited: str
    line_end: str
    escaped: Callable[[str], str]

    def lines(self, *texts: str | None) -> str:
        """Return the text of several lines, without those that are None."""
        return self.line_end.join(
            self.escaped(one_line(text)) for text in texts if text is not None
        )


def _drawn(plan: Plan, cwd: str, language: _Language) -> Iterator[str]:
    """Draw the blocks, processes and components of a plan as a tree."""
    processes = list(enumerate(plan.processes()))
    components = list(enumerate(plan.components()))
    names = {process.ros_name: number for number, process in processes}
    containers = {process.node_name: number for number, process in processes}

    def block(index: int | None, indent: str) -> Iterator[str]:
        for number, process in processes:
            if process.block == index:
                text = language.lines(process.label, process.node_name)
                yield indent + language.process.format(number, text)
        for number, component in components:
            if component.block == index:
                # of one that no process of the launch is, there is no arrow
                is_here = component.container in containers
                text = language.lines(
                    component.label,
                    component.node_name,
                    None if is_here else f'in {component.container}',
                )
                yield indent + language.component.format(number, text)
        for number, inner in enumerate(plan.blocks):
            if inner.parent == index:
                title = language.lines(_title(inner, cwd))
                yield indent + language.opening.format(number, title)
                yield from block(number, indent + '  ')
                yield indent + language.closing

    yield from block(None, '  ')
    for number, component in components:
        container = containers.get(component.container)
        if container is not None:
            yield '  ' + language.loaded.format(container, number)
    for number, handler in enumerate(plan.handlers):
        text = language.lines(f'{when(handler)}:', *handler.actions)
        yield '  ' + language.handler.format(number, text)
        for name in handler.processes:
            if name in names:
                yield '  ' + language.handled.format(names[name], number)
    yield from _dependencies(plan, language)


def _dependencies(plan: Plan, language: _Language) -> Iterator[str]:
    """Draw which processes and components wait for which, and for what."""
    ids = {p.label: f'process{n}' for n, p in enumerate(plan.processes())}
    for number, component in enumerate(plan.components()):
        ids[component.label] = f'component{number}'
    members = {member.label: member for member in plan.members()}
    for label, labels in dependencies_of(members.values()).items():
        for other in labels:
            if other in members:
                text = language.lines(*_conditions_of(members[other]))
                yield '  ' + language.awaited.format(
                    ids[other], ids[label], text
                )


def _conditions_of(member: Member) -> Iterator[str]:
    settings = member.settings
    if settings is None or not settings.ready:
        yield 'ready'
    else:
        yield from map(str, settings.ready)


def _title(block: Block, cwd: str) -> str:
    if block.kind == 'file':
        return shown_path(block.title, cwd)
    return f'{block.kind} {block.title}'.rstrip()


def _escaped(text: str) -> str:
    # Mermaid's own way to write characters that mean something to it
    return ''.join(c if c not in '"<>&#' else f'#{ord(c)};' for c in text)


def _quoted(text: str) -> str:
    return text.replace('\\', '\\\\').replace('"', '\\"')


_MERMAID = _Language(
    'subgraph block{} ["{}"]',
    'end',
    'process{}["{}"]',
    'component{}(["{}"])',
    'handler{}>"{}"]',
    'process{} --> component{}',
    'process{} -.-> handler{}',
    '{0} ==>|"{2}"| {1}',
    '<br/>',
    _escaped,
)
_DOT = _Language(
    'subgraph cluster{} {{ label="{}";',
    '}',
    'process{} [label="{}"];',
    'component{} [shape=ellipse, label="{}"];',
    'handler{} [shape=note, label="{}"];',
    'process{} -> component{};',
    'process{} -> handler{} [style=dashed];',
    '{} -> {} [style=bold, label="{}"];',
    '\\n',
    _quoted,
)
