"""Interface of the decoders of one tracked lamp."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from vlc_beacon.core.lamp_image.lamp_tracker import LampSample
from vlc_beacon.core.packet.packet_reader import ReceivedPacket


@dataclass(frozen=True)
class LampView:
    """A lamp in one frame.

    Attributes:
        stamp: stamp of the frame [s].
        image: grey image, shape (h, w).
        sample: the tracked lamp.
        background: brightness of the background [grey levels]; the last known value while the lamp is dark.
    """

    stamp: float
    image: NDArray[np.uint8]
    sample: LampSample
    background: float


class LampDecoder(Protocol):
    """Decodes one lamp, frame by frame."""

    def read(self, view: LampView) -> list[ReceivedPacket]:
        """Add a frame and return the packets that it completes.

        A lamp without modulation carries no code and is not processed.
        """
