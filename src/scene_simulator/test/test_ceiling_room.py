"""The ceiling's texture where ray tracing finds it."""

import numpy as np
import pytest

from scene_simulator.ceiling.lamp_profile import face_homographies
from scene_simulator.ceiling.room import CeilingSurface, panelled_ceiling
from scene_simulator.errors import SceneError
from scene_simulator.imaging.exposure import camera_pose
from shirube_core.geometry import SE2, CameraMount, PinholeCamera

CAMERA = PinholeCamera(80, 60, 60.0, 62.0, 41.0, 28.0, (-0.1, 0.02, 0.0, 0.0, 0.0))
POSE = camera_pose(SE2(-0.7, 3.1, 0.8), CameraMount((0.0, 0.0, 0.2), (0.1, -0.05, 0.3)))


def with_ambient_light(surface: CeilingSurface, levels: np.ndarray) -> np.ndarray:
    v, u = np.mgrid[-1:61, -1:81]
    rays = CAMERA.rays_from_pixels(np.column_stack([u.ravel(), v.ravel()]))[:, :2].reshape(62, 82, 2)
    one = face_homographies((0.0, 0.0, surface.height), np.eye(3), POSE.position[None], POSE.rotation[None])
    light = np.zeros((60, 80), dtype=np.float32)
    surface.add_light(light, rays.copy(), np.tile(one, (60, levels.shape[1], 1, 1)), levels)
    return light


def test_each_pixel_sees_the_ceiling_that_its_ray_meets() -> None:
    surface = panelled_ceiling(2.5, 1.0, 0.15, seed=3)
    light = with_ambient_light(surface, np.ones((60, 1)))
    for u, v in np.random.default_rng(0).integers(0, 60, (50, 2)):
        ray = POSE.rotation @ CAMERA.rays_from_pixels([(u, v)])[0]
        x, y, _ = POSE.position + ray * (2.5 - POSE.position[2]) / ray[2]
        column, row = x / 0.0046875, y / 0.0046875
        i, j = int(np.floor(row)), int(np.floor(column))
        a, b = row - i, column - j
        corners = surface.tile[np.ix_([i % 1024, (i + 1) % 1024], [j % 1024, (j + 1) % 1024])]
        assert light[v, u] == pytest.approx(float([1.0 - a, a] @ corners @ [1.0 - b, b]), abs=1e-4)


def test_rows_get_their_own_light_and_instants_add_up() -> None:
    surface = panelled_ceiling(2.5, 1.0, 0.1, seed=3)
    whole = with_ambient_light(surface, np.ones((60, 1)))
    levels = np.random.default_rng(1).uniform(0.0, 1.0, (60, 3))
    expected = whole * levels.sum(axis=1)[:, None]
    np.testing.assert_allclose(with_ambient_light(surface, levels), expected, rtol=1e-4)


def test_its_texture_has_the_contrast_and_repeats_without_a_seam() -> None:
    tile = panelled_ceiling(2.5, 1.0, 0.08, seed=2).tile
    panel = tile[4:124, 4:124]
    assert panel.std() == pytest.approx(0.08, rel=0.4)
    assert np.median(tile[:, 0]) == pytest.approx(1.0 - 2.0 * 0.08, abs=0.02)
    inside = np.delete(tile, np.r_[0:1024:128, 1:1024:128], axis=0)
    steps = np.abs(np.diff(np.vstack([inside, inside[:1]]), axis=0)).max(axis=1)
    # Over the joint that is left out and from the last row to the first it changes like over any other.
    assert steps[-1] < 1.2 * steps[:-1].max()


@pytest.mark.parametrize(('ambient', 'contrast', 'seed'), [(-1.0, 0.1, 0), (1.0, 0.3, 0), (1.0, 0.1, -1)])
def test_a_ceiling_that_cannot_be_is_refused(ambient: float, contrast: float, seed: int) -> None:
    with pytest.raises(SceneError):
        panelled_ceiling(2.5, ambient, contrast, seed)
