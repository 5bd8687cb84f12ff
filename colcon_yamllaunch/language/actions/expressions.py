# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The expressions of `$(eval …)` that a check may compute."""

import ast
from collections.abc import Mapping
import importlib
import math
import os
import resource
import signal

from colcon_yamllaunch.language.evaluation.walk import Walk

#: The longest expression that is computed, in characters.
MAXIMUM_LENGTH = 2000
#: The longest one that is looked at to tell what it does (characters).
LONGEST = 100_000
#: How deep the parts of an expression that is computed may be nested. How
#: much Python itself bears differs from release to release.
MAXIMUM_DEPTH = 100

_FUNCTIONS: Mapping[str, object] = {
    name: getattr(math, name) for name in dir(math) if name[0] != '_'
} | {
    f.__name__: f
    for f in (
        *(abs, all, any, bool, float, int, len, list, max, min, round, set),
        *(sorted, str, tuple),
    )
}
#: How many digits a number is rounded to at most before a launch.
MAXIMUM_DIGITS = 10_000
#: What computes and does nothing else.
_COMPUTING = frozenset(
    (
        *_FUNCTIONS,
        *('math', 'all', 'any', 'ascii', 'bin', 'bytearray', 'bytes', 'chr'),
        *('complex', 'dict', 'divmod', 'enumerate', 'filter', 'format'),
        *('frozenset', 'hash', 'hex', 'isinstance', 'iter', 'list', 'map'),
        *('next', 'oct', 'ord', 'pow', 'range', 'repr', 'reversed', 'set'),
        *('slice', 'sorted', 'sum', 'tuple', 'type', 'zip'),
    )
)
# they can take forever, or all memory
_UNBOUNDED = frozenset(('comb', 'factorial', 'perm', 'pow', 'lcm', 'prod'))
_METHODS = frozenset(
    (
        *('endswith', 'find', 'intersection', 'lower', 'lstrip', 'rstrip'),
        *('split', 'startswith', 'strip', 'title', 'upper'),
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
    ast.Subscript,
    ast.Slice,
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


def run(walk: Walk, expression: str, modules: str) -> str:
    """
    Compute an expression as a launch does.

    :param modules: The modules whose names it has, separated by commas
    :raises ExpressionError: when it fails; the message says how
    """
    variables: dict[str, object] = {}
    try:
        for name in modules.split(','):
            name = name.strip()
            if not name:
                continue
            module = importlib.import_module(name)
            if name == 'math':
                variables.update(vars(math))
            variables[module.__name__] = module
            variables.setdefault(name.partition('.')[0], module)
        if not is_costly(expression):
            return str(eval(expression, variables))
        if expression not in walk.computed:
            result = compute_in_child(expression, variables)
            walk.computed[expression] = result
        return walk.computed[expression]
    except ExpressionError:
        raise
    except (Exception, SystemExit) as e:
        # the expression is the user's own program, and may raise anything
        raise ExpressionError(f'{type(e).__name__}: {e}') from e


def compute(expression: str) -> str | None:
    """
    Compute an expression, None when only a launch may do so.

    What is computed has no effects and ends soon.

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
    if _is_too_deep(tree):
        return None
    _refuse_endless(tree)
    if not _is_harmless(tree):
        return None
    try:
        code = compile(tree, '<launch file>', 'eval')
        return str(eval(code, {'__builtins__': {}}, _FUNCTIONS))
    except RecursionError:
        return None
    except Exception as e:
        # the expression is the user's own program, and may raise anything
        raise ExpressionError(f'{type(e).__name__}: {e}') from e


def is_costly(expression: str) -> bool:
    """
    Return whether an expression only computes, possibly without end.

    One that does more, such as importing, is a program of the user's own.
    """
    if len(expression) > LONGEST:
        return True
    try:
        tree = ast.parse(expression.strip(), mode='eval')
    except (SyntaxError, ValueError):
        # which shows when it is computed
        return False
    except (MemoryError, RecursionError):
        return True
    nodes = list(ast.walk(tree))
    bound = {
        node.id if isinstance(node, ast.Name) else node.arg
        for node in nodes
        if isinstance(node, ast.arg)
        or (isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store))
    }
    only_computes = all(
        node.id in bound or node.id in _COMPUTING
        if isinstance(node, ast.Name)
        else not isinstance(node, ast.Attribute) or node.attr[:1] != '_'
        for node in nodes
    )
    return only_computes and not _is_harmless(tree)


def _refuse_endless(tree: ast.Expression) -> None:
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and _is_round(node) and node.args[1:]:
            try:
                digits = ast.literal_eval(node.args[1])
            except ValueError:
                continue
            if isinstance(digits, int) and abs(digits) > MAXIMUM_DIGITS:
                raise ExpressionError(
                    f'to round to {digits} digits would take for ever'
                )


def _is_round(node: ast.Call) -> bool:
    return isinstance(node.func, ast.Name) and node.func.id == 'round'


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
    if isinstance(node, ast.Call) and _is_round(node):
        # with -N, it computes 10 to the N
        return not node.keywords and all(
            isinstance(digits, ast.Constant) for digits in node.args[1:]
        )
    if isinstance(node, ast.Call):
        return isinstance(node.func, ast.Name | ast.Attribute)
    return True


def _makes_text(node: ast.AST) -> bool:
    if isinstance(node, ast.Constant):
        return isinstance(node.value, str | bytes)
    if isinstance(node, ast.Name):
        return node.id in ('str', 'list', 'tuple', 'set', 'sorted')
    return isinstance(node, ast.List | ast.Tuple | ast.Set)


#: Seconds of computing that an expression may take.
MAXIMUM_TIME = 0.5
#: Bytes of memory that it may take.
MAXIMUM_MEMORY = 128 * 1024 * 1024
#: Bytes that its result may have.
MAXIMUM_RESULT = 16 * 1024 * 1024

_RESULT, _FAILURE = b'=', b'!'


def compute_in_child(expression: str, variables: Mapping[str, object]) -> str:
    """
    Compute an expression that is known to have no effects.

    :raises ExpressionError: when it fails, or takes too much
    :raises OSError: when there can be no other process
    """
    reader, writer = os.pipe()
    with open(reader, 'rb') as results:
        try:
            pid = os.fork()
            if pid == 0:
                _compute(writer, expression, variables)
        finally:
            os.close(writer)
        try:
            result = results.read(MAXIMUM_RESULT + 1)
        finally:
            os.kill(pid, signal.SIGKILL)
            os.waitpid(pid, 0)
    text = result[1:].decode(errors='surrogatepass')
    if result.startswith(_RESULT) and len(result) <= MAXIMUM_RESULT:
        return text
    if result.startswith(_FAILURE):
        raise ExpressionError(text)
    if result:
        raise ExpressionError(f'it has more than {MAXIMUM_RESULT} characters')
    raise ExpressionError(
        f'it takes more than {MAXIMUM_TIME:g} s of computing'
    )


def _compute(
    writer: int, expression: str, variables: Mapping[str, object]
) -> None:
    """Be the child: write what comes of it, and end."""
    try:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        signal.signal(signal.SIGPROF, signal.SIG_DFL)
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        with open('/proc/self/statm', 'rb') as file:
            pages = int(file.read().split()[0])
        most = pages * resource.getpagesize() + MAXIMUM_MEMORY
        hard = resource.getrlimit(resource.RLIMIT_AS)[1]
        if hard == resource.RLIM_INFINITY or most < hard:
            resource.setrlimit(resource.RLIMIT_AS, (most, hard))
        # what the signal does unless it is handled is to end the process
        signal.setitimer(signal.ITIMER_PROF, MAXIMUM_TIME)
        data = _outcome(expression, variables)
        while data:
            data = data[os.write(writer, data) :]
    finally:
        os._exit(0)


def _outcome(expression: str, variables: Mapping[str, object]) -> bytes:
    try:
        kind, text = _RESULT, str(eval(expression, dict(variables)))
    except MemoryError:
        most = MAXIMUM_MEMORY // 1024 // 1024
        kind, text = _FAILURE, f'it takes more than {most} MB'
    except Exception as e:  # noqa: BLE001 - the user's own program
        kind, text = _FAILURE, f'{type(e).__name__}: {e}'
    return kind + text.encode(errors='surrogatepass')
