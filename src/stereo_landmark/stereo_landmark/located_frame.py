"""What became of one pair of images when pairs are located without a running node."""

from __future__ import annotations

from dataclasses import dataclass

from stereo_landmark.core.landmark_fix import LandmarkFix
from stereo_landmark.core.pair.pair_localizer import LocatedPair


@dataclass(frozen=True)
class LocatedFrame:
    """One pair and its result.

    Attributes:
        name: of the left image's file, or of its topic.
        stamp_ns: when it was taken [ns]; for files their number over the rate.
        result: what it told, or the message of the error that it raised.
    """

    name: str
    stamp_ns: int
    result: LocatedPair | str

    @property
    def fix(self) -> LandmarkFix | None:
        """The place and the displacement, None where there is none."""
        if isinstance(self.result, LocatedPair) and isinstance(self.result.answer, LandmarkFix):
            return self.result.answer
        return None

    @property
    def failure(self) -> tuple[str, str]:
        """Why there is no displacement and the numbers to it, empty if there is one."""
        if isinstance(self.result, str):
            return self.result, ''
        answer = self.result.answer
        return ('', '') if isinstance(answer, LandmarkFix) else (answer.reason, answer.detail)
