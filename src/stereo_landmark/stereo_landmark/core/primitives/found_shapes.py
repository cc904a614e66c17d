"""Lazy sequence of detected shapes: parameters as arrays, objects are created on access."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Generic, TypeVar, overload

import numpy as np
from numpy.typing import NDArray

Shape = TypeVar('Shape')


class FoundShapes(Sequence[Shape], Generic[Shape]):
    """A lazy sequence of shapes. Cluttered images have thousands, of which a search refines a few.

    Args:
        centres: centres of the shapes, shape (n, 2) [px].
        shape_vectors: parameters of the shapes, see the primitive's ``shape_vectors`` function, shape (n, d).
        make: factory that creates the shape of an index; called once per index.
    """

    def __init__(
        self, centres: NDArray[np.float64], numbers: NDArray[np.float64], make: Callable[[int], Shape]
    ) -> None:
        self.centres, self.numbers = centres, numbers
        self._make = make
        self._made: dict[int, Shape] = {}

    def __len__(self) -> int:
        return len(self.centres)

    @overload
    def __getitem__(self, index: int) -> Shape: ...

    @overload
    def __getitem__(self, index: slice) -> list[Shape]: ...

    def __getitem__(self, index: int | slice) -> Shape | list[Shape]:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        number = range(len(self))[index]
        if number not in self._made:
            self._made[number] = self._make(number)
        return self._made[number]
