"""Classifies lamps that are not at their position in the beacons file."""

from __future__ import annotations

import cmath

import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry import GravityAlignedCamera
from vlc_beacon.core.pose.beacon import Beacon
from vlc_beacon.core.pose.consensus import ConsensusSet
from vlc_beacon.core.pose.lamp_rays import LampRays
from vlc_beacon.core.pose.pose_fix import AnomalyKind, BeaconAnomaly


def classify_anomalies(
    rays: LampRays, consensus: ConsensusSet, beacons: list[Beacon], camera: GravityAlignedCamera
) -> tuple[BeaconAnomaly, ...]:
    """Return the anomaly of each outlier.

    Args:
        rays: rays to the observed lamps.
        consensus: consensus set with its pose.
        beacons: all known lamps, indexed by ``consensus.swapped_place``.
        camera: gravity-aligned camera pose on the robot.
    """
    heights = {beacon.id: beacon.xyz[2] for beacon in beacons}
    anomalies, is_duplicate = [], rays.is_duplicate
    for i in np.flatnonzero(~consensus.inliers):
        id_ = int(rays.ids[i])
        kind, other = AnomalyKind.MOVED, None
        if is_duplicate[i]:
            kind = AnomalyKind.DUPLICATED
        elif consensus.swapped[i]:
            kind, other = AnomalyKind.SWAPPED, beacons[consensus.swapped_place[i]].id
        observed_xyz = _intersect_height(rays, int(i), consensus.fit.state, heights[id_], camera)
        anomalies.append(BeaconAnomaly(id_, int(i), kind, other, observed_xyz))
    return tuple(anomalies)


def unclassified_anomalies(rays: LampRays) -> tuple[BeaconAnomaly, ...]:
    """Return an unclassified anomaly for each observation: at least one is wrong, but it is unknown which."""
    return tuple(
        BeaconAnomaly(int(id_), i, AnomalyKind.DUPLICATED if is_duplicate else AnomalyKind.UNCLEAR)
        for i, (id_, is_duplicate) in enumerate(zip(rays.ids, rays.is_duplicate, strict=True))
    )


def _intersect_height(
    rays: LampRays, i: int, state: NDArray[np.float64], height: float, camera: GravityAlignedCamera
) -> tuple[float, float, float]:
    """Return the intersection of a ray with a height, in the map frame [m]; the tilt error is neglected."""
    direction = camera.rotation @ np.array([*rays.rays[i], 1.0])
    ray_length = (height - state[2] - camera.position[2]) / direction[2]
    ahead = camera.position[:2] + ray_length * direction[:2]
    d_x, d_y, turn = rays.motions[i]
    ahead_of_stamp = complex(d_x, d_y) + cmath.rect(1.0, turn) * complex(*ahead)
    position = complex(state[0], state[1]) + cmath.rect(1.0, state[3]) * ahead_of_stamp
    return position.real, position.imag, float(height)
