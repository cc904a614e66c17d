import numpy as np
import pytest
from consistency import whitened_rms
from place_scenes import RIG, errors_of, panel, random_state, teach, view

from shirube_core.geometry import SE2
from stereo_landmark.core.place.place_locator import PlaceLocator
from stereo_landmark.core.place.point_registration import Displacement, closed_form, closed_form_covariance
from stereo_landmark.core.stereo import SpatialPoints


def transform(displacement, taught):
    """Transform taught points into the current frame by the paper's equation (3.1)."""
    cos, sin = np.cos(displacement.theta_z), np.sin(displacement.theta_z)
    turn = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
    return taught @ turn.T + [displacement.dx, displacement.dy, displacement.dz]


def test_a_robot_that_drove_ahead_and_turned_left_is_there():
    """The sign: moving ahead brings points nearer, and the pose is the inverse of their motion."""
    pose = SE2(0.3, 0.1, 0.2)
    taught = panel()
    found = np.column_stack([pose.inverse().transform(taught[:, :2]), taught[:, 2]])
    displacement = closed_form(found, taught)
    assert displacement.pose.x == pytest.approx(0.3)
    assert displacement.pose.y == pytest.approx(0.1)
    assert displacement.theta_z == displacement.pose.yaw == pytest.approx(0.2)
    ahead = closed_form(taught - [0.3, 0.0, 0.0], taught)
    assert (ahead.dx, ahead.pose.x) == pytest.approx((-0.3, 0.3))


def test_the_papers_equation_takes_taught_points_to_found_ones():
    taught, displacement = panel(), Displacement(0.1, -0.2, 0.03, 0.4)
    again = closed_form(transform(displacement, taught), taught)
    assert (again.dx, again.dy, again.dz, again.theta_z) == pytest.approx((0.1, -0.2, 0.03, 0.4))
    assert again.height == pytest.approx(-0.03)


def test_two_points_are_enough_unless_one_is_above_the_other():
    taught = panel(count=2)
    assert closed_form(taught[:1], taught[:1]) is None
    assert closed_form(transform(Displacement(0.1, 0.0, 0.0, 3.0), taught), taught).theta_z == pytest.approx(3.0)
    above = np.array([[2.0, 0.0, 0.5], [2.0, 0.001, 1.0]])
    assert closed_form(above, above) is None


def test_the_covariance_is_that_of_the_errors():
    rng = np.random.default_rng(5)
    points, state = panel(), random_state(rng)
    errors = []
    for _ in range(300):
        taught = teach(points, 0.1, rng)
        found = PlaceLocator(RIG).spatial_points(view(points, state, 0.1, rng))
        displacement = closed_form(found.positions, taught.positions)
        errors.append(errors_of(displacement.pose, displacement.height, state))
    assert whitened_rms(errors, closed_form_covariance(found, taught)) == pytest.approx(1.0, abs=0.08)


def test_exact_points_have_no_covariance():
    points = SpatialPoints(('a', 'b', 'c'), panel(count=3), np.zeros((3, 3, 3)))
    assert closed_form_covariance(points, points) == pytest.approx(np.zeros((4, 4)))
