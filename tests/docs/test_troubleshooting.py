# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""docs/troubleshooting.md quotes the messages as the code has them."""

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path
import re

import pytest
from support.sources import modules

# so that one worker parses the code
pytestmark = pytest.mark.xdist_group('sources')

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / 'docs/troubleshooting.md').read_text(encoding='utf-8')
MESSAGES = re.findall(r'^\| `([^`]+)` \|', TEXT, re.M)
#: The least length of a part that says something, in characters.
LEAST = 4


def texts(tree: ast.AST) -> Iterator[str]:
    """Return the texts of a module, with … for what is filled in."""
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            yield ''.join(
                str(v.value) if isinstance(v, ast.Constant) else '…'
                for v in node.values
            )
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value


@cache
def code() -> str:
    trees = modules().values()
    return '\n'.join(text for tree in trees for text in texts(tree))


def test_there_are_messages() -> None:
    assert len(MESSAGES) > 50
    assert len(set(MESSAGES)) == len(MESSAGES)


@pytest.mark.parametrize('message', MESSAGES)
def test_the_code_has_each_message(message: str) -> None:
    parts = [part for part in message.split('…') if len(part) >= LEAST]
    assert parts
    for part in parts:
        assert part in code(), part
