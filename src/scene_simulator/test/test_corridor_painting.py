"""Coverage of samples is exact: the same as by the other way of counting; the grain is without a seam."""

import numpy as np
import pytest
from numpy.typing import NDArray

from scene_simulator.corridor.painting import SAMPLES, paint_outline, plaster
from scene_simulator.floor.dot_floor import polygon_areas, random_chips
from scene_simulator.floor.view import paint_polygons


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


SIZE = 40


def painted(outline: NDArray[np.float64], grain: float = 0.0, opacity: float = 1.0) -> NDArray[np.float32]:
    """Paint white on black; the plane is 1 m before the camera, the rays span 0.4 m."""
    picture = np.zeros((SIZE, SIZE), dtype=np.float32)
    sums = np.zeros((SIZE, SIZE + 2), dtype=np.float32)
    pixels = SIZE // SAMPLES
    v, u = (np.mgrid[:pixels, :pixels] + 0.5) / pixels * 0.4
    rays = np.stack([u, v], axis=-1).astype(np.float32)
    texture = plaster()
    shading = (np.array([1.0, grain, opacity, 0.0, 0.0]), np.eye(3), np.array([1.0, 0.0, 0.0, 0.4 / pixels]))
    paint_outline(picture, sums, outline, rays, shading, (texture.samples, texture.starts, texture.sizes))
    assert not sums.any()
    return picture


def test_coverage_is_that_of_the_other_painter() -> None:
    rng = np.random.default_rng(3)
    for outline in random_chips(rng.uniform(2.0, 18.0, 60), rng, corners=(3, 9)) + 20.0:
        expected = np.zeros((SIZE, SIZE, 1), dtype=np.float32)
        corners = outline[None] - 0.5
        paint_polygons(expected, np.zeros((SIZE, SIZE), np.float32), corners, np.ones((1, 1)), np.ones(1))
        seen = painted(outline)
        np.testing.assert_allclose(seen, expected[:, :, 0], atol=2e-5)
        assert seen.sum() == pytest.approx(polygon_areas(outline[None])[0], rel=1e-4)


WHOLE = np.array([(0.0, 0.0), (0.0, 40.0), (40.0, 40.0), (40.0, 0.0)])


def test_a_shape_may_touch_the_borders_and_let_the_ground_shine_through() -> None:
    assert (painted(WHOLE) == 1.0).all()
    np.testing.assert_allclose(painted(WHOLE, opacity=0.3), 0.3, rtol=1e-6)
    corner = np.array([(30.5, 0.0), (40.0, 0.0), (40.0, 9.5)])
    assert painted(corner).sum() == pytest.approx(0.5 * 9.5**2, rel=1e-5)


def test_grain_is_the_texture_at_the_place_on_the_plane() -> None:
    seen = painted(WHOLE, grain=0.1)[::SAMPLES, ::SAMPLES]
    # A pixel of 20 mm is seen through the level of 32 mm.
    texture = plaster()
    level, spacing = 3, 0.032
    size, start = texture.sizes[level], texture.starts[level]
    tile = texture.samples[start : start + size**2].reshape(size, size)
    at = np.array([0.01, 0.21, 0.39]) / spacing - 0.5
    low = np.floor(at).astype(int)
    part = at - low
    rows = tile[low % size] * (1.0 - part)[:, None] + tile[(low + 1) % size] * part[:, None]
    expected = rows[:, low % size] * (1.0 - part) + rows[:, (low + 1) % size] * part
    np.testing.assert_allclose(seen[np.ix_([0, 10, 19], [0, 10, 19])], 1.0 + 0.1 * expected, rtol=1e-4)
