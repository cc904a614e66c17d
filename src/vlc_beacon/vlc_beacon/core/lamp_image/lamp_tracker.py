"""Multi-lamp tracking: associates detections with tracks and samples the brightness, also of dark lamps."""

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vlc_beacon.core.lamp_image.blob_measurement import LampBlobs
from vlc_beacon.core.lamp_image.lamp_track import LampTrack

COAST_TIME = 0.6
"""A track without a detection for longer is deleted [s]. Equal symbols may look dark, up to 16 in a row."""


@dataclass(frozen=True)
class LampSample:
    """A tracked lamp in one frame.

    Attributes:
        key: track ID.
        centre: centre of the lamp, shape (2,) [px], predicted if it is dark.
        sigma: standard deviation along u and v, shape (2,) [px], infinite if the lamp is dark.
        radius: lamp radius [px].
        half_brightness: brightness of the halves relative to full light, shape (2,).
        split_axis: image direction from the second half to the first, shape (2,), None for a lamp of one part. The
            order of the halves is ambiguous.
        blob: index of the lamp among the frame's blobs, -1 if it is dark.
    """

    key: int
    centre: NDArray[np.float64]
    sigma: NDArray[np.float64]
    radius: float
    half_brightness: NDArray[np.float64]
    split_axis: NDArray[np.float64] | None
    blob: int

    @property
    def is_lit(self) -> bool:
        """Whether the frame has a position measurement of the lamp."""
        return bool(np.isfinite(self.sigma).all())


class LampTracker:
    """Tracks all lamps in view."""

    def __init__(self, *, split_lamps: bool = True) -> None:
        """Start without tracks; ``split_lamps`` if lamp halves may be switched independently (split panels)."""
        self._split_lamps = split_lamps
        self._tracks: list[LampTrack] = []
        self._keys = itertools.count(1)

    def update(
        self, stamp: float, image: NDArray[np.uint8], blobs: LampBlobs, image_rotation: float = 0.0
    ) -> list[LampSample]:
        """Update the tracks with a frame and return a sample of each tracked lamp.

        Args:
            stamp: stamp of the frame, later than the last one [s].
            image: grey image, shape (h, w).
            blobs: detections of the image.
            image_rotation: image rotation since the last frame, from u to v, if known from odometry [rad].
        """
        self._tracks = [
            track
            for track in self._tracks
            if stamp - track.last_seen <= COAST_TIME and _is_inside(track.predict(stamp)[0], image.shape)
        ]
        assignments = self._associate(stamp, blobs)
        samples = []
        for track in self._tracks:
            track.rotate(image_rotation)
            i = assignments.get(track.key, -1)
            half_brightness = track.update(stamp, image, blobs, i) if i >= 0 else track.miss(stamp, image)
            samples.append(_sample(track, half_brightness, i))
        for i in sorted(set(range(len(blobs))) - set(assignments.values())):
            track = LampTrack(next(self._keys), stamp, blobs, i, may_be_split=self._split_lamps)
            self._tracks.append(track)
            samples.append(_sample(track, track.update(stamp, image, blobs, i), i))
        return samples

    def _associate(self, stamp: float, blobs: LampBlobs) -> dict[int, int]:
        """Assign blobs to tracks by greedy nearest neighbour; return blob indices by track key."""
        if not self._tracks or len(blobs) == 0:
            return {}
        predicted, gates = zip(*(track.predict(stamp) for track in self._tracks), strict=True)
        offsets = np.array(predicted)[:, None] - blobs.centroids[None]
        distances = np.hypot(*offsets.transpose(2, 0, 1))
        distances[distances > np.array(gates)[:, None]] = np.inf
        assignments: dict[int, int] = {}
        while np.isfinite(distances).any():
            row, column = np.unravel_index(int(np.argmin(distances)), distances.shape)
            assignments[self._tracks[row].key] = int(column)
            distances[row], distances[:, column] = np.inf, np.inf
        return assignments


def _is_inside(centre: NDArray[np.float64], shape: tuple[int, ...]) -> bool:
    return bool(0.0 <= centre[0] < shape[1] and 0.0 <= centre[1] < shape[0])


def _sample(track: LampTrack, half_brightness: NDArray[np.float64], blob: int) -> LampSample:
    return LampSample(track.key, track.centre, track.sigma, track.radius, half_brightness, track.split_axis, blob)
