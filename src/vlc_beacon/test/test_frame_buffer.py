import numpy as np

from vlc_beacon.core.light_code.frame_buffer import FrameBuffer


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
