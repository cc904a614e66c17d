"""Waveforms of the mission's lamps: their IDs, and the signed commands of two of them."""

from __future__ import annotations

from scene_simulator.mission_lamps import FAST_LAMP, LAMP_RATE, LAMPS, SLOW_LAMP
from shirube_core.waveform import Waveform
from vlc_beacon.core.authorization.command_key import CommandKey
from vlc_beacon.core.transmitter.lamp_program import RS_FSK_NAME, EncodingSettings, encode_packets
from vlc_beacon.core.transmitter.message_encoder import EncoderContext, encode_messages

CRUISE_SPEED, SLOW_SPEED = 0.4, 0.22
"""Speed limits of the robot, at start and after the first command [m/s]."""

_MESSAGES = {
    SLOW_LAMP: ['id', f'slow:{SLOW_SPEED}'],
    FAST_LAMP: ['id', f'speed_up:{CRUISE_SPEED}'],
}
_COUNTER = 1


def lamp_waveforms(key: CommandKey) -> dict[int, Waveform]:
    """Return the waveform of each lamp by its ID.

    Args:
        key: key that signs the commands.
    """
    settings = EncodingSettings(code=RS_FSK_NAME, frame_rate=LAMP_RATE)
    waveforms = {}
    for name in LAMPS:
        packets = encode_messages(_MESSAGES.get(name, ['id']), EncoderContext(name, key, _COUNTER))
        waveforms[name] = encode_packets(packets, settings).waveform
    return waveforms
