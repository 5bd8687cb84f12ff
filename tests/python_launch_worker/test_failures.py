# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Whatever goes wrong in a request, the worker answers."""

from typing import Any, NoReturn

from colcon_yamllaunch.python_launch.worker.visit import Visitor
import pytest


class Kept:
    """A channel that keeps what is said."""

    def __init__(self) -> None:
        self.said: list[dict[str, Any]] = []

    def say(self, what: str, **fields: Any) -> None:
        self.said.append({'say': what, **fields})


class SilentError(Exception):
    """An error without a text."""

    def __str__(self) -> NoReturn:
        raise self


class BareError(KeyError):
    """A key error that lost its key."""

    def __init__(self) -> None:
        self.args = ()


@pytest.mark.parametrize('kind', [SilentError, BareError])
def test_an_error_that_cannot_be_shown_goes_by_its_name(
    kind: type[Exception],
) -> None:
    channel = Kept()
    visitor = Visitor(channel)

    def fail(_request: object) -> NoReturn:
        raise kind

    visitor.requests['fail'] = fail
    visitor.serve({'do': 'fail', 'id': 1})
    (done,) = channel.said
    assert (done['say'], done['id']) == ('done', 1)
    assert done['error']['text'] == kind.__name__


def test_a_scope_that_cannot_be_told_is_an_error() -> None:
    class Scopes:
        def current(self) -> NoReturn:
            raise TypeError('no pair')

    channel = Kept()
    visitor = Visitor(channel)
    visitor.scopes = Scopes()
    visitor.requests['nothing'] = bool
    visitor.serve({'do': 'nothing', 'id': 2})
    (done,) = channel.said
    assert done['id'] == 2
    assert done['error']['text'] == 'TypeError: no pair'
