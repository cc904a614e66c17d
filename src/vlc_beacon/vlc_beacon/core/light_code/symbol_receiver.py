"""Decodes packets of one lamp: symbol timing, symbols, preambles, checksum. Shared by UFSOOK and RS-FSK.

Symbols are decided shortly after their end. The symbol timing is tracked as it drifts and searched again periodically;
if another timing is much more likely, decoding restarts with the buffered frames.
"""

import math
from collections import deque
from itertools import product

import numpy as np
from numpy.typing import NDArray

from vlc_beacon.core.light_code.symbol_code import SymbolCode
from vlc_beacon.core.light_code.symbol_timing import FrameBuffer, symbol_log_likelihoods, timing_scores
from vlc_beacon.core.packet.data_packet import ID_BYTES
from vlc_beacon.core.packet.packet_reader import Packet, ReceivedPacket, read_packet

TIMING_SYMBOLS = 40
"""Window of the symbol timing estimate [symbols]."""
TIMING_SYMBOLS_MIN = 12
"""Minimum window of the first estimate [symbols]."""
TIMING_INTERVAL = 4
"""Interval between timing updates [symbols]."""
DRIFT = 0.03
"""Maximum drift of the timing between two updates, as a fraction of a symbol."""
SEARCH_INTERVAL = 30
"""Interval between full timing searches while no packet is decoded [symbols]."""
TIMING_MARGIN = 20.0
"""Minimum log-likelihood ratio to change to another timing. A timing off by one cycle is by chance up to 15 better over
some seconds, and a change costs a packet."""
PLATEAU_TOLERANCE = 0.5
"""Timings whose log-likelihoods differ by less are equivalent."""
GAP_MAX = 20.0
"""Gap without frames after which the receiver is reset [symbols]."""
PREAMBLE_MARGIN = 3.0
"""Minimum log-likelihood ratio between a preamble and data."""
SYMBOL_MARGIN = 2.0
"""Minimum log-likelihood ratio between the best symbol and the runner-up."""
AMBIGUOUS_MAX = 4
"""Maximum ambiguous symbols of a packet, mostly lost frames; the checksum decides, with 2^-12 false positives."""
AMBIGUOUS_MAX_ID = 1
"""Maximum ambiguous symbols of an ID packet, whose checksum is short."""


