"""Result of one stereo pair in offline localization."""

from __future__ import annotations

from dataclasses import dataclass

from stereo_landmark.core.landmark_fix import LandmarkFix
from stereo_landmark.core.pair.pair_localizer import LocatedPair


@dataclass(frozen=True)
class LocatedFrame:
    """A stereo pair and its result.

    Attributes:
        name: file name or topic of the left image.
        stamp_ns: stamp of the pair [ns]; for files their index divided by the rate.
        outcome: localization result, or the error message if the pair was invalid.
    """

    name: str
    stamp_ns: int
    result: LocatedPair | str

    @property
    def fix(self) -> LandmarkFix | None:
        """Place and displacement, None without a fix."""
        if isinstance(self.result, LocatedPair) and isinstance(self.result.answer, LandmarkFix):
            return self.result.answer
        return None

    @property
    def failure(self) -> tuple[str, str]:
        """Reason why there is no fix, and its details; empty strings with a fix."""
        if isinstance(self.result, str):
            return self.result, ''
        answer = self.result.answer
        return ('', '') if isinstance(answer, LandmarkFix) else (answer.reason, answer.detail)
