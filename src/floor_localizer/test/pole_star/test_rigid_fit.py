"""The pose from paired dots."""

import numpy as np
import pytest

from floor_localizer.core.pole_star.congruence import fit_pose
from shirube_core.geometry import SE2

RNG = np.random.default_rng(8)
VIEW = RNG.uniform(-0.045, 0.045, (20, 2))


@pytest.mark.parametrize('yaw', [-3.1, -1.0, 0.0, 0.4, 2.0, 3.1])
def test_the_pose_that_moved_the_dots_comes_back(yaw: float) -> None:
    T_map_view = SE2(1.2, 7.5, yaw)
    fitted = fit_pose(VIEW, T_map_view.transform(VIEW))
    assert fitted.distance_to(T_map_view) < 1e-12
    assert abs(fitted.yaw_to(T_map_view)) < 1e-12


def test_no_pose_nearby_has_smaller_residuals() -> None:
    map_points = SE2(0.3, 0.2, 1.0).transform(VIEW) + RNG.normal(0.0, 0.0004, VIEW.shape)
    fitted = fit_pose(VIEW, map_points)
    best = np.sum((fitted.transform(VIEW) - map_points) ** 2)
    for step in RNG.normal(0.0, 1e-4, (100, 3)):
        near = SE2(fitted.x + step[0], fitted.y + step[1], fitted.yaw + step[2])
        assert np.sum((near.transform(VIEW) - map_points) ** 2) >= best


def test_mirrored_dots_are_not_fitted() -> None:
    mirrored = VIEW * (1.0, -1.0)
    residuals = fit_pose(VIEW, mirrored).transform(VIEW) - mirrored
    assert np.linalg.norm(residuals, axis=1).max() > 0.01
