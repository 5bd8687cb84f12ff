# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Classes of data are those that the standard library would make."""

import copy
import dataclasses
from dataclasses import field
import pickle

from colcon_yamllaunch.common import frozen
import pytest


@frozen.dataclass(frozen=True, slots=True)
class Own:
    """Data."""

    name: str
    size: int = 3
    more: dict[str, int] = field(default_factory=dict, compare=False)
    secret: str = field(default='', repr=False)

    @property
    def double(self) -> int:
        """Twice the size."""
        return 2 * self.size


@dataclasses.dataclass(frozen=True, slots=True)
class Standard:
    """Data."""

    name: str
    size: int = 3
    more: dict[str, int] = field(default_factory=dict, compare=False)
    secret: str = field(default='', repr=False)


@frozen.dataclass(frozen=True, slots=True)
class Single:
    """One field."""

    only: str


@frozen.dataclass(frozen=True, slots=True)
class Empty:
    """None at all."""


def test_made_shown_and_compared_alike():
    for arguments, named in (
        (('a',), {}),
        (('a', 4, {'x': 1}), {'secret': 's'}),
        ((), {'name': 'b', 'size': 5}),
    ):
        own, standard = Own(*arguments, **named), Standard(*arguments, **named)
        assert repr(own) == repr(standard).replace('Standard', 'Own')
        assert dataclasses.asdict(own) == dataclasses.asdict(standard)
        assert hash(own) == hash(standard)
        assert own == Own(*arguments, **named)
        assert own != standard
    assert Own('a') != Own('b')
    assert Own('a', more={'x': 1}) == Own('a')
    assert Own('a', secret='s') != Own('a')
    assert Own('a').double == 6


def test_each_object_has_its_own_default():
    assert Own('a').more is not Own('a').more


def test_wrong_arguments():
    with pytest.raises(TypeError, match="'name'"):
        Own()
    with pytest.raises(TypeError, match='unexpected'):
        Own('a', other=1)


def test_nothing_can_be_changed():
    own = Own('a')
    with pytest.raises(dataclasses.FrozenInstanceError):
        own.name = 'b'
    with pytest.raises(dataclasses.FrozenInstanceError):
        del own.name
    with pytest.raises(dataclasses.FrozenInstanceError):
        own.other = 1
    assert own.name == 'a'
    assert not hasattr(own, '__dict__')


@pytest.mark.parametrize(
    'value', [Own('a', 4, {'x': 1}, 's'), Single('a'), Empty()]
)
def test_copies(value):
    assert copy.copy(value) == value
    assert copy.deepcopy(value) == value
    assert pickle.loads(pickle.dumps(value)) == value
    assert dataclasses.replace(value) == value


def test_replace_and_match():
    assert dataclasses.replace(Own('a'), size=7) == Own('a', 7)
    match Own('a', 8):
        case Own('a', size):
            assert size == 8
