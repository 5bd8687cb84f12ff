# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Computing an expression of `$(eval …)` in a process that may be ended.

Nothing else ends a computation in Python that has begun: neither a timer nor
Ctrl-C comes through to `sum(range(10**12))`.
"""

from collections.abc import Mapping
import os
import resource
import signal

from colcon_yamllaunch.language.policies.expression import ExpressionError

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
        _write(writer, _outcome(expression, variables))
    finally:
        os._exit(0)


def _outcome(expression: str, variables: Mapping[str, object]) -> bytes:
    try:
        kind, text = _RESULT, _computed(expression, variables)
    except ExpressionError as e:
        kind, text = _FAILURE, str(e)
    return kind + text.encode(errors='surrogatepass')


def _computed(expression: str, variables: Mapping[str, object]) -> str:
    try:
        return str(eval(expression, dict(variables)))
    except MemoryError as e:
        most = MAXIMUM_MEMORY // 1024 // 1024
        raise ExpressionError(f'it takes more than {most} MB') from e
    except Exception as e:
        # the expression is the user's own program, and may raise anything
        raise ExpressionError(f'{type(e).__name__}: {e}') from e


def _write(writer: int, data: bytes) -> None:
    while data:
        data = data[os.write(writer, data) :]
