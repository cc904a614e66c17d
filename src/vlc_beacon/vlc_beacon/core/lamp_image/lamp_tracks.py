"""Which lamp of this frame is which of the last, and what each of them plays, also while it is dark."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vlc_beacon.core.lamp_image.lamp_blobs import LampBlobs
from vlc_beacon.core.lamp_image.lamp_track import LampTrack

COAST = 0.6
"""A lamp that was dark for longer is gone [s]. Equal symbols may look dark, and some ID has 16 of them in a row."""


@dataclass(frozen=True)
class LampSample:
    """A lamp in one frame.

    Attributes:
        key: of its track.
        centre: shape (2,), of the whole lamp [px], expected where it is dark.
        sigma: shape (2,), along u and v [px], infinite where it is dark.
        radius: [px].
        parts: shape (2,), brightness of its halves over the full one.
        split_axis: shape (2,), direction from the second half to the first in the image, None for a lamp of one part.
            The image does not tell which half is the first: it may be the other one.
        blob: index of the lamp among the frame's blobs, -1 where it is dark.
    """

    key: int
    centre: NDArray[np.float64]
    sigma: NDArray[np.float64]
    radius: float
    parts: NDArray[np.float64]
    split_axis: NDArray[np.float64] | None
    blob: int

    @property
    def is_lit(self) -> bool:
        """Whether the frame tells where the lamp is."""
        return bool(np.isfinite(self.sigma).all())


class LampTracks:
    """Follows all lamps in view."""

    def __init__(self, *, split_lamps: bool = True) -> None:
        """Begin without lamps.

        Args:
            split_lamps: whether halves of lamps may go dark one by one, as a global shutter sees split panels.
        """
        self._split_lamps = split_lamps
        self._tracks: list[LampTrack] = []
        self._keys = itertools.count(1)

    def update(
        self, stamp: float, image: NDArray[np.uint8], blobs: LampBlobs, turn: float = 0.0
    ) -> list[LampSample]:
        """Take the lamps of a frame and return a sample of each lamp that is followed.

        Args:
            stamp: of the frame, later than the last one [s].
            image: shape (h, w), grey.
            blobs: its lamps.
            turn: of the image since the last frame, from u to v, where odometry tells it [rad].
        """
        height, width = image.shape
        self._tracks = [
            track
            for track in self._tracks
            if stamp - track.last_seen <= COAST and _is_inside(track.expect(stamp)[0], width, height)
        ]
        owners = self._associate(stamp, blobs)
        samples = []
        for track in self._tracks:
            track.turn(turn)
            i = owners.get(track.key, -1)
            parts = track.see(stamp, image, blobs, i) if i >= 0 else track.miss(stamp, image)
            samples.append(_sample(track, parts, i))
        for i in sorted(set(range(len(blobs))) - set(owners.values())):
            track = LampTrack(next(self._keys), stamp, blobs, i, may_be_split=self._split_lamps)
            self._tracks.append(track)
            samples.append(_sample(track, track.see(stamp, image, blobs, i), i))
        return samples

    def _associate(self, stamp: float, blobs: LampBlobs) -> dict[int, int]:
        """Return the blob of each track that has one, the nearest pairs first."""
        if not self._tracks or len(blobs) == 0:
            return {}
        expected = [track.expect(stamp) for track in self._tracks]
        places, gates = np.array([place for place, _ in expected]), np.array([gate for _, gate in expected])
        distances = np.hypot(*(places[:, None] - blobs.centroids[None]).transpose(2, 0, 1))
        distances[distances > gates[:, None]] = np.inf
        owners: dict[int, int] = {}
        while np.isfinite(distances).any():
            row, column = np.unravel_index(int(np.argmin(distances)), distances.shape)
            owners[self._tracks[row].key] = int(column)
            distances[row], distances[:, column] = np.inf, np.inf
        return owners


def _is_inside(place: NDArray[np.float64], width: int, height: int) -> bool:
    return bool(0.0 <= place[0] < width and 0.0 <= place[1] < height)


def _sample(track: LampTrack, parts: NDArray[np.float64], blob: int) -> LampSample:
    return LampSample(track.key, track.place, track.sigma, track.radius, parts, track.split_axis, blob)
