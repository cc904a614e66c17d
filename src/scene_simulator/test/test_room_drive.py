"""The drive is clear of furniture, and equal settings give equal images."""

import numpy as np
import pytest

from scene_simulator.room.room_drive import RoomDrive


@pytest.mark.parametrize('seed', [1, 2, 3])
def test_the_drive_hits_nothing(seed):
    scene = RoomDrive(seed)
    poses = [scene.drive.pose_at(t) for t in np.arange(0.0, scene.drive.duration, 0.05)]
    way = np.array([(pose.x, pose.y) for pose in poses])
    assert min(piece.distances_to(way).min() for piece in scene.room.furniture) > 0.45
    low, high = np.array(scene.size[:2]), np.array(scene.size[3:5])
    assert np.minimum(way - low, high - way).min() > 0.45


def test_pictures_of_a_place_differ_by_their_noise():
    one, other = (RoomDrive(1).pictures(index, 2.0) for index in (4, 5))
    for name in ('left', 'right', 'top'):
        assert 0.5 < np.abs(one[name].astype(float) - other[name]).mean() < 5.0


def test_the_localizer_is_a_little_off():
    scene = RoomDrive(1)
    errors = [scene.localizer_pose(k, 0.1 * k).distance_to(scene.drive.pose_at(0.1 * k)) for k in range(200)]
    assert np.sqrt(np.mean(np.square(errors)) / 2.0) == pytest.approx(scene.pose_noise[0], rel=0.15)
