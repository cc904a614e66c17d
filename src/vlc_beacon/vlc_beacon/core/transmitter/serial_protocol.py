"""Serial protocol between host and lamp firmware, specified in `firmware/led_beacon/README.md`."""

from __future__ import annotations

from dataclasses import dataclass

from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

PROTOCOL_VERSION = 1
CHUNK_BYTES = 32
"""Frame bytes per line."""
VERSION_REQUEST, STATUS_REQUEST, HALT_REQUEST, PLAY_REQUEST = 'v', 's', 'h', 'p'
OK_REPLY = 'OK'


@dataclass(frozen=True)
class LampStatus:
    """Status of the lamp.

    Attributes:
        is_playing: whether a frame is playing; otherwise the lamp is constantly on.
        source: source of the frame: `none`, `kept` or `temporary`.
        length: length of the frame [bytes].
        crc: checksum of the frame, its last two bytes.
        is_busy: whether a frame is queued until the current packet ends; no other upload is accepted until then.
    """

    is_playing: bool
    source: str
    length: int
    crc: int
    is_busy: bool


def upload_requests(frame: bytes, *, keep: bool) -> list[str]:
    """Return the requests of a frame upload; wait for the reply to each before sending the next.

    Args:
        frame: frame bytes.
        keep: whether to store the frame in the EEPROM.
    """
    starts = range(0, len(frame), CHUNK_BYTES)
    chunks = [f'd {start} {frame[start : start + CHUNK_BYTES].hex()}' for start in starts]
    return [f'b {len(frame)}', *chunks, 'k' if keep else 't']


def check_version(reply: str) -> None:
    """Check the firmware and protocol version.

    Raises:
        VlcBeaconError: wrong firmware or version.
    """
    tokens = reply.split()
    if tokens[:1] != ['led_beacon'] or tokens[1:2] != [str(PROTOCOL_VERSION)]:
        raise VlcBeaconError(
            f'the lamp replied {reply!r}, expected led_beacon {PROTOCOL_VERSION}; flash firmware/led_beacon'
        )


def read_status(reply: str) -> LampStatus:
    """Parse a status reply.

    Raises:
        VlcBeaconError: the reply is malformed.
    """
    try:
        state, source, length, crc, busy = reply.split()
        return LampStatus(state == 'playing', source, int(length), int(crc, 16), busy == '1')
    except ValueError as error:
        raise VlcBeaconError(f'the lamp replied {reply!r}, which is not a status') from error
