"""States that can be gone back to."""

from __future__ import annotations

from typing import Generic, TypeVar

State = TypeVar('State')


class UndoHistory(Generic[State]):
    """Keeps all states since the beginning; the states themselves never change.

    Args:
        first: the state at the beginning.
    """

    def __init__(self, first: State) -> None:
        self._states = [first]
        self._now = 0
        self._gesture = ''

    @property
    def present(self) -> State:
        """The state that holds."""
        return self._states[self._now]

    @property
    def can_undo(self) -> bool:
        """Whether there is an earlier state."""
        return self._now > 0

    @property
    def can_redo(self) -> bool:
        """Whether a step was undone and none was made since."""
        return self._now + 1 < len(self._states)

    def advance(self, state: State, gesture: str = '') -> None:
        """Go on to a new state; what was undone is forgotten.

        Args:
            state: the new state.
            gesture: name of a movement, such as one drag of a slider; all its states are one step. Empty for none.
        """
        if gesture and gesture == self._gesture:
            self._states[self._now] = state
            return
        self._states[self._now + 1 :] = [state]
        self._now += 1
        self._gesture = gesture

    def undo(self) -> None:
        """Go back a step, if there is one."""
        self._now = max(self._now - 1, 0)
        self._gesture = ''

    def redo(self) -> None:
        """Take back an undo, if there was one."""
        self._now = min(self._now + 1, len(self._states) - 1)
        self._gesture = ''
