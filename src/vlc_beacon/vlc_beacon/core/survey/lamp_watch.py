"""Collects the bearings of lamps that play their ID to a global shutter, image by image."""

from __future__ import annotations

import math
from collections import defaultdict

import numpy as np
from numpy.typing import NDArray

from shirube_geometry import PinholeCamera
from vlc_beacon.core.lamp_image.lamp_detector import LampDetector
from vlc_beacon.core.lamp_image.lamp_tracks import LampSample, LampTracks
from vlc_beacon.core.light_code.brightness_scale import BrightnessScale
from vlc_beacon.core.light_code.ufsook_decoder import UfsookDecoder
from vlc_beacon.core.packet.id_confirmation import IdConfirmation
from vlc_beacon.core.packet.id_packet import BEACON_ID_MAX, IdPacket
from vlc_beacon.core.survey.lamp_bearings import LampBearings

_ALL_IDS = frozenset(range(BEACON_ID_MAX + 1))
PIXEL_SIGMA = 0.1
"""Error of the camera's calibration, beside that of the centres [px]."""
_Sighting = tuple[float, NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], float]


def image_turn(before: NDArray[np.float64], after: NDArray[np.float64]) -> float:
    """Return by how much the image turned from u to v [rad], of two ``R_map_camera``, each of shape (3, 3)."""
    change = after.T @ before
    return math.atan2(change[1, 0], change[0, 0])


class _Follower:
    """One lamp on its way through the images."""

    def __init__(self) -> None:
        self.scale = BrightnessScale()
        self.decoder = UfsookDecoder()
        self.confirmation = IdConfirmation(_ALL_IDS)
        self.beacon: int | None = None
        self.sightings: list[_Sighting] = []


class LampWatch:
    """Follows the lamps over a drive.

    Args:
        camera: intrinsics.
        exposure: of the images [s].
    """

    def __init__(self, camera: PinholeCamera, exposure: float) -> None:
        self._camera = camera
        self._exposure = exposure
        self._detector = LampDetector()
        self._tracks = LampTracks()
        self._followers: defaultdict[int, _Follower] = defaultdict(_Follower)
        self._last_rotation: NDArray[np.float64] | None = None

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
            position: shape (3,), of the camera in the map [m].
            rotation: shape (3, 3), ``R_map_camera``.
        """
        before = rotation if self._last_rotation is None else self._last_rotation
        self._last_rotation = rotation
        turn = image_turn(before, rotation)
        for sample in self._tracks.update(stamp, image, self._detector.detect(image), turn):
            self._follow(stamp, sample, position, rotation)

    def bearings(self) -> dict[int, LampBearings]:
        """Return the bearings of each lamp whose ID was heard twice in a row, by ID."""
        by_beacon: defaultdict[int, list[_Sighting]] = defaultdict(list)
        for follower in self._followers.values():
            if follower.beacon is not None:
                by_beacon[follower.beacon] += follower.sightings
        return {beacon: self._bearings_of(sightings) for beacon, sightings in sorted(by_beacon.items())}

    def _follow(
        self,
        stamp: float,
        sample: LampSample,
        position: NDArray[np.float64],
        rotation: NDArray[np.float64],
    ) -> None:
        follower = self._followers[sample.key]
        brightness = follower.scale.scaled(sample.parts)
        for received in follower.decoder.add_frame(stamp, brightness, self._exposure):
            if isinstance(received.packet, IdPacket):
                confirmed = follower.confirmation.add(received.packet.beacon)
                follower.beacon = follower.beacon if confirmed is None else confirmed
        if sample.is_lit:
            sigma = float(np.hypot(sample.sigma.max(), PIXEL_SIGMA))
            follower.sightings.append((stamp, position, rotation, sample.centre, sigma))

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
