# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is known of names behind an action that may not have been done."""

from colcon_yamllaunch.language.evaluation.scope import Guard
from colcon_yamllaunch.language.evaluation.scope import Names
from colcon_yamllaunch.language.evaluation.values import known
import pytest

SOURCES = frozenset(('$(var flag)',))
#: By whether it holds with all launch arguments at their defaults.
GUARDS = {
    taken: Guard('$(var flag)', True, SOURCES, taken)
    for taken in (True, False, None)
}


def after(guard: Guard | None, *, before: str | None = 'old') -> Names:
    """Return the names behind a branch that sets one."""
    names = Names()
    if before is not None:
        names.set('x', known(before))
    inner = names.inner()
    inner.set('x', known('new'))
    names.merge(inner, guard)
    return names


@pytest.mark.parametrize(
    ('taken', 'before', 'text'),
    [
        (True, 'old', 'new'),
        (False, 'old', 'old'),
        (None, 'old', None),
        (True, None, 'new'),
        (False, None, None),
        (None, None, None),
        (None, 'new', 'new'),
    ],
)
def test_a_branch_that_a_launch_decides(
    taken: bool | None, before: str | None, text: str | None
) -> None:
    value = after(GUARDS[taken], before=before).get('x')
    assert value is not None
    assert value.text == text
    assert not value.is_sure or before == 'new'


def test_a_branch_that_is_sure() -> None:
    assert after(None).get('x') == known('new')


def test_values_of_a_branch_that_is_never_done_are_hidden() -> None:
    names = Names()
    names.set('x', known('old'))
    hidden = names.inner(hides=True).get('x')
    assert hidden is not None
    assert hidden.text is None
    masked = names.inner(masked=frozenset(('x',))).get('x')
    assert masked is not None
    assert masked.text is None


@pytest.mark.parametrize(
    ('guard', 'is_given'), [(None, False), (GUARDS[None], None)]
)
def test_a_reset_in_a_branch(
    guard: Guard | None, is_given: bool | None
) -> None:
    names = Names()
    names.set('x', known('old'))
    inner = names.inner()
    inner.clear()
    names.merge(inner, guard)
    assert names.is_given is is_given
    value = names.get('x')
    assert value is None or value.text is None


def test_the_order_of_names_is_that_of_their_first_values() -> None:
    names = Names()
    names.set('b', known('1'))
    names.set('a', known('2'))
    inner = names.inner()
    inner.set('c', known('3'))
    inner.set('b', known('4'))
    found = {name: value.text for name, value in inner.all().items()}
    assert list(found.items()) == [('b', '4'), ('a', '2'), ('c', '3')]
