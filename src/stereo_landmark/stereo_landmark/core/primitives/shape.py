"""What shapes of all kinds share: points with covariance, lazy sequences, differences of angles."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar, overload

import numpy as np

from stereo_landmark.core.arrays import Floats


@dataclass(frozen=True)
class ImagePoint:
    """A measured point in one image.

    Attributes:
        position: pixel coordinates, shape (2,) [px].
        covariance: covariance of the position, shape (2, 2) [px²].
    """

    position: Floats
    covariance: Floats


Shape = TypeVar('Shape')


class LazyShapes(Sequence[Shape], Generic[Shape]):
    """A lazy sequence of shapes. Cluttered images have thousands, of which a search refines a few.

    Args:
        centres: centres of the shapes, shape (n, 2) [px].
        shape_vectors: parameters of the shapes, see the primitive's ``shape_vectors`` function, shape (n, d).
        make: factory that creates the shape of an index; called once per index.
    """

    def __init__(self, centres: Floats, shape_vectors: Floats, make: Callable[[int], Shape]) -> None:
        self.centres, self.shape_vectors = centres, shape_vectors
        self._make = make
        self._cache: dict[int, Shape] = {}

    def __len__(self) -> int:
        return len(self.centres)

    @overload
    def __getitem__(self, index: int) -> Shape: ...

    @overload
    def __getitem__(self, index: slice) -> list[Shape]: ...

    def __getitem__(self, index: int | slice) -> Shape | list[Shape]:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        position = range(len(self))[index]
        if position not in self._cache:
            self._cache[position] = self._make(position)
        return self._cache[position]


def wrap_differences(differences: Floats, period: float) -> Floats:
    """Wrap an array of angle differences to half a period [rad]."""
    return np.asarray(differences - period * np.rint(differences / period), dtype=np.float64)
