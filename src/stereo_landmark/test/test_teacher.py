import numpy as np
import pytest
from drawn_wall import Plate, Wall, look, view_of
from place_scenes import RIG

from stereo_landmark.core import stereo as stereo_points_module
from stereo_landmark.core.primitives.primitive import ImageProcessing, PrimitiveKind
from stereo_landmark.core.procedure.stereo_view import StereoView, detect_scene, stereo_points
from stereo_landmark.core.settings import PlaceSettings
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.primitive_selection import TargetSelection
from stereo_landmark.core.teaching.teacher import Teacher

WALL = Wall((Plate(0.1, 0.7, 0.3, 0.2, 60.0),))
CORNERS = np.array([[3.0, 0.1 + dy, 0.7 + dz] for dy in (-0.15, 0.15) for dz in (-0.1, 0.1)])


def teacher_and_plate(rows=0, seed=1):
    """Return a teacher, whose right image may be some rows lower, and the plate."""
    processing = ImageProcessing()
    left, right = look(WALL, np.zeros(6), seed=seed)
    scenes = [detect_scene(image, processing) for image in (left, np.roll(right, rows, axis=0))]
    plate = max(
        scenes[0].kinds[PrimitiveKind.QUADRILATERAL].primitives, key=lambda q: np.ptp(q.corners[:, 0])
    )
    return Teacher(StereoView(*scenes, RIG), processing), plate


def test_taught_points_are_where_they_are():
    teacher, plate = teacher_and_plate()
    points = teacher.coordinates(stereo_points([('plate', *teacher.measure(plate))]))
    assert len(points) == 4
    for position, covariance in zip(points.positions, points.covariances):
        error = position - CORNERS[np.argmin(np.linalg.norm(CORNERS - position, axis=1))]
        assert error @ np.linalg.solve(covariance, error) < 16.0


def test_taught_points_are_not_better_known_than_the_calibration():
    teacher, plate = teacher_and_plate()
    points = teacher.coordinates(stereo_points([('plate', *teacher.measure(plate))]))
    depth = points.positions[:, 0] - RIG.mount.xyz[0]
    by_calibration = np.sqrt(2.0) * PlaceSettings.pixel_sigma * depth**2 / (RIG.left.fx * RIG.baseline)
    assert (np.sqrt(points.covariances[:, 0, 0]) > by_calibration).all()


def test_what_the_images_show_in_different_rows_is_not_taught():
    teacher, plate = teacher_and_plate(rows=1)
    with pytest.raises(StereoLandmarkError, match='rows in both images differ'):
        teacher.measure(plate)


def test_a_target_without_points_is_not_taught():
    teacher, plate = teacher_and_plate()
    with pytest.raises(StereoLandmarkError, match='target sign has no point for the pose'):
        teacher.teach('hall', [TargetSelection('sign', {'plate': plate}, ())])


def test_what_is_around_but_too_far_away_to_be_measured_is_left_out(monkeypatch):
    """The wall recedes to the left: the plate there is farther than the cameras can measure."""
    wall = Wall((Plate(1.6, 0.7, 0.3, 0.2, 60.0), Plate(0.6, 0.7, 0.3, 0.2, 60.0)))
    view = view_of(wall, (0.0, 0.0, 0.0, 0.5, 0.0, 0.0), tuple(PrimitiveKind))
    teacher = Teacher(view, ImageProcessing())
    plates = sorted(
        view.left.kinds[PrimitiveKind.QUADRILATERAL].primitives, key=lambda plate: plate.centre[0]
    )
    choice = [TargetSelection('sign', {'plate': plates[-1]})]
    assert teacher.teach('hall', choice).context_landmarks
    depths = [RIG.left.fx * RIG.baseline / disparity for disparity in disparities(view)]
    monkeypatch.setattr(stereo_points_module, 'DISPARITY_MIN', RIG.left.fx * RIG.baseline / np.mean(depths))
    assert not teacher.teach('hall', choice).context_landmarks


def disparities(view):
    """Return the disparities of the plates, from left to right [px]."""
    sides = [
        sorted(each.centre[0] for each in scene.kinds[PrimitiveKind.QUADRILATERAL].primitives)
        for scene in (view.left, view.right)
    ]
    return np.subtract(*sides)
