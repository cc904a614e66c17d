import numpy as np
import pytest

from vlc_beacon.core.light_code.lamp_rows import LampRows
from vlc_beacon.core.light_code.manchester import PREAMBLE, Slot, SlotFormat, slot_of_bits, slots_waveform
from vlc_beacon.core.light_code.row_chips import bits_of_rows

ROW_TIME, EXPOSURE = 18.9e-6, 6e-5


def views(slot: Slot, slot_format: SlotFormat, rows: int, clock_scale: float = 1.0) -> LampRows:
    """Return views of a slot that begin everywhere in it."""
    waveform = slots_waveform([slot], slot_format, clock_scale)
    stamps = np.linspace(0.0, slot_format.chips * slot_format.chip_time, 301)
    starts = stamps[:, None] + np.arange(rows) * ROW_TIME
    seen = waveform.exposed(starts, EXPOSURE)[..., 0]
    return LampRows(stamps, np.zeros(301, int), seen, ROW_TIME, EXPOSURE)


@pytest.mark.parametrize('slot_bytes', [1, 4])
@pytest.mark.parametrize('clock_scale', [0.9999, 1.0001])
def test_a_slot_is_read_wherever_the_view_begins(slot_bytes: int, clock_scale: float) -> None:
    slot_format = SlotFormat(slot_bytes)
    slot = Slot(93, b'\x17\x80\xff\x00'[:slot_bytes])
    rows = slot_format.rows_min(ROW_TIME, EXPOSURE)
    bits, is_clear = bits_of_rows(views(slot, slot_format, rows, clock_scale), slot_format)
    assert is_clear.all()
    assert (bits == slot.chips()[len(PREAMBLE) :: 2]).all()
    assert slot_of_bits(bits[0]) == slot


def test_brightness_and_background_do_not_matter() -> None:
    slot_format, slot = SlotFormat(1), Slot(7, b'\xa5')
    seen = views(slot, slot_format, 310)
    dim = LampRows(seen.stamps, seen.first_rows, 12.0 + 3.0 * seen.brightness, ROW_TIME, EXPOSURE)
    bits, is_clear = bits_of_rows(dim, slot_format)
    assert is_clear.all()
    assert (bits == bits_of_rows(seen, slot_format)[0]).all()


def test_too_few_rows_and_even_rows_are_not_clear() -> None:
    slot_format, slot = SlotFormat(1), Slot(7, b'\xa5')
    rows = int(0.9 * slot_format.rows_min(ROW_TIME, EXPOSURE))
    assert not bits_of_rows(views(slot, slot_format, rows), slot_format)[1].any()
    even = LampRows(np.zeros(2), np.zeros(2, int), np.ones((2, 310)), ROW_TIME, EXPOSURE)
    assert not bits_of_rows(even, slot_format)[1].any()
    none = LampRows(np.zeros(0), np.zeros(0, int), np.ones((0, 310)), ROW_TIME, EXPOSURE)
    assert bits_of_rows(none, slot_format)[0].shape == (0, 19)
