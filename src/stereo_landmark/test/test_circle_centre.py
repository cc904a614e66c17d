import math

import cv2
import numpy as np
import pytest
from place_scenes import CAMERA

from stereo_landmark.core.procedure.prediction import ellipse_centre_offset


def outline(centre, normal, radius, count=720):
    """Return points of the circle, shape (count, 3)."""
    first = np.cross(normal, [0.0, 1.0, 0.0])
    first /= np.linalg.norm(first)
    second = np.cross(normal, first)
    second /= np.linalg.norm(second)
    angles = np.linspace(0.0, 2.0 * math.pi, count, endpoint=False)[:, None]
    return centre + radius * (np.cos(angles) * first + np.sin(angles) * second)


@pytest.mark.parametrize('seed', range(10))
def test_an_ellipse_fitted_to_the_outline_has_its_centre_there(seed):
    rng = np.random.default_rng(seed)
    centre = np.array([*rng.uniform(-0.5, 0.5, 2), rng.uniform(1.0, 4.0)])
    normal = np.array([*rng.uniform(-0.8, 0.8, 2), -1.0])
    pixels = CAMERA.pixels_from_points(outline(centre, normal, 0.12))
    # Centred coordinates, because OpenCV's fit uses single precision.
    middle = CAMERA.pixels_from_points(centre[None])[0]
    (u, v), _, _ = cv2.fitEllipseDirect((pixels - middle).astype(np.float32))
    assert ellipse_centre_offset(centre, normal, 0.12, CAMERA) == pytest.approx([u, v], abs=0.003)


def test_a_circle_that_faces_the_camera_has_no_shift():
    shift = ellipse_centre_offset(np.array([0.4, -0.2, 3.0]), np.array([0.0, 0.0, 2.0]), 0.1, CAMERA)
    assert shift == pytest.approx([0.0, 0.0], abs=1e-9)


def test_the_shift_is_towards_the_nearer_half_and_as_large_as_is_said():
    angle, centre = math.radians(10.0), np.array([0.0, 0.0, 3.0])
    # The right side is nearer.
    shift = ellipse_centre_offset(centre, np.array([-math.sin(angle), 0.0, -math.cos(angle)]), 0.09, CAMERA)
    size = CAMERA.fx * 0.09**2 / 9.0 * math.sin(angle)
    assert abs(shift[0]) == pytest.approx(size, rel=0.05)
    near = outline(centre, np.array([-math.sin(angle), 0.0, -math.cos(angle)]), 0.09)
    assert np.sign(shift[0]) == np.sign(near[np.argmin(near[:, 2]), 0])
