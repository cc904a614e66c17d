"""Manchester segments on a large lamp, from images to packets."""

from dataclasses import replace

import numpy as np
import pytest
from lamp_pictures import draw_lamp, photograph, room
from light_channel import seen_by_global_shutter, waveform_of

from vlc_beacon.core.lamp_image.lamp_tracker import LampSample
from vlc_beacon.core.lamp_image.row_profile import rows_from_frame
from vlc_beacon.core.light_code.code_profile import manchester_profile
from vlc_beacon.core.light_code.manchester import SegmentFormat
from vlc_beacon.core.light_code.manchester_decoder import ManchesterDecoder
from vlc_beacon.core.light_code.ufsook import UfsookDecoder, ufsook_waveform
from vlc_beacon.core.packet.command_packet import Command, CommandPacket, Operation
from vlc_beacon.core.packet.data_packet import DataPacket, IdPacket
from vlc_beacon.core.pose.lamp_rays import Beacon
from vlc_beacon.core.receiver.lamp_decoder import GainControl, GlobalShutterDecoder, LampView, band_rows
from vlc_beacon.core.receiver.light_receiver import LampObservation, LightReceiver
from vlc_beacon.core.settings import LampSettings, ReceiverSettings

HEIGHT, WIDTH = 560, 480
ROW_TIME, EXPOSURE, RATE = 18.9e-6, 6e-5, 30.003
COMMAND = CommandPacket(Command(5, Operation.SLOW, 0.125, 7), b'abcd')


def test_grey_values_of_any_unit_are_read_as_well() -> None:
    waveform = ufsook_waveform([IdPacket(5).to_bytes()], 1.0001)
    stamps, seen = seen_by_global_shutter(waveform, 20.0, np.random.default_rng(0))
    # The halves differ a little, and the lamp gets brighter as the robot comes nearer.
    grey = np.array([8.0, 9.0]) + np.linspace(60.0, 110.0, len(stamps))[:, None] * seen * [1.0, 1.05]
    scale = GainControl()
    normalize = np.array([scale.normalize(one) for one in grey])
    assert np.abs(normalize[200:] - seen[200:]).mean() < 0.1
    got = UfsookDecoder().add_frames(stamps, normalize, 5e-4)
    assert {packet.packet for packet in got} == {IdPacket(5)}
    assert len(got) >= 18


@pytest.mark.parametrize('level', [0.0, 90.0])
def test_a_steady_lamp_carries_no_code(level: float) -> None:
    scale, rng = GainControl(), np.random.default_rng(0)
    assert all(np.isnan(scale.normalize(level * (1.0 + rng.normal(0.0, 0.01, 2)))).all() for _ in range(200))


def test_frames_without_the_lamp_are_ignored() -> None:
    with_gaps, without = GainControl(), GainControl()
    rng = np.random.default_rng(0)
    for k in range(100):
        grey = 100.0 * rng.integers(0, 2, 2)
        if k % 3 == 0:
            assert np.isnan(with_gaps.normalize([np.nan, 3.0])).all()
        assert with_gaps.normalize(grey) == pytest.approx(without.normalize(grey), nan_ok=True)


@pytest.mark.parametrize('order', [1, -1])
def test_it_does_not_matter_which_half_is_taken_for_the_first(order: int) -> None:
    """Each packet is told once in a round, whichever way the panel hangs."""
    light, rng = ufsook_waveform([IdPacket(300).to_bytes()], 1.00003), np.random.default_rng(1)
    decoder, packets = GlobalShutterDecoder(5e-4), []
    for stamp in np.arange(0.0, 12.0, 1.0 / 60.0).tolist():
        half_brightness = light.exposure_means(stamp, 5e-4)[::order] + 0.02 * rng.normal(size=2)
        sample = LampSample(1, np.zeros(2), np.full(2, 0.1), 8.0, half_brightness, None, 0)
        view = LampView(stamp, np.zeros((16, 16), np.uint8), sample, 0.0)
        packets += [got.packet for got in decoder.read(view)]
    assert set(packets) == {IdPacket(300)}
    rounds = 12.0 / light.period
    assert 0.6 * rounds <= len(packets) <= rounds + 2


