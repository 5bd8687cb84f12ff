# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

import signal

from colcon_yamllaunch.engine.outcome import is_failure, Outcome
import pytest


@pytest.mark.parametrize(
    ('outcome', 'text'),
    [
        (Outcome(code=0), 'exited with code 0'),
        (Outcome(code=3), 'exited with code 3'),
        (
            Outcome(signal=signal.SIGSEGV),
            'died by SIGSEGV (segmentation fault)',
        ),
        (
            Outcome(signal=signal.SIGABRT, core_dumped=True),
            'died by SIGABRT (aborted), core dumped',
        ),
    ],
)
def test_an_outcome_names_code_or_signal(outcome, text):
    assert str(outcome) == text


@pytest.mark.parametrize(
    ('outcome', 'asked', 'failed'),
    [
        (Outcome(code=0), False, False),
        (Outcome(code=1), False, True),
        (Outcome(signal=signal.SIGTERM), False, True),
        (Outcome(code=1), True, False),
        (Outcome(code=130), True, False),
        (Outcome(signal=signal.SIGINT), True, False),
        (Outcome(signal=signal.SIGKILL), True, False),
        (Outcome(signal=signal.SIGSEGV), True, True),
    ],
)
def test_a_failure_is_what_nobody_asked_for(outcome, asked, failed):
    assert is_failure(outcome, asked) is failed


def test_an_outcome_names_the_limit_that_it_exceeded():
    limit = 'over its 2 GiB limit, peak 2.1 GiB'
    assert str(Outcome(signal=signal.SIGKILL, limit=limit)) == (
        'killed: over its 2 GiB limit, peak 2.1 GiB'
    )
    limit = 'at its limit of 5 tasks'
    assert str(Outcome(code=1, limit=limit)) == (
        'exited with code 1 (at its limit of 5 tasks)'
    )
    assert str(Outcome(signal=signal.SIGABRT, limit=limit)) == (
        'died by SIGABRT (aborted) (at its limit of 5 tasks)'
    )
