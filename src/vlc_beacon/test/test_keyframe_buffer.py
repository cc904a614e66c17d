import numpy as np
from lamp_room import BEACONS, CAMERA, pixels_of

from shirube_core.geometry import SE2
from vlc_beacon.core.pose.beacon_tracker import KeyframeBuffer
from vlc_beacon.core.pose.lamp_rays import lamp_rays

PLACE = SE2(0.5, 0.5, 0.0)


def rays_from(pose, which):
    return lamp_rays(CAMERA, [BEACONS[which].id], pixels_of([BEACONS[which]], pose), [0.1])


def views_from(*places):
    """Return a buffer with views of the first lamp from x on."""
    views = KeyframeBuffer()
    for x in places:
        views.add(SE2(x, 0.0, 0.0), rays_from(PLACE, 0))
    return views


def test_keyframe_weight_decreases_with_distance():
    joined = views_from(0.0, 0.5, 1.0).merged_with(SE2(1.5, 0.0, 0.0), rays_from(PLACE, 0))
    assert joined.sigmas[0] == 0.1
    assert (np.diff(joined.sigmas[1:]) < 0.0).all()
    assert joined.sigmas[-1] > 1.0


def test_views_from_far_away_are_dropped():
    views, now = views_from(0.0), rays_from(PLACE, 1)
    assert len(views.merged_with(SE2(9.0, 0.0, 0.0), now)) == 1
    views.clear()
    assert len(views.merged_with(PLACE, now)) == 1


def test_a_gap_without_lamps_does_not_push_views_out():
    views, empty = views_from(0.0), lamp_rays(CAMERA, [], np.empty((0, 2)), [])
    for k in range(1, 31):
        views.add(SE2(0.05 * k, 0.0, 0.0), empty)
    joined = views.merged_with(SE2(1.5, 0.0, 0.0), rays_from(SE2(2.0, 0.5, 0.0), 3))
    assert joined.ids.tolist() == [4, 1]
