"""What a survey has come to so far, so that one that was stopped goes on there."""

from __future__ import annotations

from typing import Any, Protocol

from numpy.typing import NDArray


class SurveyRecord(Protocol):
    """Steps of one survey by their names; a step is there whole or not at all."""

    def recall(self, step: str) -> dict[str, NDArray[Any]] | None:
        """Return what came of a step, None where it has not been done."""
        ...

    def keep(self, step: str, **arrays: NDArray[Any]) -> None:
        """Write down what came of a step."""
        ...


class NoRecord:
    """Of a survey that is not stopped."""

    def recall(self, step: str) -> None:  # noqa: ARG002 as the protocol has it
        """Return that a step has not been done."""
        return

    def keep(self, step: str, **arrays: NDArray[Any]) -> None:
        """Write down nothing."""
