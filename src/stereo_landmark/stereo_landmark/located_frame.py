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
    outcome: LocatedPair | str

    @property
    def fix(self) -> LandmarkFix | None:
        """Place and displacement, None without a fix."""
        if isinstance(self.outcome, LocatedPair) and isinstance(self.outcome.result, LandmarkFix):
            return self.outcome.result
        return None

    @property
    def failure(self) -> tuple[str, str]:
        """Reason why there is no fix, and its details; empty strings with a fix."""
        if isinstance(self.outcome, str):
            return self.outcome, ''
        result = self.outcome.result
        return ('', '') if isinstance(result, LandmarkFix) else (result.reason, result.detail)
