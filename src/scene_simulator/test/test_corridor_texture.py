"""The grain is without a seam, and each level is the mean of the one before."""

from __future__ import annotations

import numpy as np
import pytest

from scene_simulator.corridor_texture import plaster


def test_the_grain_has_mean_zero_deviation_one_and_no_seam() -> None:
    grain = plaster()
    size = grain.sizes[0]
    tile = grain.samples[: size * size].reshape(size, size)
    assert tile.mean() == pytest.approx(0.0, abs=1e-5)
    assert tile.std() == pytest.approx(1.0, rel=1e-3)
    inside = np.abs(np.diff(tile, axis=1)).mean()
    assert np.abs(tile[:, 0] - tile[:, -1]).mean() == pytest.approx(inside, rel=0.15)


def test_coarser_levels_are_means() -> None:
    grain = plaster()
    fine, coarse = (
        grain.samples[start : start + size * size].reshape(size, size)
        for start, size in zip(grain.starts[1:3], grain.sizes[1:3], strict=True)
    )
    means = fine.reshape(len(coarse), 2, len(coarse), 2).mean(axis=(1, 3))
    np.testing.assert_allclose(coarse, means, atol=1e-5)
