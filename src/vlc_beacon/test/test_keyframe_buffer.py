import numpy as np
import pytest
from lamp_room import BEACONS, CAMERA, MOUNT, pixels_of

from shirube_core.geometry import SE2
from vlc_beacon.core.pose.beacon_locator import BeaconLocator
from vlc_beacon.core.pose.keyframe_buffer import KeyframeBuffer
from vlc_beacon.core.pose.lamp_rays import lamp_rays


def rays_from(pose, which):
    pixels = pixels_of([BEACONS[which]], pose)
    return lamp_rays(CAMERA, [BEACONS[which].id], pixels, [0.1])


def test_lamps_seen_one_after_the_other_give_the_pose_of_now():
    odometry = [SE2(0.0, 0.0, 0.0), SE2(0.3, 0.1, 0.4), SE2(0.6, 0.4, 0.9)]
    T_map_odom = SE2(0.5, 0.4, 1.1)
    views = KeyframeBuffer()
    for k, T_odom_base in enumerate(odometry[:2]):
        views.add(T_odom_base, rays_from(T_map_odom @ T_odom_base, k))
    now = T_map_odom @ odometry[2]
    joined = views.merged_with(odometry[2], rays_from(now, 3))
    assert len(joined) == 3
    assert joined.views.tolist() == [0, 1, 2]
    fix = BeaconLocator(BEACONS, MOUNT).locate(joined)
    assert fix.T_map_base.distance_to(now) < 1e-6
    assert fix.T_map_base.yaw_to(now) == pytest.approx(0.0, abs=1e-6)


def test_keyframe_weight_decreases_with_distance():
    views = KeyframeBuffer()
    for x in (0.0, 0.5, 1.0):
        views.add(SE2(x, 0.0, 0.0), rays_from(SE2(0.5, 0.5, 0.0), 0))
    joined = views.merged_with(SE2(1.5, 0.0, 0.0), rays_from(SE2(0.5, 0.5, 0.0), 0))
    assert joined.sigmas[0] == 0.1
    assert (np.diff(joined.sigmas[1:]) < 0.0).all()
    assert joined.sigmas[-1] > 1.0


def test_views_from_far_away_are_dropped():
    views = KeyframeBuffer()
    views.add(SE2(0.0, 0.0, 0.0), rays_from(SE2(0.5, 0.5, 0.0), 0))
    now = rays_from(SE2(0.5, 0.5, 0.0), 1)
    assert len(views.merged_with(SE2(9.0, 0.0, 0.0), now)) == 1
    views.clear()
    assert len(views.merged_with(SE2(0.5, 0.0, 0.0), now)) == 1


def test_a_gap_without_lamps_does_not_push_views_out():
    views, empty = KeyframeBuffer(), lamp_rays(CAMERA, [], np.empty((0, 2)), [])
    views.add(SE2(0.0, 0.0, 0.0), rays_from(SE2(0.5, 0.5, 0.0), 0))
    for k in range(1, 31):
        views.add(SE2(0.05 * k, 0.0, 0.0), empty)
    joined = views.merged_with(SE2(1.5, 0.0, 0.0), rays_from(SE2(2.0, 0.5, 0.0), 3))
    assert joined.ids.tolist() == [4, 1]
