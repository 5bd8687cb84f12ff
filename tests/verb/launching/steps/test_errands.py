# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is done for several machines at once."""

import threading

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.verb.machines import Errands
import pytest


def fails(error):
    def do():
        raise error

    return do


def test_all_is_done_at_once():
    # each waits for the other one
    meeting = threading.Barrier(2, timeout=60)
    errands = Errands({'a': meeting.wait, 'b': meeting.wait})
    assert errands.wait()
    errands.check()
    assert sorted(errands.results.values()) == [0, 1]


def test_all_that_went_wrong_is_told_in_one_error():
    first, second = UserError('a: off'), UserError('b: off')
    errands = Errands({'a': fails(first), 'c': int, 'b': fails(second)})
    errands.wait()
    with pytest.raises(UserError, match=r'^a: off\nb: off$'):
        errands.check()
    assert errands.results == {'c': 0}


def test_what_was_put_right_is_no_error():
    errands = Errands({'a': fails(UserError('off'))})
    errands.wait()
    assert list(errands.errors) == ['a']
    errands.forgive('a')
    errands.check()


def test_a_fault_of_ours_is_told_as_such():
    errands = Errands({'a': fails(KeyError('x')), 'b': fails(UserError('y'))})
    errands.wait()
    with pytest.raises(KeyError):
        errands.check()


def test_it_is_waited_for_no_longer_than_wanted():
    end = threading.Event()
    errands = Errands({'a': lambda: end.wait(60)})
    assert not errands.wait(0.0)
    end.set()
    assert errands.wait()
