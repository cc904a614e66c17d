"""Decodes packets of one lamp: symbol timing, symbols, preambles, checksum. Shared by UFSOOK and RS-FSK.

Symbols are decided shortly after their end. The symbol timing is tracked as it drifts and searched again periodically;
if another timing is much more likely, decoding restarts with the buffered frames.
"""

from __future__ import annotations

import math
from collections import deque
from itertools import product

import numpy as np
from numpy.typing import NDArray

from vlc_beacon.core.light_code.frame_buffer import FrameBuffer
from vlc_beacon.core.light_code.symbol_clock import beat_scores, symbol_likelihoods
from vlc_beacon.core.light_code.symbol_code import SymbolCode
from vlc_beacon.core.packet.id_packet import ID_BYTES
from vlc_beacon.core.packet.packet_reader import Packet, ReceivedPacket, read_packet

BEAT_SYMBOLS = 40
"""Window of the symbol timing estimate [symbols]."""
BEAT_SYMBOLS_MIN = 12
"""Minimum window of the first estimate [symbols]."""
BEAT_EVERY = 4
"""Interval between timing updates [symbols]."""
DRIFT = 0.03
"""Maximum drift of the timing between two updates, as a fraction of a symbol."""
SEARCH_EVERY = 30
"""Interval between full timing searches while no packet is decoded [symbols]."""
BETTER_BEAT = 20.0
"""Minimum log-likelihood ratio to change to another timing. A timing off by one cycle is by chance up to 15 better over
some seconds, and a change costs a packet."""
PLATEAU = 0.5
"""Timings whose log-likelihoods differ by less are equivalent."""
SILENCE_MAX = 20.0
"""Gap without frames after which the receiver is reset [symbols]."""
MARKER_MARGIN = 3.0
"""Minimum log-likelihood ratio between a preamble and data."""
SYMBOL_MARGIN = 2.0
"""Minimum log-likelihood ratio between the best symbol and the runner-up."""
UNCLEAR_MAX = 4
"""Maximum ambiguous symbols of a packet, mostly lost frames; the checksum decides, with 2^-12 false positives."""
UNCLEAR_MAX_ID = 1
"""Maximum ambiguous symbols of an ID packet, whose checksum is short."""


