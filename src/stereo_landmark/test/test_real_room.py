"""Localization with real images 0.3 m and 15° from the taught pair: a room with a board of 36 square tags."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from stereo_calibrations import RealPairs

from shirube_core.geometry import CameraMount, wrap_angle
from stereo_landmark.core.landmark_localizer import LandmarkFix, LandmarkLocalizer
from stereo_landmark.core.pair.camera_pair import Rectifier, stereo_rig
from stereo_landmark.core.primitives.primitive import ImageProcessing, PrimitiveKind
from stereo_landmark.core.procedure.stereo_view import StereoView, detect_scene
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.primitive_selection import TargetSelection
from stereo_landmark.core.teaching.teacher import Teacher

R_BODY_BASE = np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])
"""The body's x is up, y right and z ahead."""
PRIMITIVES, APART, BORDER, SIZE = 16, 25.0, 45.0, np.array([752, 480])


class Room:
    """Teach and repeat pair: images, true position [m] and roll, pitch, yaw [rad] of the base in the room."""

    def __init__(self):
        pairs = RealPairs()
        T = pairs.T_body_cameras[0]
        R = R_BODY_BASE.T @ T[:3, :3] @ np.array(pairs.calibrations[0].rotation).reshape(3, 3).T
        xyz, rpy = R_BODY_BASE.T @ T[:3, 3], Rotation.from_matrix(R).as_euler('xyz')
        self.rig = stereo_rig(*pairs.calibrations, CameraMount(tuple(xyz.tolist()), tuple(rpy.tolist())))
        self.images, self.positions, self.rpy = {}, {}, {}
        for frame in pairs.truth['frames']:
            w, x, y, z = frame['q_wxyz']
            role = frame['role']
            R_room_base = Rotation.from_quat([x, y, z, w]).as_matrix() @ R_BODY_BASE
            self.rpy[role] = Rotation.from_matrix(R_room_base).as_euler('xyz')
            self.positions[role] = np.array(frame['p'])
            self.images[role] = [
                Rectifier(each).rectify(image) for each, image in zip(pairs.calibrations, pairs.images(role))
            ]

    def error(self, taught, now, fix):
        """Return the error of a displacement [m, rad]."""
        yaw = self.rpy[taught][2]
        shift = Rotation.from_euler('z', -yaw).apply(self.positions[now] - self.positions[taught])
        pose = fix.T_place_base
        turn = wrap_angle(pose.yaw - (self.rpy[now][2] - yaw))
        return np.linalg.norm([pose.x, pose.y, fix.height] - shift), abs(turn)


def drawn(teacher, primitives, rng):
    """Return random measurable primitives inside both images with a minimum spacing, by name."""
    chosen = []
    for i in rng.permutation(len(primitives)):
        primitive = primitives[i]
        inside = (primitive.centre > BORDER).all() and (primitive.centre < SIZE - BORDER).all()
        if not inside or any(np.hypot(*(primitive.centre - each.centre)) < APART for each in chosen):
            continue
        try:
            teacher.measure(primitive)
        except StereoLandmarkError:
            continue
        chosen.append(primitive)
        if len(chosen) == PRIMITIVES:
            break
    return {f'part {i}': each for i, each in enumerate(chosen)}


@pytest.mark.parametrize(('taught', 'now', 'seed'), [('teach', 'repeat', 0), ('repeat', 'teach', 1)])
def test_the_place_is_found_again_though_its_squares_repeat(taught, now, seed):
    room, processing = Room(), ImageProcessing()
    scenes = [detect_scene(image, processing) for image in room.images[taught]]
    teacher = Teacher(StereoView(*scenes, room.rig, tuple(room.rpy[taught][:2])), processing)
    candidates = scenes[0].kinds[PrimitiveKind.QUADRILATERAL].primitives
    choice = TargetSelection('room', drawn(teacher, candidates, np.random.default_rng(seed)))
    place = teacher.teach('room', [choice])
    answer = LandmarkLocalizer([place]).locate(*room.images[now], tuple(room.rpy[now][:2]))
    assert isinstance(answer, LandmarkFix)
    position, turn = room.error(taught, now, answer.displacement)
    assert position < 0.015
    assert turn < np.radians(0.5)
