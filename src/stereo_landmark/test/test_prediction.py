import math
import warnings

import cv2
import numpy as np
import pytest
from drawn_wall import Disc, Plate, Wall, from_left, teach_view, view_of
from place_scenes import CAMERA, RIG, panel

from stereo_landmark.core.place.joint_fit import reproject
from stereo_landmark.core.primitives.primitive import PrimitiveKind
from stereo_landmark.core.procedure.coarse_pose import image_distances, poses_from_match, predict_pixels
from stereo_landmark.core.procedure.stereo_view import StereoView
from stereo_landmark.core.procedure.target_search import TargetSearch
from stereo_landmark.core.procedure.taught_place import centre_correction, ellipse_centre_offset, wall_normal

TILT = (0.04, -0.06)
VIEW = StereoView(None, None, RIG, TILT)


def test_points_are_expected_where_the_model_of_the_fit_projects_them():
    points, states = panel(), np.random.default_rng(1).uniform(-0.3, 0.3, (5, 4))
    for state, pixels in zip(states, predict_pixels(states, points, VIEW), strict=True):
        assert pixels == pytest.approx(reproject(np.array([*state, *TILT]), points, RIG).pixels, abs=1e-9)


def test_poses_through_a_point_see_it_where_it_was_found():
    found = np.array([[3.0, 0.2, 0.7], [2.5, -0.3, 0.9]])
    states = poses_from_match(np.array([3.1, 0.1, 0.75]), found, np.array([-0.2, 0.0, 0.3]))
    pixels = predict_pixels(states.reshape(-1, 4), np.array([[3.1, 0.1, 0.75]]), VIEW).reshape(2, 3, 4)
    there = predict_pixels(np.zeros((1, 4)), found, VIEW)[0]
    assert pixels == pytest.approx(np.repeat(there[:, None], 3, axis=1), abs=1e-6)


def test_poses_are_apart_by_what_they_have_before_them_in_common():
    states = np.zeros((4, 4))
    states[1:3, 3], states[3, 0] = (0.01, math.pi), 3.5
    points = np.vstack([panel(), [[6.0, 0.0, 0.6]]])
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        same, turned, away, beyond = image_distances(states, points, VIEW)
        behind = image_distances(states[[2, 0]], points, VIEW)
    assert same == 0.0
    assert turned == pytest.approx(0.01 * RIG.left.fx, rel=0.1)
    assert math.isinf(away)
    assert 0.0 < beyond < 60.0
    assert np.isinf(behind).all()


def test_the_wall_is_the_line_with_most_things_on_it():
    rng = np.random.default_rng(1)
    for angle in (-0.7, -0.2, 0.0, 0.5):
        along = np.array([-math.sin(angle), math.cos(angle)])
        wall = np.array([3.0, 0.3]) + np.linspace(-0.6, 0.6, 7)[:, None] * along
        heights = rng.uniform(0.0, 1.0, (7, 1))
        things = np.vstack([np.hstack([wall, heights]), [[2.0, 0.5, 0.3], [1.5, -0.8, 1.0]]])
        normal = wall_normal(things[3], things)
        assert normal == pytest.approx([-math.cos(angle), -math.sin(angle), 0.0], abs=1e-6)


def test_a_thing_alone_faces_the_robot():
    position = np.array([3.0, 4.0, 1.0])
    assert wall_normal(position, position[None]) == pytest.approx([-0.6, -0.8, 0.0])


def test_centres_of_circles_are_measured_where_they_were_taught():
    """From a viewpoint 15 degrees to the side, the ellipse centre of a large disc is biased by half a pixel."""
    wall = Wall((Disc(0.3, 0.7, 0.2, 60.0), Plate(-0.4, 0.7, 0.4, 0.3, 220.0)))
    view = view_of(wall, np.zeros(6), noise=0.5)
    parts = {'dial': from_left(view)[0], 'panel': from_left(view, PrimitiveKind.QUADRILATERAL)[0]}
    place = teach_view(view, parts)
    (target,) = place.targets
    assert target.primitives[0].normal == pytest.approx([-1.0, 0.0, 0.0], abs=0.02)
    state = np.array([0.3, -0.5, 0.0, 0.26, 0.0, 0.0])
    found = TargetSearch(place).search(target, view_of(wall, state, noise=0.5))
    seen = found.points.pixels[found.points.names.index('target/dial/centre')]
    true = reproject(state, np.array([[3.0, 0.3, 0.7]]), place.rig).pixels[0]
    assert seen == pytest.approx(true, abs=0.08)
    moved = centre_correction(target.primitives[0], state[:4], view)
    assert np.hypot(*moved[:2]) > 0.4


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
