"""Checkpoint of the finished steps of a survey, from which an interrupted survey resumes."""

from __future__ import annotations

from typing import Any, Protocol

from numpy.typing import NDArray


class StepCheckpoint(Protocol):
    """Results of finished steps by name; a step is complete or absent."""

    def load_step(self, step: str) -> dict[str, NDArray[Any]] | None:
        """Return the results of a step, None if it is not finished."""
        ...

    def save_step(self, step: str, **arrays: NDArray[Any]) -> None:
        """Save the results of a step."""
        ...


class NoCheckpoint:
    """Saves nothing; for surveys that are not resumed."""

    def load_step(self, step: str) -> None:  # noqa: ARG002 as the protocol has it
        """Return None."""
        return

    def save_step(self, step: str, **arrays: NDArray[Any]) -> None:
        """Save nothing."""
