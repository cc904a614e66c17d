"""Where a survey keeps what does not fit into memory, and its finished steps."""

from typing import Any, Protocol

from numpy.typing import NDArray


class ArrayStore(Protocol):
    """Arrays by name and number, also visible to tasks in other processes."""

    def put(self, name: str, number: int, *arrays: NDArray[Any]) -> None:
        """Store arrays; they replace those of the same name and number."""
        ...

    def get(self, name: str, number: int) -> tuple[NDArray[Any], ...]:
        """Return stored arrays."""
        ...

    def memory_map(self, name: str) -> NDArray[Any]:
        """Return the first array of number 0, read-only; only the parts that are accessed are read."""
        ...


class MemoryArrayStore:
    """Array store in memory, for one process."""

    def __init__(self) -> None:
        """Begin empty."""
        self._arrays: dict[tuple[str, int], tuple[NDArray[Any], ...]] = {}

    def put(self, name: str, number: int, *arrays: NDArray[Any]) -> None:
        """Store arrays; they replace those of the same name and number."""
        self._arrays[name, number] = arrays

    def get(self, name: str, number: int) -> tuple[NDArray[Any], ...]:
        """Return stored arrays."""
        return self._arrays[name, number]

    def memory_map(self, name: str) -> NDArray[Any]:
        """Return the first array of number 0."""
        return self._arrays[name, 0][0]


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
