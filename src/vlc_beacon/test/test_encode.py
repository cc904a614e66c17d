from pathlib import Path

import numpy as np
import pytest
from lamp_frame_reading import frame_from_bytes, waveform_from_frame
from lamp_on_a_line import lamp_that, usual
from light_channel import seen_by_global_shutter, seen_by_rolling_shutter

from shirube_core.waveform import waveform_from_csv
from vlc_beacon.commands import encode, make_key
from vlc_beacon.core.light_code.manchester import SegmentFormat
from vlc_beacon.core.light_code.manchester_decoder import ManchesterDecoder
from vlc_beacon.core.light_code.rs_fsk import RsFskDecoder
from vlc_beacon.core.light_code.ufsook import UfsookDecoder
from vlc_beacon.core.packet.command_packet import Command, CommandPacket
from vlc_beacon.core.packet.data_packet import split_message
from vlc_beacon.core.packet.id_packet import IdPacket
from vlc_beacon.core.packet.packet_reader import Packet
from vlc_beacon.core.transmitter.lamp_frame import TICK_RATE
from vlc_beacon.files.key_file import read_key

TURN = Command(3, 5, -1.5708, 77)


@pytest.fixture
def key_file(tmp_path: Path) -> Path:
    assert make_key.main([str(tmp_path / 'key')]) == 0
    return tmp_path / 'key'


def run(*arguments: object) -> int:
    return encode.main([str(argument) for argument in arguments])


def read_by_camera(csv: Path, code: str) -> list[Packet]:
    """Return the packets that a camera reads from the light in a file."""
    light, rng = waveform_from_csv(csv.read_text()), np.random.default_rng(1)
    seconds = 3.0 * light.period + 2.0
    if code == 'ufsook':
        got = UfsookDecoder().add_frames(*seen_by_global_shutter(light, seconds, rng), 5e-4)
    elif code == 'rs_fsk':
        got = RsFskDecoder(30.0).add_frames(seen_by_rolling_shutter(light, seconds, rng, rows=24))
    else:
        seen = seen_by_rolling_shutter(light, seconds, rng, rows=310)
        got = ManchesterDecoder(SegmentFormat()).add_frames(seen)
    return [received.packet for received in got]


@pytest.mark.parametrize('code', ['ufsook', 'rs_fsk', 'manchester'])
def test_what_is_in_the_csv_file_is_read_from_the_light(code: str, key_file: Path, tmp_path: Path) -> None:
    csv = tmp_path / 'lamp.csv'
    words = ('id', 'id', 'turn:-1.5708')
    assert run(3, *words, '--code', code, '--csv', csv, '--key-file', key_file, '--counter', 77) == 0
    got = read_by_camera(csv, code)
    assert {packet for packet in got if isinstance(packet, IdPacket)} == {IdPacket(3)}
    commands = [packet for packet in got if isinstance(packet, CommandPacket)]
    assert {packet.command for packet in commands} == {TURN}
    assert all(read_key(key_file).is_authentic(packet) for packet in commands)


def test_text_and_bytes_are_read_from_the_light(tmp_path: Path) -> None:
    assert run(3, 'text:曲がる', 'hex:00ff', '--csv', tmp_path / 'lamp.csv') == 0
    sent = {*split_message('曲がる'), *split_message(b'\x00\xff')}
    assert set(read_by_camera(tmp_path / 'lamp.csv', 'ufsook')) == sent


@pytest.mark.parametrize('code', ['ufsook', 'rs_fsk', 'manchester', 'tone'])
def test_frame_and_csv_have_the_same_waveform(code: str, tmp_path: Path) -> None:
    csv, frame = tmp_path / 'lamp.csv', tmp_path / 'lamp.frame'
    words = ('id',) if code == 'tone' else ('id', 'text:hello')
    assert run(5, *words, '--code', code, '--csv', csv, '--frame', frame) == 0
    light = waveform_from_csv(csv.read_text())
    played = waveform_from_frame(frame_from_bytes(frame.read_bytes()))
    np.testing.assert_array_equal(played.levels, np.broadcast_to(light.levels, played.levels.shape))
    assert np.abs(played.times - light.times).max() * TICK_RATE < 1.0
    assert abs(played.period - light.period) * TICK_RATE < 1.0