class SymbolReceiver:
    """Symbol receiver of one lamp."""

    def __init__(self, code: SymbolCode, symbols: int, bins: int, candidates: int) -> None:
        self._code = code
        self._shape = bins, symbols
        self._candidates = candidates
        self._symbols_max = code.symbols_max + 2 * len(code.preamble) + 4
        self._reset()

    def _reset(self) -> None:
        self._frames = FrameBuffer(*self._shape)
        self._symbol_start = math.nan
        self._next_tracking = self._next_search = -np.inf
        self._symbols: list[NDArray[np.float64]] = []
        self._margins: deque[list[float]] = deque(maxlen=len(self._code.preamble))
        self._preamble_index: int | None = None
        self._is_synchronized = False
        self._read_until = -math.inf
        self._undecoded: NDArray[np.float64] | None = None

    def add(self, stamps: NDArray[np.float64], tables: NDArray[np.float32]) -> list[ReceivedPacket]:
        """Add frames and return the packets that they complete; stamps that do not increase are skipped."""
        known = self._frames.stamps
        previous = np.append(known[-1] if len(known) else -np.inf, stamps)
        rising = stamps > np.maximum.accumulate(previous)[:-1]
        if not rising.all():
            stamps, tables = stamps[rising], tables[rising]
        gaps = 1 + np.flatnonzero(np.diff(stamps) > GAP_MAX * self._code.duration)
        packets: list[ReceivedPacket] = []
        first = 0
        while first < len(stamps):
            end = self._batch_end(stamps, first, gaps)
            packets += self._add_batch(stamps[first:end], tables[first:end])
            first = end
        return packets

    def _batch_end(self, stamps: NDArray[np.float64], first: int, gaps: NDArray[np.int64]) -> int:
        """Return the end of the batch of frames up to the next timing update or gap."""
        if stamps[first] >= self._next_tracking:
            return first + 1
        until_tracking = int(np.searchsorted(stamps, self._next_tracking))
        return min(until_tracking, int(gaps[gaps > first].min(initial=len(stamps))))

    def _add_batch(self, stamps: NDArray[np.float64], tables: NDArray[np.float32]) -> list[ReceivedPacket]:
        known = self._frames.stamps
        if len(known) and stamps[0] - known[-1] > GAP_MAX * self._code.duration:
            self._reset()
        self._frames.add(stamps, tables)
        if stamps[0] >= self._next_tracking:
            self._update_timing(float(stamps[0]))
        return [] if math.isnan(self._symbol_start) else self._decide_symbols(float(stamps[-1]))

    def _update_timing(self, stamp: float) -> None:
        """Search or track the symbol timing, and drop old frames."""
        duration = self._code.duration
        self._frames.drop_before(stamp - TIMING_SYMBOLS * duration)
        self._next_tracking = stamp + TIMING_INTERVAL * duration
        stamps, tables = self._frames.stamps, self._frames.tables
        if stamps[-1] - stamps[0] < TIMING_SYMBOLS_MIN * duration:
            return
        is_search_due = math.isnan(self._symbol_start) or stamp >= self._next_search
        if is_search_due:
            self._next_search = stamp + SEARCH_INTERVAL * duration
        # A timing that yields packets is correct.
        if is_search_due and not self._is_synchronized:
            self._search_timing(stamps, tables)
        else:
            self._track_timing(stamps, tables)
        self._is_synchronized &= not is_search_due

    def _search_timing(self, stamps: NDArray[np.float64], tables: NDArray[np.float32]) -> None:
        """Search all symbol phases."""
        duration = self._code.duration
        old = stamps[0] if math.isnan(self._symbol_start) else self._symbol_start
        steps = np.arange(self._candidates)
        starts = old + steps / self._candidates * duration
        scores = timing_scores(stamps, tables, duration, starts)
        best = int(scores.argmax())
        if not math.isnan(self._symbol_start) and scores[best] - scores[0] <= TIMING_MARGIN:
            return
        # Take the middle of the plateau around the best phase.
        plateau = np.roll(scores >= scores[best] - PLATEAU_TOLERANCE, self._candidates // 2 - best)
        edges = np.flatnonzero(~plateau) - self._candidates // 2
        left, right = edges[edges < 0].max(initial=-1), edges[edges > 0].min(initial=1)
        self._restart(float(starts[best] + 0.5 * (left + right) * duration / self._candidates))

    def _track_timing(self, stamps: NDArray[np.float64], tables: NDArray[np.float32]) -> None:
        """Search near the current timing."""
        step = self._code.duration / self._candidates
        search_range = max(1, round(DRIFT * self._candidates))
        shifts = np.arange(-search_range, search_range + 1) * step
        scores = timing_scores(stamps, tables, self._code.duration, self._symbol_start + shifts)
        self._symbol_start += float(shifts[scores >= scores.max() - PLATEAU_TOLERANCE].mean())

    def _restart(self, shift: float) -> None:
        """Restart decoding with a new timing and the buffered frames."""
        duration = self._code.duration
        # The preamble that ended the last packet may start the next; earlier symbols are decoded already.
        first = max(float(self._frames.stamps[0]), self._read_until - 0.5 * duration)
        self._symbol_start = shift + math.ceil((first - shift) / duration) * duration
        self._symbols, self._preamble_index = [], None
        self._margins.clear()

    def _decide_symbols(self, stamp: float) -> list[ReceivedPacket]:
        """Decide the symbols that are complete."""
        duration = self._code.duration
        end = self._symbol_start + len(self._symbols) * duration
        ready = int((stamp - end) / duration - DRIFT)
        if ready < 1:
            return []
        first = int(np.searchsorted(self._frames.stamps, end))
        stamps = self._frames.stamps[first:]
        sums = symbol_log_likelihoods(stamps, self._frames.tables[first:], end, duration, ready)
        data = self._code.data_symbols
        margins = sums[:, self._code.preamble] - sums[:, :data].max(axis=1, keepdims=True)
        packets = []
        for k in range(ready):
            self._symbols.append(sums[k])
            self._margins.append(margins[k].tolist())
            packet = self._detect_preamble()
            if packet is not None:
                known_at = np.searchsorted(stamps, end + (k + 1 + DRIFT) * duration)
                packets.append(ReceivedPacket(float(stamps[known_at]), packet))
                self._is_synchronized = True
                self._read_until = self._symbol_start + (self._preamble_index or 0) * duration
        self._drop_old_symbols()
        return packets

    def _drop_old_symbols(self) -> None:
        """Drop symbols before the last preamble, or beyond the maximum packet length."""
        drop = max(0, len(self._symbols) - self._symbols_max)
        if self._preamble_index is not None:
            drop = max(drop, self._preamble_index)
            self._preamble_index -= drop
            if self._preamble_index < 0:
                self._preamble_index = None
        del self._symbols[:drop]
        self._symbol_start += drop * self._code.duration

    def _detect_preamble(self) -> Packet | None:
        """Return the packet that ends if the newest symbols are a preamble."""
        length = len(self._code.preamble)
        margin = sum(row[position] for position, row in enumerate(self._margins))
        if len(self._margins) < length or margin < PREAMBLE_MARGIN:
            return None
        begin, self._preamble_index = self._preamble_index, len(self._symbols) - length
        if begin is None:
            return None
        return self._decode_packet(np.array(self._symbols[begin + length : self._preamble_index]))

    def _decode_packet(self, likelihoods: NDArray[np.float64]) -> Packet | None:
        """Return the packet of the symbols between two preambles, shape (n, symbols).

        Lamps repeat their packets: an undecodable packet is combined with the previous one.
        """
        packet = self._decode_unambiguous(likelihoods)
        previous, self._undecoded = self._undecoded, None
        if packet is not None:
            return packet
        if previous is not None and previous.shape == likelihoods.shape:
            likelihoods = likelihoods + previous
            packet = self._decode_unambiguous(likelihoods)
        if packet is None:
            self._undecoded = likelihoods
        return packet

    def _decode_unambiguous(self, likelihoods: NDArray[np.float64]) -> Packet | None:
        """Return the only valid packet over all choices of the ambiguous symbols, or None for none or several."""
        if len(likelihoods) == 0:
            return None
        # There is no preamble between two preambles, so only data symbols are compared.
        data = likelihoods[:, : self._code.data_symbols]
        second, best = np.argsort(data, axis=1)[:, -2:].T
        rows = np.arange(len(data))
        ambiguous = np.flatnonzero(data[rows, best] - data[rows, second] < SYMBOL_MARGIN)
        is_id = len(data) * self._code.bits < 8 * (ID_BYTES + 1)
        if len(ambiguous) > (AMBIGUOUS_MAX_ID if is_id else AMBIGUOUS_MAX):
            return None
        packets = []
        for choice in product((False, True), repeat=len(ambiguous)):
            symbols = best.copy()
            symbols[ambiguous] = np.where(choice, second[ambiguous], best[ambiguous])
            content = self._code.decode_symbols(symbols)
            packet = None if content is None else read_packet(content)
            if packet is not None:
                packets.append(packet)
        return packets[0] if len(packets) == 1 else None
