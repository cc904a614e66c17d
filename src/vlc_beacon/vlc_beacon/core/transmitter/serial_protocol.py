"""Lines that the host and the lamp firmware exchange; `firmware/led_beacon/README.md` lists them."""

from __future__ import annotations

from dataclasses import dataclass

from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

PROTOCOL_VERSION = 1
PIECE_BYTES = 32
"""Bytes of a frame in a line."""
VERSION_REQUEST, STATUS_REQUEST, STEADY_REQUEST, PLAY_REQUEST = 'v', 's', 'h', 'p'
DONE = 'OK'


@dataclass(frozen=True)
class LampStatus:
    """What the lamp does.

    Attributes:
        is_playing: or shines steadily.
        source: of its frame: `none`, `kept` or `temporary`.
        length: of its frame.
        crc: of its frame, its last two bytes.
        is_busy: another frame waits until the packet that is playing is over; no other is taken until then.
    """

    is_playing: bool
    source: str
    length: int
    crc: int
    is_busy: bool


def upload_requests(frame: bytes, *, keep: bool) -> list[str]:
    """Return the lines that send a frame, each to be answered before the next.

    Args:
        frame: its bytes.
        keep: over power off; or only for now.
    """
    starts = range(0, len(frame), PIECE_BYTES)
    pieces = [f'd {start} {frame[start : start + PIECE_BYTES].hex()}' for start in starts]
    return [f'b {len(frame)}', *pieces, 'k' if keep else 't']


def check_version(reply: str) -> None:
    """Check that the lamp speaks this protocol.

    Raises:
        VlcBeaconError: it does not.
    """
    words = reply.split()
    if words[:1] != ['led_beacon'] or words[1:2] != [str(PROTOCOL_VERSION)]:
        raise VlcBeaconError(
            f'the lamp answers {reply!r} and not led_beacon {PROTOCOL_VERSION}: flash firmware/led_beacon'
        )


def read_status(reply: str) -> LampStatus:
    """Return the status that the lamp tells.

    Raises:
        VlcBeaconError: it is none.
    """
    try:
        state, source, length, crc, busy = reply.split()
        return LampStatus(state == 'playing', source, int(length), int(crc, 16), busy == '1')
    except ValueError as error:
        raise VlcBeaconError(f'the lamp answers {reply!r}, which is no status') from error
