# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Drawings of a plan: its launch files, groups, processes and components."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.plan.plan import Block, Component, Plan, Process
from colcon_yamllaunch.plan.plan_text import when
from colcon_yamllaunch.plan.position import shown_path


def plan_to_mermaid(plan: Plan, cwd: str) -> str:
    """
    Draw a plan as a Mermaid flowchart.

    :param cwd: The folder that paths are shown relative to
    """
    return '\n'.join(['flowchart TB', *_Drawing(plan, cwd).lines(_MERMAID)])


def plan_to_dot(plan: Plan, cwd: str) -> str:
    """
    Draw a plan in the language of Graphviz.

    :param cwd: The folder that paths are shown relative to
    """
    lines = ['digraph launch {', '  node [shape=box];']
    return '\n'.join([*lines, *_Drawing(plan, cwd).lines(_DOT), '}'])


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
    line_end: str
    escaped: Callable[[str], str]

    def lines(self, *texts: str | None) -> str:
        """Return the text of several lines, without those that are None."""
        return self.line_end.join(
            self.escaped(one_line(text)) for text in texts if text is not None
        )


class _Drawing:
    """The blocks, processes and components of a plan as a tree."""

    def __init__(self, plan: Plan, cwd: str) -> None:
        self._cwd = cwd
        self._blocks = plan.blocks
        self._children: dict[int | None, list[int]] = {}
        self._processes: dict[int | None, list[tuple[int, Process]]] = {}
        for index, block in enumerate(plan.blocks):
            self._children.setdefault(block.parent, []).append(index)
        for number, process in enumerate(plan.processes()):
            here = self._processes.setdefault(process.block, [])
            here.append((number, process))
        self._components: dict[int | None, list[tuple[int, Component]]] = {}
        for number, component in enumerate(plan.components()):
            inside = self._components.setdefault(component.block, [])
            inside.append((number, component))
        self._handlers = plan.handlers
        self._names = {
            process.ros_name: number
            for number, process in enumerate(plan.processes())
        }
        self._containers = {
            process.node_name: number
            for number, process in enumerate(plan.processes())
        }

    def lines(self, language: _Language) -> Iterator[str]:
        yield from self._block(None, language, '  ')
        for components in self._components.values():
            for number, component in components:
                container = self._containers.get(component.container)
                if container is not None:
                    yield '  ' + language.loaded.format(container, number)
        for number, handler in enumerate(self._handlers):
            text = language.lines(f'{when(handler)}:', *handler.actions)
            yield '  ' + language.handler.format(number, text)
            for name in handler.processes:
                if name in self._names:
                    process = self._names[name]
                    yield '  ' + language.handled.format(process, number)

    def _block(
        self, index: int | None, language: _Language, indent: str
    ) -> Iterator[str]:
        for number, process in self._processes.get(index, ()):
            text = language.lines(process.label, process.node_name)
            yield indent + language.process.format(number, text)
        for number, component in self._components.get(index, ()):
            # of one that no process of the launch is, there is no arrow
            is_here = component.container in self._containers
            into = None if is_here else f'in {component.container}'
            text = language.lines(component.label, component.node_name, into)
            yield indent + language.component.format(number, text)
        for child in self._children.get(index, ()):
            title = language.escaped(
                one_line(self._title(self._blocks[child]))
            )
            yield indent + language.opening.format(child, title)
            yield from self._block(child, language, indent + '  ')
            yield indent + language.closing

    def _title(self, block: Block) -> str:
        if block.kind == 'file':
            return shown_path(block.title, self._cwd)
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
    '\\n',
    _quoted,
)
