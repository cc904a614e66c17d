import pytest
from light_channel import received, waveform_of

from vlc_beacon.core.light_code.code_profile import CodeProfile, manchester_profile, rs_fsk_profile, ufsook_profile
from vlc_beacon.core.light_code.manchester import SegmentFormat
from vlc_beacon.core.packet.command_packet import Command, ShortCommandPacket
from vlc_beacon.core.packet.data_packet import DataPacket, IdPacket

PACKETS = (IdPacket(5), ShortCommandPacket(Command(0, 5, 0.0, 9), b'abcd'), DataPacket(bytes(range(100))))


def stated(profile: CodeProfile) -> list[float]:
    return [profile.id_seconds, profile.command_seconds, profile.seconds_per_100_bytes]


def played(code: str, **options: object) -> list[float]:
    return pytest.approx([waveform_of(code, [packet], **options).period for packet in PACKETS])


def test_what_is_stated_is_how_long_it_plays() -> None:
    assert stated(ufsook_profile()) == played('ufsook')
    for rate in (30.0, 60.0):
        assert stated(rs_fsk_profile(rate, 18.9e-6)) == played('rs_fsk', rate=rate)
    for segments in (SegmentFormat(1), SegmentFormat(4, frame_rate=60.0)):
        assert stated(manchester_profile(segments, 18.9e-6, 6e-5)) == played('manchester', segments=segments)


def test_durations_and_rows_are_those_that_are_promised() -> None:
    assert ufsook_profile().id_seconds <= 0.9
    assert ufsook_profile().command_seconds <= 3.6
    # The paper's small lamp carries tones only.
    assert rs_fsk_profile(30.0, 18.9e-6).rows_min == 16
    assert 295 <= manchester_profile(SegmentFormat(1), 18.9e-6, 6e-5).rows_min <= 305


@pytest.mark.parametrize('row_time', [9e-6, 18.9e-6])
def test_rs_fsk_does_with_the_rows_that_are_stated(row_time: float) -> None:
    rows_min = rs_fsk_profile(30.0, row_time).rows_min
    got = received('rs_fsk', PACKETS[:1], 30.0, 0, 100.0, rows=rows_min, row_time=row_time)
    assert len(got) >= 0.9 * 30.0 / 0.6 - 1
