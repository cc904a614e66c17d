"""Classifies lamps that are not at their position in the beacons file."""

from __future__ import annotations

import cmath

import numpy as np
from numpy.typing import NDArray

from shirube_geometry import LevelCamera
from vlc_beacon.core.pose.agreement import Agreement
from vlc_beacon.core.pose.beacon import Beacon
from vlc_beacon.core.pose.lamp_rays import LampRays
from vlc_beacon.core.pose.pose_fix import BeaconDoubt, DoubtKind


def named_doubts(
    rays: LampRays, agreement: Agreement, beacons: list[Beacon], camera: LevelCamera
) -> tuple[BeaconDoubt, ...]:
    """Return the anomaly of each outlier.

    Args:
        rays: rays to the observed lamps.
        agreement: consensus set with its pose.
        beacons: all known lamps, indexed by ``consensus.swapped_place``.
        camera: gravity-aligned camera pose on the robot.
    """
    heights = {beacon.id: beacon.xyz[2] for beacon in beacons}
    doubts, copied = [], rays.copied
    for i in np.flatnonzero(~agreement.own):
        id_ = int(rays.ids[i])
        kind, other = DoubtKind.MOVED, None
        if copied[i]:
            kind = DoubtKind.COPIED
        elif agreement.swapped[i]:
            kind, other = DoubtKind.SWAPPED, beacons[agreement.place[i]].id
        seen_at = _place_at_height(rays, int(i), agreement.fit.state, heights[id_], camera)
        doubts.append(BeaconDoubt(id_, int(i), kind, other, seen_at))
    return tuple(doubts)


def unclear_doubts(rays: LampRays) -> tuple[BeaconDoubt, ...]:
    """Return an unclassified anomaly for each observation: at least one is wrong, but it is unknown which."""
    return tuple(
        BeaconDoubt(int(id_), i, DoubtKind.COPIED if copied else DoubtKind.UNCLEAR)
        for i, (id_, copied) in enumerate(zip(rays.ids, rays.copied, strict=True))
    )


def _place_at_height(
    rays: LampRays, i: int, state: NDArray[np.float64], height: float, camera: LevelCamera
) -> tuple[float, float, float]:
    """Return the intersection of a ray with a height, in the map frame [m]; the tilt error is neglected."""
    direction = camera.rotation @ np.array([*rays.rays[i], 1.0])
    reach = (height - state[2] - camera.position[2]) / direction[2]
    ahead = camera.position[:2] + reach * direction[:2]
    d_x, d_y, turn = rays.motions[i]
    ahead_of_stamp = complex(d_x, d_y) + cmath.rect(1.0, turn) * complex(*ahead)
    position = complex(state[0], state[1]) + cmath.rect(1.0, state[3]) * ahead_of_stamp
    return position.real, position.imag, float(height)
