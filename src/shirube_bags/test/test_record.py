"""The command ``record``: what ``play`` plays is recorded and read back equal."""

import os
import signal
import threading

import pytest

from shirube_bags.bag_reader import BagReader
from shirube_bags.commands.record import main

pytestmark = pytest.mark.newest_set_only


def contents(path, *, stamps):
    with BagReader(path) as bag:
        messages = bag.messages()
        return sorted((each.topic, stamps and each.stamp_ns, str(bag.decode(each))) for each in messages)


@pytest.mark.parametrize(
    ('recording', 'playing', 'number'),
    [((), (), signal.SIGINT), (('--use-sim-time',), ('--lockstep',), signal.SIGTERM)],
)
def test_what_is_played_is_recorded_with_simulated_time_at_the_stamps_of_the_bag(
    start_command, bag_path, tmp_path, recording, playing, number
):
    target, topics = tmp_path / 'again', ('/image_raw', '/true_pose')
    recorder = start_command('record', '-o', target, *recording, *topics)
    player = start_command('play', bag_path, *playing, '--rate', '10', '--wait-for', *topics)
    assert player.wait(timeout=60) == 0
    assert not target.exists()
    recorder.send_signal(number)
    output = recorder.communicate(timeout=30)[1]
    assert recorder.returncode == 0, output
    is_simulated = bool(recording)
    assert contents(target, stamps=is_simulated) == contents(bag_path, stamps=is_simulated)
    assert '41 messages of /image_raw' in output


def test_a_recording_without_messages_is_not_written(domain, tmp_path, capsys):
    threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
    assert main(['-o', str(tmp_path / 'bag'), '/nothing']) == 1
    output = capsys.readouterr().err
    assert 'never published: /nothing' in output
    assert 'no message received' in output
    assert not [each for each in tmp_path.iterdir() if each.name.startswith('bag')]


def test_an_existing_bag_is_not_overwritten(domain, bag_path, capsys):
    assert main(['-o', str(bag_path)]) == 1
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert 'exists already' in line
