"""Undo is the inverse of an edit, redo that of undo."""

from hypothesis import given
from hypothesis import strategies as st

from stereo_landmark.core.teaching.undo_history import UndoHistory

ACTIONS = st.lists(st.one_of(st.integers(0, 99), st.sampled_from(['undo', 'redo'])), max_size=30)


@given(ACTIONS)
def test_undo_and_redo_walk_along_the_states(actions):
    history, past, future = UndoHistory(-1), [-1], []
    for action in actions:
        if action == 'undo':
            history.undo()
            if len(past) > 1:
                future.append(past.pop())
        elif action == 'redo':
            history.redo()
            if future:
                past.append(future.pop())
        else:
            history.push(action)
            past, future = [*past, action], []
        assert history.current == past[-1]
        assert history.can_undo == (len(past) > 1)
        assert history.can_redo == bool(future)


def test_a_movement_is_one_step():
    history = UndoHistory(0)
    for value in (1, 2, 3):
        history.push(value, 'first')
    history.push(4, 'second')
    history.push(5)
    history.push(6)
    states = []
    while history.can_undo:
        history.undo()
        states.append(history.current)
    assert states == [5, 4, 3, 0]


def test_a_movement_does_not_go_on_over_an_undo():
    history = UndoHistory(0)
    history.push(1, 'drag')
    history.undo()
    history.push(2, 'drag')
    history.undo()
    assert history.current == 0
