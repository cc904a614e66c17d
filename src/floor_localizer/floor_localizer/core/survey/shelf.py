"""Where arrays are put that are too many to be kept in memory; this one keeps them all the same, for what is small."""

from __future__ import annotations

from typing import Any, Protocol

from numpy.typing import NDArray


class Shelf(Protocol):
    """Arrays by name and number. Tasks in other processes see what is on it."""

    def put(self, name: str, number: int, *arrays: NDArray[Any]) -> None:
        """Put arrays away; they replace those of the same name and number."""
        ...

    def get(self, name: str, number: int) -> tuple[NDArray[Any], ...]:
        """Return arrays that were put away."""
        ...

    def look_up(self, name: str) -> NDArray[Any]:
        """Return the first of the arrays of number 0, not to be changed; only what is asked of it gets into memory."""
        ...


class MemoryShelf:
    """A shelf in memory."""

    def __init__(self) -> None:
        """Begin empty."""
        self._arrays: dict[tuple[str, int], tuple[NDArray[Any], ...]] = {}

    def put(self, name: str, number: int, *arrays: NDArray[Any]) -> None:
        """Put arrays away; they replace those of the same name and number."""
        self._arrays[name, number] = arrays

    def get(self, name: str, number: int) -> tuple[NDArray[Any], ...]:
        """Return arrays that were put away."""
        return self._arrays[name, number]

    def look_up(self, name: str) -> NDArray[Any]:
        """Return the first of the arrays of number 0."""
        return self._arrays[name, 0][0]
