import numpy as np
import pytest

from vlc_beacon.core.light_code.symbol_timing import FrameBuffer, symbol_log_likelihoods, timing_scores


def frames(seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return np.sort(rng.uniform(0.0, 10.0, 80)), rng.random((80, 4, 3)).astype(np.float32)


def test_each_frame_counts_for_the_symbol_it_falls_into() -> None:
    stamps, tables = frames(0)
    sums = symbol_log_likelihoods(stamps, tables, 1.0, 0.5, 10)
    for k in range(10):
        inside = np.flatnonzero((stamps >= 1.0 + 0.5 * k) & (stamps < 1.5 + 0.5 * k))
        bins = ((stamps[inside] - 1.0 - 0.5 * k) / 0.125).astype(int)
        assert sums[k] == pytest.approx(tables[inside, bins].sum(axis=0), abs=1e-5)


def test_timing_scores_are_periodic() -> None:
    stamps, tables = frames(1)
    starts = np.linspace(0.0, 0.5, 7)
    scores = timing_scores(stamps, tables, 0.5, starts)
    assert scores == pytest.approx(timing_scores(stamps, tables, 0.5, starts + 3.5), abs=1e-4)


def test_the_score_is_the_sum_of_the_best_symbols() -> None:
    stamps, tables = frames(2)
    best = symbol_log_likelihoods(stamps, tables, -0.3, 0.5, 25).max(axis=1).sum()
    assert timing_scores(stamps, tables, 0.5, np.array([0.2])) == pytest.approx([best], abs=1e-4)


def test_it_holds_what_was_added_and_not_dropped() -> None:
    rng = np.random.default_rng(0)
    buffer, stamps, tables = FrameBuffer(3, 2), np.zeros(0), np.zeros((0, 3, 2), np.float32)
    now = 0.0
    for _ in range(300):
        count = int(rng.integers(0, 90))
        new = now + np.cumsum(rng.uniform(0.01, 0.02, count))
        new_tables = rng.random((count, 3, 2)).astype(np.float32)
        buffer.add(new, new_tables)
        stamps, tables = np.append(stamps, new), np.concatenate([tables, new_tables])
        now = stamps[-1] if len(stamps) else now
        since = now - rng.uniform(0.0, 3.0)
        buffer.drop_before(since)
        kept = stamps >= since
        stamps, tables = stamps[kept], tables[kept]
        assert (buffer.stamps == stamps).all()
        assert (buffer.tables == tables).all()
