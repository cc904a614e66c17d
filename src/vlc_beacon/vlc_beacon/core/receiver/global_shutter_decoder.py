"""Decodes one lamp under a global shutter: UFSOOK on the brightness of its halves."""

from __future__ import annotations

import numpy as np

from vlc_beacon.core.light_code.gain_control import GainControl
from vlc_beacon.core.light_code.ufsook_decoder import UfsookDecoder
from vlc_beacon.core.packet.packet_reader import ReceivedPacket
from vlc_beacon.core.receiver.lamp_decoder import LampView

CONFIRMATION_PACKETS = 2
"""Number of packets that determine the order of the halves."""


class GlobalShutterDecoder:
    """Decodes one lamp.

    The order of the halves is unknown, and with the halves swapped no packets are decoded: both orders are tried until
    one of them has yielded packets.

    Args:
        exposure: exposure of the frames [s].
    """

    def __init__(self, exposure: float) -> None:
        self._exposure = exposure
        self._gain = GainControl()
        self._decoders = {1: UfsookDecoder(), -1: UfsookDecoder()}
        self._packet_counts = {1: 0, -1: 0}

    def read(self, view: LampView) -> list[ReceivedPacket]:
        """Add a frame and return the packets that it completes, see `LampDecoder`."""
        brightness = self._gain.normalize(view.sample.half_brightness)
        if not np.isfinite(brightness).all():
            return []
        packets = []
        for order, decoder in list(self._decoders.items()):
            found = decoder.add_frame(view.stamp, brightness[::order], self._exposure)
            self._packet_counts[order] += len(found)
            packets += found
            if self._packet_counts[order] >= CONFIRMATION_PACKETS:
                self._decoders = {order: decoder}
        return packets
