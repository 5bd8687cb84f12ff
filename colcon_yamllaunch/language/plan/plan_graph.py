# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Drawings of a plan: its launch files, groups and processes."""

from collections.abc import Callable
from collections.abc import Iterator
from typing import NamedTuple

from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.language.plan.plan import Block
from colcon_yamllaunch.language.plan.plan import Plan
from colcon_yamllaunch.language.plan.plan import Process
from colcon_yamllaunch.language.syntax.diagnostics import shown_path


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
    :param line_end: What separates the lines of a text
    :param escaped: Makes a text one that means nothing to the language
    """

    opening: str
    closing: str
    process: str
    line_end: str
    escaped: Callable[[str], str]


class _Drawing:
    """The blocks and processes of a plan as a tree."""

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

    def lines(self, language: _Language) -> Iterator[str]:
        return self._block(None, language, '  ')

    def _block(
        self, index: int | None, language: _Language, indent: str
    ) -> Iterator[str]:
        for number, process in self._processes.get(index, ()):
            texts = [process.label]
            if process.node_name is not None:
                texts.append(process.node_name)
            text = language.line_end.join(
                language.escaped(one_line(t)) for t in texts
            )
            yield indent + language.process.format(number, text)
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
    'subgraph block{} ["{}"]', 'end', 'process{}["{}"]', '<br/>', _escaped
)
_DOT = _Language(
    'subgraph cluster{} {{ label="{}";',
    '}',
    'process{} [label="{}"];',
    '\\n',
    _quoted,
)
