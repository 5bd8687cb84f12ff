# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What came of one run of a sweep."""

from collections.abc import Iterable
from collections.abc import Mapping
from dataclasses import asdict
from dataclasses import field
from typing import Any
from typing import Literal

from colcon_yamllaunch.common.frozen import dataclass

#: How a run ended: its launch exits with 0; it does not; or there was none,
#: or nobody knows what came of it, as its machine failed.
Outcome = Literal['succeeded', 'failed', 'error']
OUTCOMES: tuple[Outcome, ...] = ('succeeded', 'failed', 'error')
#: Characters of a reason that are kept.
_REASON = 1000
#: What no number that is plotted gets to.
_LARGEST = 1e100


@dataclass(frozen=True, slots=True)
class RunResult:
    """
    What came of a run.

    :param run: Its number
    :param reason: Why it did not succeed, in one line
    :param seconds: How long its launch took
    :param metrics: What was found for each metric, as it was written; a
      metric that was not found is missing
    :param cpu: Seconds of processor time that the launch itself took, without
      its processes
    :param commit: The git commit that was run, with `-dirty` if it was
      modified; '' without git
    :param fingerprint: That of the code that was run; '' if it is unknown
    """

    run: int
    outcome: Outcome
    reason: str = ''
    seconds: float = 0.0
    metrics: Mapping[str, str] = field(default_factory=dict)
    cpu: float = 0.0
    commit: str = ''
    fingerprint: str = ''

    @property
    def succeeded(self) -> bool:
        """Whether all is well."""
        return self.outcome == 'succeeded'

    def as_json(self) -> dict[str, Any]:
        """Return it for a file."""
        return {**asdict(self), 'metrics': dict(self.metrics)}


def result_from_json(values: Any) -> RunResult | None:
    """Return a result that a file has, None if it is none."""
    match values:
        case {
            'run': int(run),
            'outcome': 'succeeded' | 'failed' | 'error' as outcome,
            'reason': str(reason),
            'seconds': int() | float() as seconds,
            'metrics': dict(metrics),
        } if run > 0 and run is not True and _is_moderate(seconds):
            cpu = values.get('cpu', 0.0)
            return RunResult(
                run,
                outcome,
                one_reason(reason),
                float(seconds),
                {str(k): str(v) for k, v in metrics.items()},
                float(cpu) if _is_moderate(cpu) else 0.0,
                one_reason(str(values.get('commit', ''))),
                one_reason(str(values.get('fingerprint', ''))),
            )
        case _:
            return None


def versions_of(
    results: Iterable[RunResult],
) -> dict[str, list[RunResult]]:
    """Return results by the version of the code that was run, for people."""
    found: dict[str, list[RunResult]] = {}
    for result in results:
        found.setdefault(result.fingerprint, []).append(result)
    return {
        # what was modified may have been committed since
        ', '.join(
            filter(None, [*dict.fromkeys(r.commit for r in runs), version])
        )
        or 'not recorded': runs
        for version, runs in found.items()
    }


def _is_moderate(value: Any) -> bool:
    """Return whether `value` is a number that a float can hold."""
    return isinstance(value, int | float) and abs(value) < _LARGEST


def one_reason(text: str) -> str:
    """Return a reason in one line of a length that can be read."""
    line = ' '.join(text.split())
    return line if len(line) <= _REASON else f'{line[: _REASON - 1]}…'


def number_of(text: str) -> float | None:
    """Return what a value is as a number, None if it is none."""
    try:
        value = float(text)
    except ValueError:
        return None
    # what is larger was not measured, and cannot be reckoned with
    return value if abs(value) < _LARGEST else None
