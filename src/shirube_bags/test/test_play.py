"""The command ``play`` with a live node: no message is lost, and it ends cleanly."""

import os
import signal
import sys

import pytest
from rclpy.qos import QoSProfile, ReliabilityPolicy, qos_profile_sensor_data

from shirube_bags.bag_reader import BagReader, jazzy_types
from shirube_bags.bag_writer import BagWriter
from shirube_bags.commands.play import main, wanted_subscribers


@pytest.fixture
def play(domain, monkeypatch):
    """Runs the command in this process."""
    monkeypatch.setenv('FASTRTPS_DEFAULT_PROFILES_FILE', os.devnull)
    return lambda *arguments: main([str(each) for each in arguments])


def images_of(path):
    with BagReader(path) as bag:
        return [bag.decode(each) for each in bag.messages(['/image_raw'])]


def one_line(text):
    (line,) = text.strip().splitlines()
    return line


def test_every_message_arrives_at_real_time_in_order_and_equal(stamp_of, listen, start_command, bag_path):
    best_effort = listen('best_effort', qos_profile_sensor_data)
    reliable = listen('reliable', QoSProfile(depth=10))
    process = start_command('play', bag_path)
    best_effort.spin_while_running(process)
    _, output = process.communicate()
    assert process.returncode == 0, output
    wanted = images_of(bag_path)
    for listener in (best_effort, reliable):
        assert listener.stamps() == [stamp_of(each) for each in wanted]
        assert all(bytes(left.data) == right.data.tobytes() for left, right in zip(listener.images, wanted))
        assert listener.ticks == sorted(set(listener.ticks))
    assert 'no subscriber for /true_pose' in output
    assert '81 messages' in output


@pytest.mark.newest_set_only
def test_lock_step_waits_for_a_slow_node_in_another_process(listen, start_command, bag_path):
    qos = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    listener = listen('listener', qos, work=0.01)
    process = start_command('play', bag_path, '--rate', '0', '--wait-for', '/image_raw/1')
    listener.spin_while_running(process)
    assert process.returncode == 0, process.communicate()[1]
    assert len(listener.images) == 41
    assert listener.clock == listener.stamps()


@pytest.mark.newest_set_only
def test_large_images_arrive_without_a_loss(listen, start_command, tmp_path, messages):
    with BagWriter(tmp_path / 'bag') as bag:
        for index in range(1, 21):
            image = messages.image(index, side=1100)
            bag.write('/image_raw', 'sensor_msgs/msg/Image', image, index * 33_000_000)
    listener = listen('listener', qos_profile_sensor_data)
    process = start_command('play', tmp_path / 'bag')
    listener.spin_while_running(process)
    assert process.returncode == 0, process.communicate()[1]
    assert listener.stamps() == list(range(1, 21))


@pytest.mark.newest_set_only
def test_a_loop_plays_again_and_the_clock_jumps_back(listen, start_command, bag_path):
    listener = listen('listener', qos_profile_sensor_data)
    process = start_command('play', bag_path, '--rate', '0', '--loop', '2', '--topics', '/image_raw')
    listener.spin_while_running(process)
    assert process.returncode == 0, process.communicate()[1]
    stamps = listener.stamps()
    assert len(stamps) == 82
    assert stamps[:41] == stamps[41:] == sorted(stamps[:41])


@pytest.mark.newest_set_only
def test_ctrl_c_ends_the_replay_with_exit_code_0(listen, start_command, bag_path):
    listener = listen('listener', qos_profile_sensor_data)
    process = start_command('play', bag_path, '--rate', '0.1')
    while len(listener.images) < 3:
        listener.executor.spin_once(timeout_sec=0.05)
    process.send_signal(signal.SIGINT)
    listener.spin_while_running(process)
    output = process.communicate()[1]
    assert process.returncode == 0, output
    assert 'Traceback' not in output
    assert len(listener.images) < 41


def test_the_absence_of_subscribers_is_said(play, bag_path, capsys):
    assert play(bag_path, '--rate', '0', '--timeout', '0.1') == 0
    assert 'no subscriber within 0.1 s' in capsys.readouterr().err


@pytest.mark.parametrize(('wanted', 'words'), [('/image_raw/2', '/image_raw has 0 of 2'), ('/imu', '--wait-for /imu')])
def test_missing_subscribers_end_the_program_in_one_line(play, bag_path, capsys, wanted, words):
    assert play(bag_path, '--timeout', '0.1', '--wait-for', wanted) == 1
    assert words in one_line(capsys.readouterr().err)


def test_a_damaged_bag_ends_the_program_in_one_line(play, bag_path, capsys):
    data = (bag_path / 'drive.mcap').read_bytes()
    (bag_path / 'drive.mcap').write_bytes(data[:-100])
    assert play(bag_path) == 1
    assert str(bag_path) in one_line(capsys.readouterr().err)


def test_topics_of_types_that_are_not_installed_are_left_out(play, tmp_path, messages, monkeypatch, capsys):
    with BagWriter(tmp_path / 'bag') as bag:
        bag.write('/text', 'std_msgs/msg/String', messages.text('x'), 1)
        bag.write('/map', 'tf2_msgs/msg/TFMessage', jazzy_types().types['tf2_msgs/msg/TFMessage']([]), 2)
    monkeypatch.setitem(sys.modules, 'tf2_msgs', None)
    assert play(tmp_path / 'bag', '--timeout', '0.1') == 0
    assert 'topic /map is skipped: the message type tf2_msgs/msg/TFMessage' in capsys.readouterr().err
    assert play(tmp_path / 'bag', '--topics', '/map') == 1
    assert 'install its package tf2_msgs' in one_line(capsys.readouterr().err)


def test_an_offset_beyond_the_end_is_refused(play, bag_path, capsys):
    assert play(bag_path, '--start-offset', '3') == 1
    assert '--start-offset 3: the bag ends after 0.8 s' in one_line(capsys.readouterr().err)


@pytest.mark.parametrize(
    'arguments',
    [('--start-offset', '-1'), ('--rate', '-1'), ('--rate', 'nan'), ('--loop', '0'), ('--timeout', '-1'), ()],
)
def test_bad_options_are_refused(play, arguments, bag_path, capsys):
    with pytest.raises(SystemExit, match='2'):
        play(*([bag_path, *arguments] if arguments else []))
    assert 'usage' in capsys.readouterr().err


@pytest.mark.parametrize(
    ('text', 'wanted'), [('/a/b', ('/a/b', 1)), ('/a/b/3', ('/a/b', 3)), ('/7', ('/7', 1)), ('/a/b2', ('/a/b2', 1))]
)
def test_the_number_of_subscribers_follows_the_topic(text, wanted):
    assert wanted_subscribers(text) == wanted
