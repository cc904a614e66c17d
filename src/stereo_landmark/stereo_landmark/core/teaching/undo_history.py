"""Undo and redo of immutable states."""

from __future__ import annotations

from typing import Generic, TypeVar

State = TypeVar('State')


class UndoHistory(Generic[State]):
    """History of immutable states with undo and redo.

    Args:
        first: initial state.
    """

    def __init__(self, first: State) -> None:
        self._states = [first]
        self._now = 0
        self._gesture = ''

    @property
    def current(self) -> State:
        """Current state."""
        return self._states[self._now]

    @property
    def can_undo(self) -> bool:
        """Whether there is an earlier state."""
        return self._now > 0

    @property
    def can_redo(self) -> bool:
        """Whether there is an undone state."""
        return self._now + 1 < len(self._states)

    def push(self, state: State, gesture: str = '') -> None:
        """Append a new state; undone states are discarded.

        Args:
            state: new state.
            gesture: name of a gesture, such as one drag of a slider, whose states are undone together; empty for none.
        """
        if gesture and gesture == self._gesture:
            self._states[self._now] = state
            return
        self._states[self._now + 1 :] = [state]
        self._now += 1
        self._gesture = gesture

    def undo(self) -> None:
        """Return to the previous state, if there is one."""
        self._now = max(self._now - 1, 0)
        self._gesture = ''

    def redo(self) -> None:
        """Return to the undone state, if there is one."""
        self._now = min(self._now + 1, len(self._states) - 1)
        self._gesture = ''
