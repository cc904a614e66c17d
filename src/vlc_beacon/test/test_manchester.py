import numpy as np
import pytest
from flicker import worst_flicker

from vlc_beacon.core.light_code.manchester import PREAMBLE, Slot, SlotFormat, slot_of_bits, slots_waveform
from vlc_beacon.core.light_code.reed_solomon_block import slots_of_packet
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError


def bits_of(slot: Slot) -> np.ndarray:
    return slot.chips()[len(PREAMBLE) :: 2]


def test_every_slot_comes_back() -> None:
    for seed in range(500):
        rng = np.random.default_rng(seed)
        slot = Slot(int(rng.integers(128)), rng.bytes(int(rng.integers(1, 33))))
        assert slot_of_bits(bits_of(slot)) == slot


def test_the_check_is_that_of_the_catalogue() -> None:
    # CRC-4/INTERLAKEN has the same polynomial; it begins and ends with ones, and its check value is 0xB.
    slot = Slot(0, b'123456789')
    ones_first = Slot(0, bytes([slot.content[0] ^ 0xF0]) + slot.content[1:])
    check = int(''.join(map(str, bits_of(ones_first)[-4:])), 2)
    assert check ^ 0xF == 0xB


def test_one_and_two_wrong_bits_of_a_short_slot_are_noticed() -> None:
    # The polynomial is primitive: two bits less than 15 apart never cancel.
    bits = bits_of(Slot(5, b'\x3c'))
    for i in range(len(bits)):
        for j in range(i, min(i + 15, len(bits))):
            damaged = bits.copy()
            damaged[list({i, j})] ^= 1
            assert slot_of_bits(damaged) is None


def test_three_equal_chips_are_in_the_preamble_only() -> None:
    for seed in range(300):
        rng = np.random.default_rng(seed)
        chips = Slot(int(rng.integers(128)), rng.bytes(4)).chips()
        around = np.append(chips, chips[:2])
        triples = around[:-2] + around[1:-1] + around[2:]
        # A bit beside the preamble may lengthen its dark or its light, whose beginning stays where it is.
        found = set(np.flatnonzero((triples == 0) | (triples == 3)).tolist())
        assert {0, 3} <= found <= {0, 3, 4, len(chips) - 1}


def test_a_camera_of_the_frame_rate_sees_each_slot_whole() -> None:
    for slot_bytes in (1, 4, 8):
        for frame_rate in (15.0, 30.0, 60.0):
            slot_format = SlotFormat(slot_bytes, frame_rate=frame_rate)
            view = (slot_format.chips + 2) * slot_format.chip_time
            assert slot_format.slot_seconds >= 1.0 / frame_rate + view - 1e-12


@pytest.mark.parametrize(
    'slot_format', [SlotFormat(1), SlotFormat(8), SlotFormat(1, 1 / 6000), SlotFormat(5, 1 / 6000)]
)
@pytest.mark.parametrize('content', [bytes(6), b'\xff' * 6, b'\x55' * 6, b'\x0f\x00' * 3])
def test_nothing_blinks_visibly(content: bytes, slot_format: SlotFormat) -> None:
    waveform = slots_waveform(slots_of_packet(content, slot_format.slot_bytes), slot_format)
    assert worst_flicker(waveform, highest=30.0) < 1.0
    assert slot_format.chip_time > 1.0 / 8000.0 or worst_flicker(waveform) < 1.0
    assert waveform.exposed(0.0, waveform.period) == pytest.approx([0.5])
    assert np.diff(np.append(waveform.times, waveform.period)).max() <= 4.0 * slot_format.chip_time + 1e-12


@pytest.mark.parametrize('slot_bytes', [0, 9])
def test_slots_that_would_blink_visibly_are_refused(slot_bytes: int) -> None:
    with pytest.raises(
        VlcBeaconError, match=f'slot_bytes is {slot_bytes}, it must be from 1 to 8, or the lamp'
    ):
        SlotFormat(slot_bytes)
    assert SlotFormat(8).chips * SlotFormat(8).chip_time < 0.02


@pytest.mark.parametrize('chip_time', [float('nan'), 0.0, 1.0 / 2000.0])
def test_chips_of_impossible_length_are_refused(chip_time: float) -> None:
    with pytest.raises(VlcBeaconError, match=r'chip_time is .* s, it must be from 0.000125 to 0.000166667 s'):
        SlotFormat(1, chip_time)
