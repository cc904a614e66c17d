"""Decodes Manchester segments from the rows of a lamp (see `manchester`)."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vlc_beacon.core.lamp_image.row_profile import LampRows
from vlc_beacon.core.light_code.manchester import (
    INDEX_BITS,
    PREAMBLE,
    Segment,
    SegmentFormat,
    packet_from_segments,
    segment_count,
    segment_from_bits,
)
from vlc_beacon.core.packet.packet_reader import Packet, ReceivedPacket

PHASES = 10
"""Number of tested chip phases of the first row."""
CONTRAST_RATIO_MIN = 0.25
"""Minimum contrast of the weakest bit over the mean contrast; other frames are rejected."""


def demodulate_rows(rows: LampRows, segment_format: SegmentFormat) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
    """Return the bits of the segment in each frame, and a mask of frames with enough rows and clear bits.

    All chip phases are tested, wrapped around after one segment, and all chips as the start of the segment: the correct
    alignment maximizes the contrast of preamble and bits.

    Returns:
        bits, shape (n, bits), and valid frames, shape (n,).
    """
    contrasts, preamble_contrasts = _best_contrasts(
        rows.brightness,
        rows.row_time / segment_format.chip_time,
        rows.exposure / segment_format.chip_time,
        segment_format.chips,
    )
    magnitudes = np.abs(contrasts)
    weakest = np.minimum(magnitudes.min(axis=1), preamble_contrasts / 3.0)
    typical = magnitudes.mean(axis=1)
    return (contrasts > 0.0).astype(np.uint8), (typical > 0.0) & (weakest >= CONTRAST_RATIO_MIN * typical)


@njit(cache=True)
def _best_contrasts(
    brightness: NDArray[np.float64], row_chips: float, exposure_chips: float, chips: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return first minus second chip of each bit, shape (n, bits), and of the preamble halves, shape (n,).

    Zeros if the rows do not show all chips. Times are in chips.
    """
    frames, head = len(brightness), len(PREAMBLE)
    contrasts, preamble_contrasts = np.zeros((frames, (chips - head) // 2)), np.zeros(frames)
    for f in range(frames):
        best = 0.0
        for phase in range(PHASES):
            levels = _chip_levels(brightness[f], phase / PHASES, row_chips, exposure_chips, chips)
            first, score, preamble = _find_segment_start(levels)
            if score > best:
                best, preamble_contrasts[f] = score, preamble
                for i in range(contrasts.shape[1]):
                    k = first + head + 2 * i
                    contrasts[f, i] = levels[k % chips] - levels[(k + 1) % chips]
    return contrasts, preamble_contrasts


@njit(cache=True)
def _find_segment_start(levels: NDArray[np.float64]) -> tuple[int, float, float]:
    """Return the first chip of the segment, its score and preamble contrast; score 0 if chips are missing."""
    chips, head = len(levels), len(PREAMBLE)
    sums = np.zeros(2)
    for k in range(chips):
        sums[k % 2] += abs(levels[k] - levels[(k + 1) % chips])
    best, best_score, best_preamble = 0, 0.0, 0.0
    for first in range(chips if np.isfinite(sums).all() else 0):
        # The number of chips is even: the transitions within bits all have one parity, except in the preamble.
        preamble, score = 0.0, sums[first % 2]
        for i in range(head):
            preamble += levels[(first + i) % chips] * (1.0 if PREAMBLE[i] else -1.0)
            if i % 2 == 0:
                score -= abs(levels[(first + i) % chips] - levels[(first + i + 1) % chips])
        if score + preamble > best_score:
            best, best_score, best_preamble = first, score + preamble, preamble
    return best, best_score, best_preamble


@njit(cache=True)
def _chip_levels(
    brightness: NDArray[np.float64], phase: float, row_chips: float, exposure_chips: float, chips: int
) -> NDArray[np.float64]:
    """Return the mean brightness of each chip of a segment, shape (chips,), NaN if no row shows it."""
    sums, weights = np.zeros(chips), np.zeros(chips)
    for row in range(len(brightness)):
        start = phase + row * row_chips
        chip = int(start + 0.5 * exposure_chips)
        # Part of the exposure in this chip minus that in its neighbours.
        inside = min(start + exposure_chips, chip + 1.0) - max(start, float(chip))
        weight = max(2.0 * inside / exposure_chips - 1.0, 0.0)
        sums[chip % chips] += weight * brightness[row]
        weights[chip % chips] += weight
    return np.where(weights > 0.2, sums / np.maximum(weights, 1e-9), np.nan)


ROUNDS_KEPT = 2.5
"""Segments older than this number of rounds are dropped, because the lamp may send another packet."""


class ManchesterDecoder:
    """Decodes one lamp that sends segments of a format."""

    def __init__(self, segment_format: SegmentFormat) -> None:
        self._format = segment_format
        self._seen: dict[int, tuple[float, bytes]] = {}

    def add_frames(self, rows: LampRows) -> list[ReceivedPacket]:
        """Add frames and return the packets that they complete; invalid frames are skipped."""
        rows = rows.drop_invalid_frames()
        bits, is_clear = demodulate_rows(rows, self._format)
        received = []
        for frame in np.flatnonzero(is_clear):
            segment = segment_from_bits(bits[frame])
            packet = None if segment is None else self._add_segment(segment, float(rows.stamps[frame]))
            if packet is not None:
                received.append(ReceivedPacket(float(rows.stamps[frame]), packet))
        return received

    def _add_segment(self, segment: Segment, stamp: float) -> Packet | None:
        """Return the packet completed by a segment, None if incomplete."""
        is_new = self._seen.get(segment.index, (0.0, b''))[1] != segment.content
        self._seen[segment.index] = stamp, segment.content
        oldest = stamp - ROUNDS_KEPT * self._round_seconds()
        self._seen = {i: entry for i, entry in self._seen.items() if entry[0] >= oldest}
        # A repeated segment cannot complete a packet.
        contents = {i: content for i, (_, content) in self._seen.items()}
        packet = packet_from_segments(contents) if is_new else None
        if packet is not None:
            self._seen.clear()
        return packet

    def _round_seconds(self) -> float:
        count = segment_count(self._seen[0][1]) if 0 in self._seen else 1 << INDEX_BITS
        return count * self._format.segment_seconds
