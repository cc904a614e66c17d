"""Result of one image located offline."""

from __future__ import annotations

from dataclasses import dataclass

from vlc_beacon.core.pose.pose_fix import BeaconFix
from vlc_beacon.core.receiver.beacon_receiver import ReceiverOutput


@dataclass(frozen=True)
class LocatedImage:
    """One image and its result.

    Attributes:
        name: name of its file or topic.
        stamp_ns: stamp [ns]; for files the index over the frame rate.
        result: receiver output, or the error message.
    """

    name: str
    stamp_ns: int
    result: ReceiverOutput | str

    @property
    def fix(self) -> BeaconFix | None:
        """The pose, None if there is none."""
        if isinstance(self.result, ReceiverOutput) and isinstance(self.result.result, BeaconFix):
            return self.result.result
        return None

    @property
    def failure(self) -> str:
        """Reason for no pose, empty if there is one."""
        if isinstance(self.result, str):
            return self.result
        return '' if isinstance(self.result.result, BeaconFix) else self.result.result.reason.value
