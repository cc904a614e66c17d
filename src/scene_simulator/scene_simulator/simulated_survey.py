"""A floor's dot map as a survey gives it, and as a file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from scene_simulator.dot_floor import DotFloor
from scene_simulator.errors import SceneError
from shirube_core.files import atomic_write

SURVEY_ERROR = 0.00005
"""Standard deviation of a surveyed centre along each axis [m]: what careful photogrammetry reaches."""


def survey_floor(floor: DotFloor, error: float, seed: int) -> NDArray[np.float64]:
    """Return a dot map with errors as a survey leaves them.

    Chips that touch or overlap are listed one by one.

    Args:
        floor: the true floor.
        error: standard deviation of a centre along each axis, and of a diameter [m].
        seed: the same seed gives the same errors.

    Returns:
        array, shape (n, 3): x, y in the map frame and diameter [m].

    Raises:
        SceneError: error negative or not finite.
    """
    if not 0.0 <= error < float('inf'):
        raise SceneError(f'the survey error is {error} m: give zero or a positive number')
    true = np.column_stack([floor.points, floor.diameters])
    return np.asarray(true + np.random.default_rng(seed).normal(0.0, error, true.shape))


def write_dot_map(dots: NDArray[np.float64], path: Path) -> None:
    """Write a dot map as CSV with the header ``x,y,diameter``, complete or not at all.

    Args:
        dots: shape (n, 3), x, y and diameter [m]; written to the micrometre.
        path: file to write; an existing file is replaced.

    Raises:
        SceneError: the file cannot be written.
    """
    try:
        with atomic_write(path) as file:
            np.savetxt(file, dots, fmt='%.6f', delimiter=',', header='x,y,diameter', comments='')
    except OSError as error:
        raise SceneError(f'{path}: cannot be written ({error.strerror}); choose a writable place') from error
