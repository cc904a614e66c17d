"""Poses from identified lamps, by every method."""

from __future__ import annotations

import math

import numpy as np
import pytest
from lamp_room import BEACONS, CAMERA, MOUNT, pixels_of

from shirube_core.geometry import SE2
from vlc_beacon.core.lamp_image.lamp_tracker import LampSample
from vlc_beacon.core.pose.pose_fix import BeaconFix, NoBeaconFix, NoFixReason
from vlc_beacon.core.receiver.beacon_receiver import LampLocalizer
from vlc_beacon.core.receiver.tracked_lamp import LampObservation
from vlc_beacon.core.settings import ReceiverSettings

POSE = SE2(0.8, 1.0, 0.6)
STILL = np.zeros(3)


def seen(pose: SE2, count: int = 4, dark: tuple[int, ...] = (), bloom: float = 0.0) -> list[LampObservation]:
    """Return lamps as an image shows them, 2.5 m above the camera."""
    radius = 0.0325 * CAMERA.fx / (2.8 - MOUNT.xyz[2]) + bloom
    return [
        LampObservation(
            LampSample(i, pixel, np.full(2, math.inf if i in dark else 0.1), radius, np.ones(2), None, i),
            BEACONS[i].id,
            None,
            (),
        )
        for i, pixel in enumerate(pixels_of(BEACONS[:count], pose))
    ]


def locate(
    lamps: list[LampObservation], odometry: SE2 | None = None, **changed: object
) -> BeaconFix | NoBeaconFix:
    localizer = LampLocalizer(BEACONS, MOUNT, ReceiverSettings(**changed))  # type: ignore[arg-type]
    return localizer.locate(lamps, CAMERA, odometry, STILL, (0.0, 0.0))


@pytest.mark.parametrize(('method', 'within'), [('centroid', 1e-6), ('radius_interval', 0.01)])
def test_methods_that_are_right_find_the_pose(method: str, within: float) -> None:
    result = locate(seen(POSE), method=method)
    assert isinstance(result, BeaconFix)
    assert result.T_map_base.distance_to(POSE) < within
    assert abs(result.T_map_base.yaw_to(POSE)) < 1e-6
    assert abs(result.height) < 0.01
    assert (np.diag(result.covariance) > 0.0).all()


def test_the_printed_equations_find_another_place() -> None:
    result = locate(seen(POSE), method='radius_interval_printed')
    assert isinstance(result, BeaconFix)
    assert result.T_map_base.distance_to(POSE) > 0.1


def test_blooming_is_taken_off_the_radius() -> None:
    plain, off = (
        locate(seen(POSE, bloom=2.0), method='radius_interval', blooming=blooming) for blooming in (2.0, 0.0)
    )
    assert isinstance(plain, BeaconFix)
    assert abs(plain.height) < 0.01
    assert isinstance(off, NoBeaconFix) or abs(off.height) > 0.1


def test_dark_lamps_and_lamps_without_a_name_do_not_count() -> None:
    result = locate(seen(POSE, dark=(0, 1, 2, 3)))
    assert isinstance(result, NoBeaconFix)
    assert result.reason is NoFixReason.NO_LAMP


def test_one_lamp_carries_the_pose_on_with_odometry_only() -> None:
    localizer = LampLocalizer(BEACONS, MOUNT, ReceiverSettings())
    start, later = SE2(5.0, 5.0, 0.0), SE2(5.2, 5.0, 0.05)
    moved = POSE @ start.inverse() @ later
    assert isinstance(localizer.locate(seen(POSE), CAMERA, start, STILL, (0.0, 0.0)), BeaconFix)
    result = localizer.locate(seen(moved, 1), CAMERA, later, STILL, (0.0, 0.0))
    assert isinstance(result, BeaconFix)
    assert result.T_map_base.distance_to(moved) < 0.005
    alone = localizer.locate(seen(moved, 1), CAMERA, None, STILL, (0.0, 0.0))
    assert isinstance(alone, NoBeaconFix)
    assert alone.reason is NoFixReason.TOO_FEW_LAMPS


def test_rows_of_a_moving_robot_are_seen_from_where_it_was() -> None:
    settings = ReceiverSettings(shutter='rolling', row_time=30e-6)
    localizer = LampLocalizer(BEACONS, MOUNT, settings)
    velocity = np.array([1.0, 0.0, 0.8])
    lamps = seen(POSE)
    for _ in range(3):  # a lamp's row tells when it is seen
        rows = [lamp.sample.centre[1] for lamp in lamps]
        poses = [POSE @ SE2(30e-6 * row, 0.0, 0.8 * 30e-6 * row) for row in rows]
        lamps = [seen(pose)[i] for i, pose in enumerate(poses)]
    result = localizer.locate(lamps, CAMERA, None, velocity, (0.0, 0.0))
    assert isinstance(result, BeaconFix)
    assert result.T_map_base.distance_to(POSE) < 5e-4
    assert math.isclose(result.T_map_base.yaw, POSE.yaw, abs_tol=5e-4)