@pytest.mark.parametrize(('options', 'last'), [((), 't'), (('--keep',), 'k')])
def test_the_lamp_on_the_port_gets_the_frame_of_the_file(
    options: tuple[str, ...], last: str, tmp_path: Path
) -> None:
    with lamp_that(usual) as (port, received):
        assert run(5, 'id', 'text:hello', '--frame', tmp_path / 'frame', '--port', port, *options) == 0
    chunks = [line.split()[2] for line in received if line.startswith('d ')]
    assert bytes.fromhex(''.join(chunks)) == (tmp_path / 'frame').read_bytes()
    assert received[-1] == last


def test_it_prints_lamp_size_and_durations(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert run(1, '--csv', tmp_path / 'one.csv') == 0
    out = capsys.readouterr().out
    period = waveform_from_csv((tmp_path / 'one.csv').read_text()).period
    assert 'must cover at least 6 image rows' in out
    assert f'{period:.2f} s for 1 packet\n' in out
    assert run(1, '--code', 'manchester') == 0
    assert 'must cover at least 6 image rows' not in capsys.readouterr().out


@pytest.mark.parametrize(
    ('arguments', 'complaint'),
    [
        ((3, 'turn:-1.5708'), '--key-file'),
        ((3, 'turn', '--key-file', '{key}'), 'needs a number'),
        ((3, 'stop:1', '--key-file', '{key}'), 'no value'),
        ((3, 'turn:1', 'slow:0.1', '--one-shot', '--key-file', '{key}'), 'one-shot'),
        ((3, 'dance'), "unknown message 'dance'"),
        ((3, 'hex:0g'), 'hexadecimal'),
        ((99999,), 'beacon ID is 99999'),
        ((3, 'stop', '--key-file', '{tmp}/none'), 'cannot be read'),
        ((3, 'slow:9999', '--key-file', '{key}'), 'value is 9999'),
        ((3, 'stop', '--key-file', '{key}', '--counter', -1), 'counter is -1'),
        ((3, '--code', 'manchester', '--segment-bytes', 9), 'segment_bytes'),
        ((3, 'turn:1', 'turn:-1', '--key-file', '{key}'), 'turn is given with two values'),
        (
            (3, 'slow:-1', '--key-file', '{key}'),
            'slow:-1: slow cannot have the value -1, so robots would reject it',
        ),
        (
            (3, 'text:hello', '--code', 'tone'),
            'a tone carries the identity of the lamp only; leave out text:hello',
        ),
        ((3, '--code', 'manchester', '--segment-bytes', 50), 'segment_bytes'),
        ((3, '--frame-rate', 1), 'frame_rate'),
        ((3, 'text:' + 'long ' * 100, '--frame', '{tmp}/frame'), 'send fewer packets'),
        ((3, '--port', '{tmp}/none'), 'cannot be opened'),
        ((3, '--csv', '{key}/lamp.csv'), 'writable'),
    ],
)
def test_a_bad_argument_ends_in_one_line(
    arguments: tuple[object, ...],
    complaint: str,
    key_file: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(*(str(argument).format(key=key_file, tmp=tmp_path) for argument in arguments)) == 1
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert complaint in lines[0]


def test_several_rules_of_a_lamp_share_a_counter(key_file: Path, tmp_path: Path) -> None:
    words = ('slow:0.1', 'turn:-1.5708')
    assert run(3, *words, '--csv', tmp_path / 'a.csv', '--key-file', key_file, '--counter', 77) == 0
    got = read_by_camera(tmp_path / 'a.csv', 'ufsook')
    assert {p.command for p in got if isinstance(p, CommandPacket)} == {Command(3, 3, 0.1, 77), TURN}