def longest_dark(waveform) -> float:
    """Return the longest time without light [s]."""
    steps = np.diff(np.append(waveform.times, waveform.period))
    runs, run = [0.0], 0.0
    for level, step in zip(np.tile(waveform.levels[:, 0], 2), np.tile(steps, 2), strict=True):
        run = run + step if level == 0.0 else 0.0
        runs.append(run)
    return max(runs)


@pytest.mark.parametrize('row_time', [9e-6, 18.9e-6])
@pytest.mark.parametrize('is_large', [False, True])
def test_no_dark_stripe_of_the_codes_is_longer_than_expected(row_time: float, is_large: bool) -> None:
    diameter = 1000.0 if is_large else 120.0
    settings = ReceiverSettings('rolling', row_time, 6e-5, lamps=LampSettings(diameter_max=diameter))
    packet = DataPacket(np.random.default_rng(1).bytes(40))
    dark = longest_dark(waveform_of('manchester' if is_large else 'rs_fsk', [packet]))
    rows = band_rows(settings, ())
    assert dark / row_time <= rows <= dark / row_time + 3.0


def test_slow_tones_and_the_setting_determine_the_band_height() -> None:
    for lamps, rows in ((LampSettings(), 51.0), (LampSettings(stripe_rows=7.0), 7.0)):
        settings = ReceiverSettings('rolling', 1e-5, lamps=lamps)
        assert band_rows(settings, [1000.0, 4000.0]) == pytest.approx(rows)


def settings(diameter_max: float) -> ReceiverSettings:
    lamps = LampSettings(diameter_max=diameter_max)
    return ReceiverSettings(shutter='rolling', row_time=ROW_TIME, exposure_time=EXPOSURE, lamps=lamps)


def read(diameter: float, seconds: float) -> tuple[LampObservation, list[CommandPacket]]:
    """Return a lamp that plays its ID and a command in segments, after a while, and the commands that were heard."""
    light, rng = (waveform_of('manchester', [IdPacket(5), IdPacket(5), COMMAND], 50.0), np.random.default_rng(1))
    lamp = draw_lamp(room(HEIGHT, WIDTH, 0.0), (238.3, 281.6), 0.5 * diameter, 190.0)
    receiver, commands = LightReceiver([Beacon(5, (0.0, 0.0, 2.5), 0.5)], settings(450.0)), []
    for stamp in np.arange(0.0, seconds, 1.0 / RATE).tolist():
        shares = light.exposure_means(stamp + np.arange(HEIGHT) * ROW_TIME, EXPOSURE)
        (found,) = receiver.receive(stamp, photograph(4.0 + shares * lamp, 1.5, rng))
        commands += found.commands
    return found, commands


def test_a_large_lamp_is_decoded_in_segments_but_none_of_fewer_rows_than_the_profile_asks_for() -> None:
    lamp, commands = read(340.0, 4.0)
    assert lamp.beacon == 5
    assert set(commands) == {COMMAND}
    assert lamp.sample.centre == pytest.approx((238.3, 281.6), abs=1.0)
    lamp, commands = read(manchester_profile(SegmentFormat(), ROW_TIME, EXPOSURE).rows_min - 20.0, 2.0)
    assert (lamp.beacon, commands) == (None, [])


def test_larger_segments_need_the_same_setting() -> None:
    segments = SegmentFormat(4)
    light, rows = (waveform_of('manchester', [COMMAND], 50.0, segments), segments.rows_min(ROW_TIME, EXPOSURE) + 20)
    commands = {}
    for size in (1, 4):
        decoder, packets = ManchesterDecoder(replace(settings(450.0), segment_bytes=size).segment_format), []
        for stamp in np.arange(0.0, 2.0, 1.0 / RATE).tolist():
            seen = light.exposure_means(stamp + np.arange(rows) * ROW_TIME, EXPOSURE)[:, 0]
            packets += decoder.add_frames(rows_from_frame(stamp, 0, seen, ROW_TIME, EXPOSURE))
        commands[size] = {received.packet for received in packets}
    assert commands == {1: set(), 4: {COMMAND}}
