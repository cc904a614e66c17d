"""What became of one image when images are located without a running node."""

from __future__ import annotations

from dataclasses import dataclass

from vlc_beacon.core.pose.pose_fix import BeaconFix
from vlc_beacon.core.receiver.beacon_receiver import Reception


@dataclass(frozen=True)
class LocatedImage:
    """One image and its result.

    Attributes:
        name: of its file, or of its topic.
        stamp_ns: when it was taken [ns]; for files their number over the rate.
        result: what it told, or the message of the error that it raised.
    """

    name: str
    stamp_ns: int
    result: Reception | str

    @property
    def fix(self) -> BeaconFix | None:
        """The pose, None where there is none."""
        if isinstance(self.result, Reception) and isinstance(self.result.result, BeaconFix):
            return self.result.result
        return None

    @property
    def failure(self) -> str:
        """Why there is no pose, empty if there is one."""
        if isinstance(self.result, str):
            return self.result
        return '' if isinstance(self.result.result, BeaconFix) else self.result.result.reason.value
