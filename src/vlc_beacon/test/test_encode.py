from pathlib import Path

import numpy as np
import pytest
from lamp_frame_reading import frame_from_bytes, waveform_from_frame
from lamp_on_a_line import lamp_that, usual
from light_channel import packets_in

from shirube_core.waveform import waveform_from_csv
from vlc_beacon.commands import encode, make_key
from vlc_beacon.core.packet.command_packet import Command
from vlc_beacon.core.packet.data_packet import IdPacket, split_message
from vlc_beacon.core.packet.packet_reader import Packet
from vlc_beacon.core.transmitter.lamp_frame import TICK_RATE
from vlc_beacon.files.authorization_files import read_key


@pytest.fixture
def key_file(tmp_path: Path) -> Path:
    assert make_key.main([str(tmp_path / 'key')]) == 0
    return tmp_path / 'key'


def run(*arguments: object) -> int:
    return encode.main([str(argument) for argument in arguments])


def read_by_camera(csv: Path, code: str) -> set[Packet]:
    """Return the packets that a camera reads from the light in a file."""
    light = waveform_from_csv(csv.read_text())
    channel = {} if code == 'ufsook' else {'rows': 24 if code == 'rs_fsk' else 310}
    return set(packets_in(light, code, 3.0 * light.period + 2.0, 1, **channel))


@pytest.mark.parametrize('code', ['ufsook', 'rs_fsk', 'manchester'])
def test_what_is_in_the_csv_file_is_read_from_the_light(code: str, key_file: Path, tmp_path: Path) -> None:
    """An ID, and two rules that share a counter."""
    words = ('id', 'id', 'turn:-1.5708', 'slow:0.1', '--code', code, '--key-file', key_file, '--counter', 77)
    assert run(3, *words, '--csv', tmp_path / 'lamp.csv') == 0
    short = read_by_camera(tmp_path / 'lamp.csv', code) - {IdPacket(3)}
    commands = {packet.addressed_to(3) for packet in short}
    assert {packet.command for packet in commands} == {Command(3, 5, -1.5708, 77), Command(3, 3, 0.1, 77)}
    assert all(read_key(key_file).is_authentic(packet) for packet in commands)


def test_text_and_bytes_are_read_from_the_light(tmp_path: Path) -> None:
    assert run(3, 'text:曲がる', 'hex:00ff', '--csv', tmp_path / 'lamp.csv') == 0
    sent = {*split_message('曲がる'), *split_message(b'\x00\xff')}
    assert read_by_camera(tmp_path / 'lamp.csv', 'ufsook') == sent


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
def test_the_lamp_on_the_port_gets_the_frame_of_the_file(options, last, tmp_path) -> None:
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
        ((3, 'slow:-1', '--key-file', '{key}'), 'cannot have the value -1, so robots would reject it'),
        ((3, 'text:hello', '--code', 'tone'), 'the identity of the lamp only; leave out text:hello'),
        ((3, '--code', 'manchester', '--segment-bytes', 50), 'segment_bytes'),
        ((3, '--frame-rate', 1), 'frame_rate'),
        ((3, 'text:' + 'long ' * 100, '--frame', '{tmp}/frame'), 'send fewer packets'),
        ((3, '--port', '{tmp}/none'), 'cannot be opened'),
        ((3, '--csv', '{key}/lamp.csv'), 'writable'),
    ],
)
def test_a_bad_argument_ends_in_one_line(arguments, complaint, key_file, tmp_path, capsys) -> None:
    assert run(*(str(argument).format(key=key_file, tmp=tmp_path) for argument in arguments)) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert complaint in line
