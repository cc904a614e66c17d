"""Concatenated stereo pairs of several bags: a place taught in one bag can be tested on the others."""

from __future__ import annotations

from collections.abc import Sequence

from stereo_landmark.core.pair.camera_check import calibration_hash
from stereo_landmark.core.pair.stereo_images import StereoImages
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.page.pair_source import RecordedPairs


class JoinedPairs:
    """Recorded pairs of one or more bags of the same cameras.

    Args:
        first: first pairs, which keep their numbers.
        others: further pairs, each with the name of its bag.

    Raises:
        StereoLandmarkError: a bag was recorded with other cameras.
    """

    is_live = False

    def __init__(self, first: RecordedPairs, others: Sequence[tuple[str, RecordedPairs]]) -> None:
        for name, other in others:
            if calibration_hash(other.rig) != calibration_hash(first.rig):
                raise StereoLandmarkError(
                    f'{name} was recorded with other cameras; give a bag with the same calibration'
                )
        self.rig = first.rig
        self.labels = [*first.labels, *(f'{name} {label}' for name, each in others for label in each.labels)]
        self._pairs = [
            (each, number)
            for each in (first, *(other for _, other in others))
            for number in range(len(each.labels))
        ]

    def images(self, number: int) -> StereoImages:
        """Return a rectified pair.

        Raises:
            StereoLandmarkError: the number does not exist, or the pair is not rectified.
            CameraFileError: a file is not an image.
        """
        if not 0 <= number < len(self._pairs):
            raise StereoLandmarkError(f'there is no pair {number + 1}, there are {len(self._pairs)}')
        source, of_source = self._pairs[number]
        return source.images(of_source)

    def capture(self) -> int:
        """Raise an error: recorded pairs have no live camera.

        Raises:
            StereoLandmarkError: always.
        """
        return self._pairs[0][0].capture()
