"""The command ``record``: what ``play`` plays is recorded and read back equal."""

import os
import signal
import threading

import pytest

from shirube_bags.bag_reader import BagReader
from shirube_bags.commands.record import main

pytestmark = pytest.mark.newest_set_only


def contents(path):
    with BagReader(path) as bag:
        return {topic: [str(bag.decode(each)) for each in bag.messages([topic])] for topic in bag.topics}


def stamps(path):
    with BagReader(path) as bag:
        return [(each.topic, each.stamp_ns) for each in bag.messages()]


@pytest.mark.newest_set_only
def test_what_is_played_is_recorded(start_command, bag_path, tmp_path):
    target = tmp_path / 'again'
    recorder = start_command('record', '-o', target, '/image_raw', '/true_pose')
    player = start_command('play', bag_path, '--rate', '10', '--wait-for', '/image_raw', '/true_pose')
    assert player.wait(timeout=60) == 0
    assert not target.exists()
    recorder.send_signal(signal.SIGINT)
    output = recorder.communicate(timeout=30)[1]
    assert recorder.returncode == 0, output
    assert contents(target) == contents(bag_path)
    assert '41 messages of /image_raw' in output


def test_with_simulated_time_and_lock_step_the_stamps_are_those_of_the_bag(start_command, bag_path, tmp_path):
    target = tmp_path / 'again'
    recorder = start_command('record', '-o', target, '--use-sim-time', '/image_raw', '/true_pose')
    player = start_command(
        'play', bag_path, '--lockstep', '--rate', '10', '--wait-for', '/image_raw', '/true_pose'
    )
    assert player.wait(timeout=60) == 0
    recorder.send_signal(signal.SIGTERM)
    output = recorder.communicate(timeout=30)[1]
    assert recorder.returncode == 0, output
    assert stamps(target) == stamps(bag_path)


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
