import numpy as np
import pytest
from lamp_room import BEACONS, CAMERA, MOUNT, UNEVEN, pixels_of, random_pose

from shirube_core.geometry import gravity_aligned_camera
from vlc_beacon.core.pose.closed_form import TwoLampSolver
from vlc_beacon.core.pose.lamp_rays import lamp_rays

TILT = (0.04, -0.03)


def closed_form(beacons, pose, known, motions=None):
    pixels = pixels_of(beacons, pose, 0.05, TILT, motions)
    rays = lamp_rays(CAMERA, [beacon.id for beacon in beacons], pixels, np.full(len(beacons), 0.1), motions)
    lamps = np.array([beacon.xyz for beacon in beacons])
    return TwoLampSolver(rays, lamps, gravity_aligned_camera(MOUNT, *TILT), known)


@pytest.mark.parametrize('beacons', [BEACONS, UNEVEN])
@pytest.mark.parametrize('moving', [False, True])
def test_each_pair_contains_the_truth(beacons, moving):
    rng = np.random.default_rng(2)
    for _ in range(20):
        pose = random_pose(rng)
        motions = 0.1 * rng.normal(size=(len(beacons), 3)) if moving else None
        closed = closed_form(beacons, pose, None, motions)
        pairs = closed.widest_pairs(100)
        assert len(pairs) == len(beacons) * (len(beacons) - 1) // 2
        for pair in pairs:
            states = closed.solve_pair(*pair)
            errors = [np.abs(state[:3] - (pose.x, pose.y, 0.05)).max() for state in states]
            assert min(errors) < 1e-6


@pytest.mark.parametrize('height', [None, 0.05])
def test_what_is_known_is_kept(height):
    pose = random_pose(np.random.default_rng(3))
    closed = closed_form(UNEVEN, pose, height)
    states = closed.solve_pair(0, 3)
    best = min(states, key=lambda state: abs(state[0] - pose.x))
    assert best[:4] == pytest.approx([pose.x, pose.y, 0.05, pose.yaw], abs=1e-6)


def test_a_lamp_seen_twice_makes_no_pair():
    pose = random_pose(np.random.default_rng(5))
    assert closed_form([BEACONS[0], BEACONS[0]], pose, None).widest_pairs(5) == []
