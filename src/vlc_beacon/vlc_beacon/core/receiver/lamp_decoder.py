"""What every decoder of one followed lamp can do, whatever the shutter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from vlc_beacon.core.lamp_image.lamp_tracks import LampSample
from vlc_beacon.core.packet.packet_reader import ReceivedPacket


@dataclass(frozen=True)
class LampView:
    """A lamp in one frame.

    Attributes:
        stamp: of the frame [s].
        image: shape (h, w), grey.
        sample: the lamp.
        background: brightness around it [grey levels]; the last known one while it is dark.
    """

    stamp: float
    image: NDArray[np.uint8]
    sample: LampSample
    background: float


class LampDecoder(Protocol):
    """Reads one lamp, frame by frame."""

    def read(self, view: LampView) -> list[ReceivedPacket]:
        """Take a frame and return the packets that it completes.

        A lamp that does not flicker carries no code: nothing is computed for it.
        """
