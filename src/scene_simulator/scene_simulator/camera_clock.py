"""Frame times of a camera with stamp jitter and dropped frames."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scene_simulator.errors import SceneError


@dataclass(frozen=True)
class CameraClock:
    """Frame timing of a camera. The default has no jitter and drops no frames.

    Attributes:
        rate: frames in a second [1/s].
        stamp_jitter: standard deviation of a stamp from the true start of the frame [s].
        drop_fraction: fraction of dropped frames, 0 to below 1.
    """

    rate: float = 60.0
    stamp_jitter: float = 0.0
    drop_fraction: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what no camera does.

        Raises:
            SceneError: a number outside its range.
        """
        if not (0.0 < self.rate < math.inf and 0.0 <= self.stamp_jitter < math.inf):
            raise SceneError(
                f'the camera has rate {self.rate} and jitter {self.stamp_jitter}: give above 0, 0 or more'
            )
        if not 0.0 <= self.drop_fraction < 1.0:
            raise SceneError(
                f'the camera drops a fraction of {self.drop_fraction} of its frames: give 0 to below 1'
            )

    def frames(
        self, seconds: float, rng: np.random.Generator
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the frames that arrive within a time.

        Args:
            seconds: length of the time, which begins at 0 with the first frame [s].
            rng: source of jitter and losses.

        Returns:
            true starts of the frames, shape (n,), and their stamps, shape (n,) [s].

        Raises:
            SceneError: the length is not positive.
        """
        if not 0.0 < seconds < math.inf:
            raise SceneError(f'the recording is {seconds} s long: give a positive number of seconds')
        starts = np.arange(math.ceil(seconds * self.rate - 1e-9)) / self.rate
        stamps = starts + self.stamp_jitter * rng.standard_normal(len(starts))
        arrives = rng.random(len(starts)) >= self.drop_fraction
        return starts[arrives], stamps[arrives]
