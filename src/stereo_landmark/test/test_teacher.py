import numpy as np
import pytest
from drawn_wall import Plate, Wall, detect_view, from_left, look, teach_view, view_of
from place_scenes import RIG

from stereo_landmark.core import stereo as stereo_points_module
from stereo_landmark.core.primitives.primitive import ImageProcessing, PrimitiveKind
from stereo_landmark.core.procedure.stereo_view import stereo_points
from stereo_landmark.core.settings import PlaceSettings
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.primitive_selection import TargetSelection
from stereo_landmark.core.teaching.teacher import Teacher

WALL = Wall((Plate(0.1, 0.7, 0.3, 0.2, 60.0),))
CORNERS = np.array([[3.0, 0.1 + dy, 0.7 + dz] for dy in (-0.15, 0.15) for dz in (-0.1, 0.1)])


def teacher_and_plate(rows=0):
    """Return a teacher, whose right image may be some rows lower, and the plate."""
    left, right = look(WALL, np.zeros(6))
    view = detect_view((left, np.roll(right, rows, axis=0)))
    plates = view.left.kinds[PrimitiveKind.QUADRILATERAL].primitives
    return Teacher(view, ImageProcessing()), max(plates, key=lambda plate: np.ptp(plate.corners[:, 0]))


def test_taught_points_are_where_they_are_and_not_better_known_than_the_calibration():
    teacher, plate = teacher_and_plate()
    points = teacher.coordinates(stereo_points([('plate', *teacher.measure(plate))]))
    assert len(points) == 4
    for position, covariance in zip(points.positions, points.covariances):
        error = position - CORNERS[np.argmin(np.linalg.norm(CORNERS - position, axis=1))]
        assert error @ np.linalg.solve(covariance, error) < 16.0
    depth = points.positions[:, 0] - RIG.mount.xyz[0]
    by_calibration = np.sqrt(2.0) * PlaceSettings.pixel_sigma * depth**2 / (RIG.left.fx * RIG.baseline)
    assert (np.sqrt(points.covariances[:, 0, 0]) > by_calibration).all()


def test_what_the_images_show_in_different_rows_is_not_taught():
    teacher, plate = teacher_and_plate(rows=1)
    with pytest.raises(StereoLandmarkError, match='at different heights'):
        teacher.measure(plate)


def test_a_target_without_points_is_not_taught():
    teacher, plate = teacher_and_plate()
    with pytest.raises(StereoLandmarkError, match='target sign has no point for the pose'):
        teacher.teach('hall', [TargetSelection('sign', {'plate': plate}, ())])


def test_what_is_around_but_too_far_away_to_be_measured_is_left_out(monkeypatch):
    """The wall recedes to the left: the plate there is farther than the cameras can measure."""
    wall = Wall((Plate(1.6, 0.7, 0.3, 0.2, 60.0), Plate(0.6, 0.7, 0.3, 0.2, 60.0)))
    view = view_of(wall, (0.0, 0.0, 0.0, 0.5, 0.0, 0.0))
    parts = {'sign': from_left(view, PrimitiveKind.QUADRILATERAL)[-1]}
    assert teach_view(view, parts).context_landmarks
    left, right = (
        sorted(each.centre[0] for each in scene.kinds[PrimitiveKind.QUADRILATERAL].primitives)
        for scene in (view.left, view.right)
    )
    between = 1.0 / np.mean(1.0 / np.subtract(left, right))
    monkeypatch.setattr(stereo_points_module, 'DISPARITY_MIN', between)
    assert not teach_view(view, parts).context_landmarks
