from dataclasses import replace

import pytest
from random_places import random_place

from shirube_core.geometry import CameraMount
from stereo_landmark.core.pair.pair_localizer import check_cameras
from stereo_landmark.core.stereo import calibration_hash
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError

PLACE = random_place(1)
RIG = PLACE.rig


def test_the_cameras_of_the_place_are_taken():
    check_cameras(PLACE, RIG)
    assert calibration_hash(replace(RIG, baseline=RIG.baseline * (1.0 + 3e-12))) == calibration_hash(RIG)


@pytest.mark.parametrize(
    'other',
    [
        replace(RIG, baseline=RIG.baseline * 1.001),
        replace(RIG, left=replace(RIG.left, cx=RIG.left.cx + 0.01)),
        replace(RIG, right=replace(RIG.right, fx=RIG.right.fx * (1.0 + 5e-7)), left=RIG.left),
    ],
)
def test_other_cameras_are_refused_with_both_hashes(other):
    with pytest.raises(StereoLandmarkError, match='hall was taught with other cameras') as fault:
        check_cameras(PLACE, other)
    assert calibration_hash(RIG) in str(fault.value)
    assert calibration_hash(other) in str(fault.value)


@pytest.mark.parametrize(
    ('mount', 'name'),
    [
        (CameraMount((0.0, 0.0, 1.0), RIG.mount.rpy), 'camera_xyz'),
        (CameraMount(RIG.mount.xyz, (0.0, 0.0, 0.0)), 'camera_rpy'),
    ],
)
def test_another_mount_is_refused(mount, name):
    with pytest.raises(StereoLandmarkError, match=f'was taught with {name} '):
        check_cameras(PLACE, replace(RIG, mount=mount))