class SymbolReceiver:
    """Symbol receiver of one lamp.

    Args:
        code: symbol code of the lamp.
        symbols: number of different symbols, including the preamble.
        bins: number of bins of the tables.
        candidates: number of tested symbol phases.
    """

    def __init__(self, code: SymbolCode, symbols: int, bins: int, candidates: int) -> None:
        self._code = code
        self._shape = bins, symbols
        self._candidates = candidates
        self._kept = code.symbols_max + 2 * len(code.marker) + 4
        self._forget()

    def _forget(self) -> None:
        self._frames = FrameBuffer(*self._shape)
        self._begin = math.nan
        self._next_beat = self._next_search = -np.inf
        self._symbols: list[NDArray[np.float64]] = []
        self._margins: deque[list[float]] = deque(maxlen=len(self._code.marker))
        self._marker: int | None = None
        self._is_heard = False
        self._read_until = -math.inf
        self._unread: NDArray[np.float64] | None = None

    def add(self, stamps: NDArray[np.float64], tables: NDArray[np.float32]) -> list[ReceivedPacket]:
        """Add frames and return the packets that they complete.

        Args:
            stamps: stamps of the frames, shape (n,) [s]; those that do not increase are skipped.
            tables: log-likelihood tables, shape (n, bins, symbols), see `symbol_likelihoods`.
        """
        known = self._frames.stamps
        before = np.append(known[-1] if len(known) else -np.inf, stamps)
        rising = stamps > np.maximum.accumulate(before)[:-1]
        if not rising.all():
            stamps, tables = stamps[rising], tables[rising]
        silences = 1 + np.flatnonzero(np.diff(stamps) > SILENCE_MAX * self._code.duration)
        packets: list[ReceivedPacket] = []
        first = 0
        while first < len(stamps):
            end = self._piece_end(stamps, first, silences)
            packets += self._add_piece(stamps[first:end], tables[first:end])
            first = end
        return packets

    def _piece_end(self, stamps: NDArray[np.float64], first: int, silences: NDArray[np.int64]) -> int:
        """Return the end of the batch of frames up to the next timing update or gap."""
        if stamps[first] >= self._next_beat:
            return first + 1
        until_beat = int(np.searchsorted(stamps, self._next_beat))
        return min(until_beat, int(silences[silences > first].min(initial=len(stamps))))

    def _add_piece(self, stamps: NDArray[np.float64], tables: NDArray[np.float32]) -> list[ReceivedPacket]:
        known = self._frames.stamps
        if len(known) and stamps[0] - known[-1] > SILENCE_MAX * self._code.duration:
            self._forget()
        self._frames.add(stamps, tables)
        if stamps[0] >= self._next_beat:
            self._follow_beat(float(stamps[0]))
        return [] if math.isnan(self._begin) else self._read_symbols(float(stamps[-1]))

    def _follow_beat(self, stamp: float) -> None:
        """Search or track the symbol timing, and drop old frames."""
        duration = self._code.duration
        self._frames.drop_before(stamp - BEAT_SYMBOLS * duration)
        self._next_beat = stamp + BEAT_EVERY * duration
        stamps, tables = self._frames.stamps, self._frames.tables
        if stamps[-1] - stamps[0] < BEAT_SYMBOLS_MIN * duration:
            return
        is_time = math.isnan(self._begin) or stamp >= self._next_search
        if is_time:
            self._next_search = stamp + SEARCH_EVERY * duration
        # A timing that yields packets is correct.
        if is_time and not self._is_heard:
            self._search_beat(stamps, tables)
        else:
            self._correct_beat(stamps, tables)
        self._is_heard &= not is_time

    def _search_beat(self, stamps: NDArray[np.float64], tables: NDArray[np.float32]) -> None:
        """Search all symbol phases."""
        duration = self._code.duration
        old = stamps[0] if math.isnan(self._begin) else self._begin
        steps = np.arange(self._candidates)
        begins = old + steps / self._candidates * duration
        scores = beat_scores(stamps, tables, duration, begins)
        best = int(scores.argmax())
        if not math.isnan(self._begin) and scores[best] - scores[0] <= BETTER_BEAT:
            return
        # Take the middle of the plateau around the best phase.
        alike = np.roll(scores >= scores[best] - PLATEAU, self._candidates // 2 - best)
        edges = np.flatnonzero(~alike) - self._candidates // 2
        left, right = edges[edges < 0].max(initial=-1), edges[edges > 0].min(initial=1)
        self._start(float(begins[best] + 0.5 * (left + right) * duration / self._candidates))

    def _correct_beat(self, stamps: NDArray[np.float64], tables: NDArray[np.float32]) -> None:
        """Search near the current timing."""
        step = self._code.duration / self._candidates
        reach = max(1, round(DRIFT * self._candidates))
        shifts = np.arange(-reach, reach + 1) * step
        scores = beat_scores(stamps, tables, self._code.duration, self._begin + shifts)
        self._begin += float(shifts[scores >= scores.max() - PLATEAU].mean())

    def _start(self, shift: float) -> None:
        """Restart decoding with a new timing and the buffered frames."""
        duration = self._code.duration
        # The preamble that ended the last packet may start the next; earlier symbols are decoded already.
        first = max(float(self._frames.stamps[0]), self._read_until - 0.5 * duration)
        self._begin = shift + math.ceil((first - shift) / duration) * duration
        self._symbols, self._marker = [], None
        self._margins.clear()

    def _read_symbols(self, stamp: float) -> list[ReceivedPacket]:
        """Decide the symbols that are complete."""
        duration = self._code.duration
        end = self._begin + len(self._symbols) * duration
        ready = int((stamp - end) / duration - DRIFT)
        if ready < 1:
            return []
        first = int(np.searchsorted(self._frames.stamps, end))
        stamps = self._frames.stamps[first:]
        sums = symbol_likelihoods(stamps, self._frames.tables[first:], end, duration, ready)
        data = self._code.data_symbols
        margins = sums[:, self._code.marker] - sums[:, :data].max(axis=1, keepdims=True)
        packets = []
        for k in range(ready):
            self._symbols.append(sums[k])
            self._margins.append(margins[k].tolist())
            packet = self._take_marker()
            if packet is not None:
                known_at = np.searchsorted(stamps, end + (k + 1 + DRIFT) * duration)
                packets.append(ReceivedPacket(float(stamps[known_at]), packet))
                self._is_heard = True
                self._read_until = self._begin + (self._marker or 0) * duration
        self._shorten()
        return packets

    def _shorten(self) -> None:
        """Drop symbols before the last preamble, or beyond the maximum packet length."""
        drop = max(0, len(self._symbols) - self._kept)
        if self._marker is not None:
            drop = max(drop, self._marker)
            self._marker -= drop
            if self._marker < 0:
                self._marker = None
        del self._symbols[:drop]
        self._begin += drop * self._code.duration

    def _take_marker(self) -> Packet | None:
        """Return the packet that ends if the newest symbols are a preamble."""
        length = len(self._code.marker)
        margin = sum(row[place] for place, row in enumerate(self._margins))
        if len(self._margins) < length or margin < MARKER_MARGIN:
            return None
        begin, self._marker = self._marker, len(self._symbols) - length
        if begin is None:
            return None
        return self._read_packet(np.array(self._symbols[begin + length : self._marker]))

    def _read_packet(self, likelihoods: NDArray[np.float64]) -> Packet | None:
        """Return the packet of the symbols between two preambles, shape (n, symbols).

        Lamps repeat their packets: an undecodable packet is combined with the previous one.
        """
        packet = self._read_clear(likelihoods)
        before, self._unread = self._unread, None
        if packet is not None:
            return packet
        if before is not None and before.shape == likelihoods.shape:
            likelihoods = likelihoods + before
            packet = self._read_clear(likelihoods)
        if packet is None:
            self._unread = likelihoods
        return packet

    def _read_clear(self, likelihoods: NDArray[np.float64]) -> Packet | None:
        """Return the only valid packet over all choices of the ambiguous symbols, or None for none or several."""
        if len(likelihoods) == 0:
            return None
        # There is no preamble between two preambles, so only data symbols are compared.
        data = likelihoods[:, : self._code.data_symbols]
        second, best = np.argsort(data, axis=1)[:, -2:].T
        rows = np.arange(len(data))
        unclear = np.flatnonzero(data[rows, best] - data[rows, second] < SYMBOL_MARGIN)
        if len(unclear) > (
            UNCLEAR_MAX_ID if len(data) * self._code.bits < 8 * (ID_BYTES + 1) else UNCLEAR_MAX
        ):
            return None
        packets = []
        for choice in product((False, True), repeat=len(unclear)):
            symbols = best.copy()
            symbols[unclear] = np.where(choice, second[unclear], best[unclear])
            content = self._code.bytes_of(symbols)
            packet = None if content is None else read_packet(content)
            if packet is not None:
                packets.append(packet)
        return packets[0] if len(packets) == 1 else None
