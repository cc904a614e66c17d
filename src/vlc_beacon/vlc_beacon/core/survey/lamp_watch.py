"""Collects the bearings of lamps that play their ID, image by image."""

from __future__ import annotations

import math
from collections import defaultdict

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from shirube_geometry import PinholeCamera
from vlc_beacon.core.receiver.light_receiver import LightReceiver, ReadLamp
from vlc_beacon.core.receiver.settings import ReceiverSettings
from vlc_beacon.core.survey.lamp_bearings import LampBearings

PIXEL_SIGMA = 0.1
"""Error of the camera's calibration, beside that of the centres [px]."""
_Sighting = tuple[float, NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], float]
_CameraPose = tuple[float, NDArray[np.float64], NDArray[np.float64]]


def image_turn(before: NDArray[np.float64], after: NDArray[np.float64]) -> float:
    """Return by how much the image turned from u to v [rad], of two ``R_map_camera``, each of shape (3, 3)."""
    change = after.T @ before
    return math.atan2(change[1, 0], change[0, 0])


class LampWatch:
    """Follows the lamps over a drive.

    Args:
        camera: intrinsics.
        settings: of shutter and lamps.
    """

    def __init__(self, camera: PinholeCamera, settings: ReceiverSettings) -> None:
        self._camera = camera
        self._row_time = settings.row_time if settings.is_rolling else 0.0
        # Without a beacons file all lamps are strangers, and are told by that.
        self._light = LightReceiver([], settings)
        self._beacons: dict[int, int] = {}
        self._sightings: defaultdict[int, list[_Sighting]] = defaultdict(list)
        self._last: _CameraPose | None = None

    def add(
        self,
        stamp: float,
        image: NDArray[np.uint8],
        position: NDArray[np.float64],
        rotation: NDArray[np.float64],
    ) -> None:
        """Take an image.

        Args:
            stamp: later than the last one [s].
            image: shape (h, w), grey.
            position: shape (3,), of the camera in the map at the stamp [m].
            rotation: shape (3, 3), ``R_map_camera`` then.
        """
        now = stamp, position, rotation
        before, self._last = self._last or now, now
        for lamp in self._light.receive(stamp, image, image_turn(before[2], rotation)):
            if lamp.stranger is not None:
                self._beacons[lamp.sample.key] = lamp.stranger
            if lamp.sample.is_lit:
                self._sightings[lamp.sample.key].append(self._sighting(lamp, before, now))

    def bearings(self) -> dict[int, LampBearings]:
        """Return the bearings of each lamp whose ID was heard twice in a row, by ID."""
        by_beacon: defaultdict[int, list[_Sighting]] = defaultdict(list)
        for key, beacon in self._beacons.items():
            by_beacon[beacon] += self._sightings[key]
        return {beacon: self._bearings_of(sightings) for beacon, sightings in sorted(by_beacon.items())}

    def _sighting(self, lamp: ReadLamp, before: _CameraPose, now: _CameraPose) -> _Sighting:
        """Return where the lamp was seen and from where; rows of a rolling shutter are seen a little later."""
        centre = lamp.sample.centre
        sigma = float(np.hypot(lamp.sample.sigma.max(), PIXEL_SIGMA))
        stamp, position, rotation = _moved_on(before, now, self._row_time * float(centre[1]))
        return stamp, position, rotation, centre, sigma

    def _bearings_of(self, sightings: list[_Sighting]) -> LampBearings:
        stamps, positions, rotations, centres, sigmas = zip(
            *sorted(sightings, key=lambda sighting: sighting[0]), strict=True
        )
        return LampBearings(
            np.array(stamps),
            np.array(positions),
            np.array(rotations),
            self._camera.rays_from_pixels(np.array(centres))[:, :2],
            np.array(sigmas) / self._camera.fx,
        )


def _moved_on(before: _CameraPose, now: _CameraPose, delay: float) -> _CameraPose:
    """Return the camera's pose a little after ``now`` [s], which goes on as it did."""
    stamp, position, rotation = now
    step = stamp - before[0]
    if delay == 0.0 or step <= 0.0:
        return now
    share = delay / step
    turn = Rotation.from_matrix(before[2].T @ rotation).as_rotvec()
    onward = Rotation.from_rotvec(share * turn).as_matrix()
    return stamp + delay, position + share * (position - before[1]), rotation @ onward
