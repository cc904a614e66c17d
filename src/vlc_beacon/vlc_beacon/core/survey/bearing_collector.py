"""Collects bearings to lamps that send their ID, image by image."""

import math
from collections import defaultdict

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from shirube_core.geometry import PinholeCamera
from vlc_beacon.core.pose.lamp_rays import lamp_rays
from vlc_beacon.core.receiver.light_receiver import LightReceiver
from vlc_beacon.core.receiver.tracked_lamp import LampObservation
from vlc_beacon.core.settings import ReceiverSettings
from vlc_beacon.core.survey.beacon_survey import LampBearings

PIXEL_SIGMA = 0.1
"""Standard deviation of the camera calibration, in addition to that of the centres [px]."""
_Observation = tuple[float, NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], float]
_CameraPose = tuple[float, NDArray[np.float64], NDArray[np.float64]]


def image_rotation(before: NDArray[np.float64], after: NDArray[np.float64]) -> float:
    """Return the image rotation from u to v [rad] between two ``R_map_camera``, each of shape (3, 3)."""
    change = after.T @ before
    return math.atan2(change[1, 0], change[0, 0])


class BearingCollector:
    """Tracks the lamps over a drive."""

    def __init__(self, camera: PinholeCamera, settings: ReceiverSettings) -> None:
        self._camera = camera
        self._row_time = settings.row_time if settings.is_rolling else 0.0
        # Without a beacons file all IDs are unknown IDs.
        self._light = LightReceiver([], settings)
        self._beacons: dict[int, int] = {}
        self._observations: defaultdict[int, list[_Observation]] = defaultdict(list)
        self._last: _CameraPose | None = None

    def add(
        self, stamp: float, image: NDArray[np.uint8], position: NDArray[np.float64], rotation: NDArray[np.float64]
    ) -> None:
        """Process a grey image, later than the last one, with the camera's position and rotation in the map."""
        now = stamp, position, rotation
        before, self._last = self._last or now, now
        for lamp in self._light.receive(stamp, image, image_rotation(before[2], rotation)):
            if lamp.unknown_id is not None:
                self._beacons[lamp.sample.key] = lamp.unknown_id
            if lamp.sample.is_lit:
                self._observations[lamp.sample.key].append(self._observe(lamp, before, now))

    def bearings(self) -> dict[int, LampBearings]:
        """Return the bearings of each lamp with a confirmed ID, by ID."""
        by_beacon: defaultdict[int, list[_Observation]] = defaultdict(list)
        for key, beacon in self._beacons.items():
            by_beacon[beacon] += self._observations[key]
        return {beacon: self._make_bearings(observations) for beacon, observations in sorted(by_beacon.items())}

    def _observe(self, lamp: LampObservation, before: _CameraPose, now: _CameraPose) -> _Observation:
        """Return the observation with the camera pose at the exposure of its row."""
        centre = lamp.sample.centre
        sigma = float(np.hypot(lamp.sample.sigma.max(), PIXEL_SIGMA))
        stamp, position, rotation = _extrapolate(before, now, self._row_time * float(centre[1]))
        return stamp, position, rotation, centre, sigma

    def _make_bearings(self, observations: list[_Observation]) -> LampBearings:
        observations.sort(key=lambda observation: observation[0])
        stamps, positions, rotations, centres, sigmas = zip(*observations, strict=True)
        rays = lamp_rays(self._camera, np.zeros(len(centres), dtype=np.int64), np.array(centres), np.array(sigmas))
        variances = 0.5 * np.trace(rays.covariances(0.0), axis1=1, axis2=2)
        bearings = LampBearings(
            np.array(stamps), np.array(positions), np.array(rotations), rays.rays, np.sqrt(variances)
        )
        return bearings.subset(rays.is_valid)


def _extrapolate(before: _CameraPose, now: _CameraPose, delay: float) -> _CameraPose:
    """Extrapolate the camera pose by ``delay`` [s] after ``now`` with constant velocity."""
    stamp, position, rotation = now
    step = stamp - before[0]
    if delay == 0.0 or step <= 0.0:
        return now
    fraction = delay / step
    turn = Rotation.from_matrix(before[2].T @ rotation).as_rotvec()
    rotation_step = Rotation.from_rotvec(fraction * turn).as_matrix()
    return stamp + delay, position + fraction * (position - before[1]), rotation @ rotation_step
