# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The expressions of `$(eval …)` that a check may compute."""

import ast
from collections.abc import Mapping
import math

#: The longest expression that is computed, in characters.
MAXIMUM_LENGTH = 2000
#: How deep the parts of an expression that is computed may be nested. How
#: much Python itself bears differs from release to release.
MAXIMUM_DEPTH = 100

_FUNCTIONS: Mapping[str, object] = {
    name: getattr(math, name) for name in dir(math) if name[0] != '_'
} | {f.__name__: f for f in (abs, bool, float, int, len, max, min, round, str)}
# they can take forever, or all memory
_UNBOUNDED = frozenset(('comb', 'factorial', 'perm', 'pow', 'lcm', 'prod'))
_METHODS = frozenset(
    (
        'endswith',
        'find',
        'lower',
        'lstrip',
        'rstrip',
        'split',
        'startswith',
        'strip',
        'title',
        'upper',
    )
)
_NODES = (
    ast.Expression,
    ast.BoolOp,
    ast.UnaryOp,
    ast.BinOp,
    ast.IfExp,
    ast.Compare,
    ast.Call,
    ast.Constant,
    ast.Attribute,
    ast.Name,
    ast.List,
    ast.Tuple,
    ast.Set,
    ast.expr_context,
    ast.boolop,
    ast.unaryop,
    ast.cmpop,
    ast.Add,
    ast.Sub,
    ast.Mult,
    ast.Div,
    ast.FloorDiv,
    ast.Mod,
)


class ExpressionError(Exception):
    """An expression that can never be computed."""


def compute(expression: str) -> str | None:
    """
    Compute an expression that has no effects and ends soon.

    :returns: The result, or None when only a launch may compute it
    :raises ExpressionError: when it fails; the message says how
    """
    if len(expression) > MAXIMUM_LENGTH:
        return None
    try:
        tree = ast.parse(expression.strip(), mode='eval')
    except (SyntaxError, ValueError) as e:
        reason = getattr(e, 'msg', None) or e
        raise ExpressionError(f'{type(e).__name__}: {reason}') from e
    except (MemoryError, RecursionError):
        return None
    if _is_too_deep(tree) or not _is_harmless(tree):
        return None
    try:
        code = compile(tree, '<launch file>', 'eval')
        return str(eval(code, {'__builtins__': {}}, _FUNCTIONS))
    except RecursionError:
        return None
    except Exception as e:
        # the expression is the user's own program, and may raise anything
        raise ExpressionError(f'{type(e).__name__}: {e}') from e


def _is_too_deep(tree: ast.Expression) -> bool:
    level: list[ast.AST] = [tree]
    for _ in range(MAXIMUM_DEPTH):
        level = [c for node in level for c in ast.iter_child_nodes(node)]
        if not level:
            return False
    return True


def _is_harmless(tree: ast.Expression) -> bool:
    nodes = list(ast.walk(tree))
    products = any(isinstance(node, ast.Mult | ast.Mod) for node in nodes)
    return all(
        isinstance(node, _NODES)
        and _is_known(node)
        # a text times a number, or '%999999999d', can be of any length
        and not (products and _makes_text(node))
        for node in nodes
    )


def _is_known(node: ast.AST) -> bool:
    if isinstance(node, ast.Name):
        return node.id in _FUNCTIONS and node.id not in _UNBOUNDED
    if isinstance(node, ast.Attribute):
        return node.attr in _METHODS
    if isinstance(node, ast.Call):
        return isinstance(node.func, ast.Name | ast.Attribute)
    return True


def _makes_text(node: ast.AST) -> bool:
    if isinstance(node, ast.Constant):
        return isinstance(node.value, str | bytes)
    if isinstance(node, ast.Name):
        return node.id == 'str'
    return isinstance(node, ast.List | ast.Tuple | ast.Set)
