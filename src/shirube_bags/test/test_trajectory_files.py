"""Trajectories of bags and TUM files."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from shirube_bags.bag_reader import BagReader, jazzy_types
from shirube_bags.bag_writer import BagWriter
from shirube_bags.errors import BagError, TumFileError
from shirube_bags.trajectory import make_trajectory, planar_trajectory
from shirube_bags.trajectory_files import load_bag_trajectory, load_header_stamps, load_tum, save_tum

START_NS = 1_700_000_000_123_456_789
TYPES = jazzy_types().types
POINT = TYPES['geometry_msgs/msg/Point'](1.0, 2.0, 3.0)
TURN = TYPES['geometry_msgs/msg/Quaternion'](0.0, 0.6, 0.0, 0.8)
POSE = TYPES['geometry_msgs/msg/Pose'](POINT, TURN)
WITH_COVARIANCE = TYPES['geometry_msgs/msg/PoseWithCovariance'](POSE, np.zeros(36))
VECTOR = TYPES['geometry_msgs/msg/Vector3'](1.0, 2.0, 3.0)
TWIST = TYPES['geometry_msgs/msg/TwistWithCovariance'](TYPES['geometry_msgs/msg/Twist'](VECTOR, VECTOR), np.zeros(36))
CONTENTS = {
    'geometry_msgs/msg/PoseStamped': (POSE,),
    'geometry_msgs/msg/PoseWithCovarianceStamped': (WITH_COVARIANCE,),
    'nav_msgs/msg/Odometry': ('base_link', WITH_COVARIANCE, TWIST),
    'geometry_msgs/msg/TransformStamped': ('base_link', TYPES['geometry_msgs/msg/Transform'](VECTOR, TURN)),
}


@pytest.mark.parametrize('msgtype', CONTENTS)
def test_every_message_with_a_pose_is_understood(tmp_path, messages, msgtype):
    with BagWriter(tmp_path / 'bag') as bag:
        for stamp in (START_NS, START_NS + 7):
            message = TYPES[msgtype](messages.header(stamp), *CONTENTS[msgtype])
            bag.write('/pose', msgtype, message, stamp + 10**9)
    with BagReader(tmp_path / 'bag') as bag:
        trajectory = load_bag_trajectory(bag, None)
    assert trajectory.stamps_ns.tolist() == [START_NS, START_NS + 7]
    np.testing.assert_allclose(trajectory.positions, [[1, 2, 3]] * 2)
    np.testing.assert_allclose(trajectory.quaternions, [[0, 0.6, 0, 0.8]] * 2)


def test_header_stamps_are_those_of_the_decoded_messages(bag_path):
    with BagReader(bag_path) as bag:
        stamps = load_header_stamps(bag, '/image_raw')
        decoded = [bag.decode(each).header.stamp for each in bag.messages(['/image_raw'])]
    assert stamps.tolist() == [each.sec * 10**9 + each.nanosec for each in decoded]


@pytest.mark.parametrize(
    ('load', 'topic', 'words'),
    [
        (load_bag_trajectory, None, '/a, /b have poses; name one'),
        (load_bag_trajectory, '/text', '/a, /b have poses'),
        (load_bag_trajectory, '/b', '/b: pose 1 of 1 has a position'),
        (load_header_stamps, '/text', 'has no header'),
    ],
)
def test_topics_that_are_no_trajectory_are_refused(tmp_path, messages, load, topic, words):
    with BagWriter(tmp_path / 'bag') as bag:
        for name, x in (('/b', np.nan), ('/a', 0.0)):
            bag.write(name, 'geometry_msgs/msg/PoseStamped', messages.pose(START_NS, x, 0, 0), 1)
        bag.write('/text', 'std_msgs/msg/String', messages.text('x'), 1)
    with BagReader(tmp_path / 'bag') as bag, pytest.raises(BagError, match=words):
        load(bag, topic)


GOOD = '1.0 1 2 3 0 0 0 1'


def test_a_trajectory_is_the_same_after_its_file(tmp_path):
    rng = np.random.default_rng(1)
    stamps = 1_700_000_000_000_000_001 + np.arange(30) * 33_333_333
    turns = Rotation.random(30, random_state=1).as_quat()
    trajectory = make_trajectory(stamps, rng.normal(0, 1000, (30, 3)), turns)
    save_tum(tmp_path / 'a.tum', trajectory)
    loaded = load_tum(tmp_path / 'a.tum')
    np.testing.assert_array_equal(loaded.stamps_ns, trajectory.stamps_ns)
    np.testing.assert_array_equal(loaded.positions, trajectory.positions)
    np.testing.assert_allclose(loaded.quaternions, trajectory.quaternions, atol=1e-15)


def test_evo_reads_the_same_trajectory(tmp_path):
    file_interface = pytest.importorskip('evo.tools.file_interface')
    trajectory = planar_trajectory([10**9, 2 * 10**9], [[1, 2, 0.1], [3, 4, -3.0]])
    save_tum(tmp_path / 'a.tum', trajectory)
    theirs = file_interface.read_tum_trajectory_file(str(tmp_path / 'a.tum'))
    np.testing.assert_allclose(theirs.timestamps, [1.0, 2.0])
    np.testing.assert_allclose(theirs.positions_xyz, trajectory.positions)
    np.testing.assert_allclose(theirs.orientations_quat_wxyz, trajectory.quaternions[:, [3, 0, 1, 2]])


def test_comments_and_empty_lines_are_skipped(tmp_path):
    (tmp_path / 'a.tum').write_text(f'# stamp x y z\n\n  {GOOD}  \n')
    np.testing.assert_array_equal(load_tum(tmp_path / 'a.tum').positions, [[1, 2, 3]])


@pytest.mark.parametrize(
    ('lines', 'message'),
    [
        ([GOOD, '2.0 1 2 3 0 0 1'], 'line 3: 7 fields instead of 8'),
        ([GOOD, '2.0 1 2 three 0 0 0 1'], 'line 3: .*three.* as numbers'),
        (['two 1 2 3 0 0 0 1'], 'line 2: .*two.* no time'),
        ([GOOD, '2.0 nan 2 3 0 0 0 1'], 'line 3: a position that is not finite'),
        ([GOOD, '', '2.0 1 2 inf 0 0 0 1'], 'line 4: a position that is not finite'),
        (['2.0 1 2 3 0 0 0 0'], 'line 2: a quaternion not of length 1'),
        (['2.0 1 2 3 0 0 0 nan'], 'line 2: a quaternion not of length 1'),
        (['nan 1 2 3 0 0 0 1'], 'line 2: .* no time'),
        ([GOOD, '1.000 4 5 6 0 0 0 1'], 'line 3: duplicate stamp'),
        ([], 'has no poses'),
    ],
)
def test_bad_lines_are_refused_with_their_number(tmp_path, lines, message):
    path = tmp_path / 'bad.tum'
    path.write_text('\n'.join(['# comment', *lines]))
    with pytest.raises(TumFileError, match=message) as error:
        load_tum(path)
    assert str(path) in str(error.value)
    assert '\n' not in str(error.value)


def test_files_that_cannot_be_read_or_written_are_refused(tmp_path):
    (tmp_path / 'file').write_bytes(b'\xff\xfe\x00\x80')
    for name, words in (('file', 'not a text file'), ('none', 'cannot be read')):
        with pytest.raises(TumFileError, match=words):
            load_tum(tmp_path / name)
    with pytest.raises(TumFileError, match='cannot be written'):
        save_tum(tmp_path / 'file' / 'a.tum', planar_trajectory([1], [[0, 0, 0]]))
