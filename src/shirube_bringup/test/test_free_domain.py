"""A reserved domain is exclusive, and errors in its context are not hidden."""

import pytest

from shirube_bringup.free_domain import free_domain


def test_two_at_once_are_different_and_one_that_was_left_is_not_taken_next():
    drawn = set()
    for _ in range(4):
        with free_domain() as one, free_domain() as other:
            assert one != other
        drawn.add(one)
    assert len(drawn) > 1


@pytest.mark.parametrize('error', [TimeoutError('nobody answers'), FileNotFoundError(2, 'no', 'a'), KeyError(1)])
def test_errors_in_the_context_are_not_changed(error):
    with pytest.raises(type(error)) as caught, free_domain():
        raise error
    assert caught.value is error
