"""Reads one lamp with a global shutter: UFSOOK on the brightness of its halves."""

from __future__ import annotations

import numpy as np

from vlc_beacon.core.light_code.brightness_scale import BrightnessScale
from vlc_beacon.core.light_code.ufsook_decoder import UfsookDecoder
from vlc_beacon.core.packet.packet_reader import ReceivedPacket
from vlc_beacon.core.receiver.lamp_decoder import LampView

SURE_AFTER = 2
"""So many packets tell which half of the lamp is the first."""


class GlobalShutterDecoder:
    """Decodes one lamp.

    The image does not tell which half of a panel is the first, and with the halves swapped there are no packets: both
    ways are tried until one of them has brought packets.

    Args:
        exposure: of the frames [s].
    """

    def __init__(self, exposure: float) -> None:
        self._exposure = exposure
        self._scale = BrightnessScale()
        self._decoders = {1: UfsookDecoder(), -1: UfsookDecoder()}
        self._heard = {1: 0, -1: 0}

    def read(self, view: LampView) -> list[ReceivedPacket]:
        """Take a frame and return the packets that it completes, see `LampDecoder`."""
        brightness = self._scale.scaled(view.sample.parts)
        if not np.isfinite(brightness).all():
            return []
        packets = []
        for order, decoder in list(self._decoders.items()):
            found = decoder.add_frame(view.stamp, brightness[::order], self._exposure)
            self._heard[order] += len(found)
            packets += found
            if self._heard[order] >= SURE_AFTER:
                self._decoders = {order: decoder}
        return packets
