"""Each recorded bag holds what the node needs, in order, with its truth, and comes out the same again."""

import math
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from scene_simulator.ceiling.lamp_drive import paper_run
from scene_simulator.commands import corridor, floor, lamps, room
from scene_simulator.commands.recording import START_NS
from scene_simulator.corridor.stereo_drive import make_corridor_drive
from scene_simulator.floor.demo_scene import DEMO_CAMERA, DemoScene
from scene_simulator.room.room_drive import RoomDrive
from shirube_bags.bag_reader import BagMessage, BagReader
from shirube_core.geometry import yaw_from_quaternion
from shirube_core.waveform import steady_light, waveform_from_steps, waveform_to_csv

SECONDS = {'floor': 1.0, 'lamps': 0.1, 'room': 0.4, 'corridor': 0.4}
COMMANDS = {
    'floor': floor.record_floor_bag,
    'lamps': lamps.record_lamp_bag,
    'room': room.record_room_bag,
    'corridor': corridor.record_stereo_bag,
}
PAIR = [f'/{side}/{name}' for side in ('left', 'right') for name in ('camera_info', 'image_rect/compressed')]
TRUTH = '/ground_truth'
MONO = ['/image_raw/compressed', '/camera_info', TRUTH]
COUNTS = {
    'floor': {**dict.fromkeys([*MONO, '/dirt'], 10), '/odom': 50},
    'lamps': {**dict.fromkeys(MONO, 7), '/odom': 5, '/imu': 5},
    'room': {
        **dict.fromkeys([*PAIR, '/top/camera_info', '/top/image_rect/compressed', TRUTH], 2),
        '/pose': 8,
        '/odom': 20,
        '/truth/map': 1,
    },
    'corridor': {**dict.fromkeys([*PAIR, TRUTH], 2), '/odom': 20, '/imu': 20},
}
NEWEST = pytest.mark.newest_set_only
KINDS = ['floor', *(pytest.param(kind, marks=NEWEST) for kind in ('lamps', 'room', 'corridor'))]
Record = Callable[..., int]
OpenBag = Callable[[str], Path]


@pytest.fixture(scope='module')
def waveforms(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Files of three lamps that shine and of one whose halves never shine together."""
    folder = tmp_path_factory.mktemp('waveforms')
    halves = waveform_from_steps([0.004, 0.004], [[1.0, 0.0], [0.0, 1.0]])
    for beacon in range(11, 15):
        light = halves if beacon == 14 else steady_light(2)
        (folder / f'{beacon}.csv').write_text(waveform_to_csv(light))
    return [f'{beacon}={folder / f"{beacon}.csv"}' for beacon in range(11, 15)]


@pytest.fixture(scope='module')
def record(waveforms: list[str]) -> Record:
    """Runs the command of a kind of bag."""

    def run(kind: str, path: Path, *options: object) -> int:
        given = {'lamps': waveforms, 'corridor': ['right']}.get(kind, [])
        return COMMANDS[kind]([str(a) for a in (path, *given, '--seconds', SECONDS[kind], *options)])

    return run


@pytest.fixture(scope='module')
def bag(tmp_path_factory: pytest.TempPathFactory, record: Record) -> OpenBag:
    """Returns the recorded bag of a kind."""

    @cache
    def path_of(kind: str) -> Path:
        path = tmp_path_factory.mktemp('bags') / kind
        assert record(kind, path) == 0
        return path

    return path_of


def messages_in(path: Path) -> list[BagMessage]:
    with BagReader(path) as reader:
        return list(reader.messages())


def last_in(path: Path) -> dict[str, Any]:
    with BagReader(path) as reader:
        return {message.topic: reader.decode(message) for message in reader.messages()}


def picture_in(message: Any) -> np.ndarray:
    return cv2.imdecode(message.data, cv2.IMREAD_UNCHANGED)


@pytest.mark.parametrize('kind', KINDS)
def test_topics_have_their_rates_and_messages_are_received_at_their_stamps(bag: OpenBag, kind: str) -> None:
    stamps = []
    with BagReader(bag(kind)) as reader:
        assert {name: topic.message_count for name, topic in reader.topics.items()} == COUNTS[kind]
        for message in reader.messages():
            stamps.append(message.stamp_ns)
            if message.topic != '/dirt':
                stamp = reader.decode(message).header.stamp
                assert stamp.sec * 1_000_000_000 + stamp.nanosec == message.stamp_ns
    assert stamps == sorted(stamps)
    if kind != 'lamps':  # whose camera's stamps jitter
        assert stamps[0] == START_NS


@pytest.mark.parametrize('kind', KINDS)
def test_the_same_seed_records_the_same_bag(bag: OpenBag, record: Record, kind: str, tmp_path: Path) -> None:
    assert record(kind, tmp_path / 'again') == 0
    assert messages_in(bag(kind)) == messages_in(tmp_path / 'again')


@NEWEST
def test_another_seed_records_another_bag(bag: OpenBag, record: Record, tmp_path: Path) -> None:
    assert record('room', tmp_path / 'other', '--seed', 2) == 0
    bags = [messages_in(path) for path in (bag('room'), tmp_path / 'other')]
    one, other = ([bytes(m.raw) for m in each if m.topic.endswith('compressed')] for each in bags)
    assert one != other


@pytest.mark.parametrize('kind', KINDS)
@pytest.mark.parametrize(
    ('options', 'complaint'),
    [
        ((), 'exists already'),
        (('--seed', -1), 'seed'),
        *((('--seconds', wrong), 'positive number of seconds') for wrong in (0.0, -1.0, math.nan, math.inf)),
    ],
)
def test_a_bad_argument_ends_in_one_line(
    record: Record,
    kind: str,
    options: tuple[object, ...],
    complaint: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert record(kind, tmp_path / 'bag' if options else tmp_path, *options) == 1
    (line,) = [text for text in capsys.readouterr().err.splitlines() if text.startswith('record_')]
    assert complaint in line


@NEWEST
@pytest.mark.parametrize(
    ('first', 'complaint'),
    [
        (['lamp.csv'], 'give each lamp'),
        (['{0[1]}'], 'unique ID'),
        (['1=none.csv'], 'cannot be read'),
        ([f'1={__file__}'], 'first line'),
        ([], '4 waveforms'),
    ],
)
def test_a_bad_lamp_ends_in_one_line(
    waveforms: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str], first: list[str], complaint: str
) -> None:
    given = [*(word.format(waveforms) for word in first), *waveforms[1:]]
    assert lamps.record_lamp_bag([str(tmp_path / 'bag'), *given]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert complaint in line


def test_truth_calibration_picture_and_odometry_are_those_of_the_floor(bag: OpenBag) -> None:
    last, scene = last_in(bag('floor')), DemoScene()
    pose, true = last['/ground_truth'].pose, scene.pose_at(0.9)
    assert (pose.position.x, pose.position.y, pose.position.z) == (true.x, true.y, 0.0)
    turn = pose.orientation
    assert yaw_from_quaternion(turn.x, turn.y, turn.z, turn.w) == pytest.approx(true.yaw)
    np.testing.assert_array_equal(last['/camera_info'].k.reshape(3, 3), DEMO_CAMERA.matrix)
    np.testing.assert_array_equal(last['/camera_info'].d, DEMO_CAMERA.distortion)
    image = picture_in(last['/image_raw/compressed'])
    clean = scene.photograph(0.9, np.random.default_rng(5)).image
    assert image.shape == (235, 235)
    assert np.abs(image.astype(int) - clean).mean() < 4.0
    assert not last['/dirt'].data
    with BagReader(bag('floor')) as reader:
        first = reader.decode(next(reader.messages(['/odom']))).pose.pose
    assert (first.position.x, first.position.y, first.orientation.w) == (0.0, 0.0, 1.0)
    way = math.hypot(last['/odom'].pose.pose.position.x, last['/odom'].pose.pose.position.y)
    assert way == pytest.approx(scene.pose_at(0.0).distance_to(scene.pose_at(0.98)), rel=0.05)
    assert last['/odom'].twist.twist.linear.x == pytest.approx(0.25, abs=0.03)


@NEWEST
def test_truth_calibration_tilt_picture_and_beacons_are_those_of_the_lamps(bag: OpenBag) -> None:
    last = last_in(bag('lamps'))
    drive = paper_run([steady_light(2)] * 4, camera=lamps.GLOBAL, rest=lamps.REST)
    pose, truth = drive.pose_at(SECONDS['lamps']), last['/ground_truth'].pose.position
    assert (truth.x, truth.y) == pytest.approx((pose.x, pose.y), abs=1e-6)
    np.testing.assert_array_equal(last['/camera_info'].k.reshape(3, 3), lamps.GLOBAL.intrinsics.matrix)
    turn = last['/imu'].orientation
    roll, pitch, _ = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).as_euler('xyz')
    assert (roll, pitch) == pytest.approx(drive.tilt_at(0.08), abs=math.radians(0.5))
    image = picture_in(last['/image_raw/compressed'])
    frame = list(drive.frames(SECONDS['lamps']))[-1]
    assert image.shape == frame.photo.image.shape
    lamp_b = next(s for s in frame.photo.lamp_projections if s.lamp == 2)
    u, v = (round(x) for x in lamp_b.centre)
    around = np.s_[v - 6 : v + 7, u - 6 : u + 7]
    assert np.abs(image[around].astype(int) - frame.photo.image[around]).mean() < 6.0
    head, *lines = (bag('lamps') / 'beacons.yaml').read_text().splitlines()
    assert (head, len(lines)) == ('beacons:', 4)
    assert lines[3] == '  - {id: 14, xyz: [1.8, 1.8, 2.5], radius: 0.0325}'


@NEWEST
def test_a_rolling_shutter_takes_large_images_at_thirty_a_second(record: Record, tmp_path: Path) -> None:
    assert record('lamps', tmp_path / 'rolling', '--shutter', 'rolling') == 0
    images = [m for m in messages_in(tmp_path / 'rolling') if m.topic == '/image_raw/compressed']
    assert len(images) == math.ceil(SECONDS['lamps'] * 30.0 * lamps.CLOCK_RATIO)
    assert picture_in(last_in(tmp_path / 'rolling')['/image_raw/compressed']).shape == (1024, 1280)


@NEWEST
def test_the_true_map_is_what_a_point_by_point_look_says(bag: OpenBag) -> None:
    scene, grid = RoomDrive(), last_in(bag('room'))['/truth/map']
    cells = grid.data.reshape(grid.info.height, grid.info.width)
    np.testing.assert_array_equal(cells, room.true_map(scene)[0])
    x0, y0, _, x1, y1, _ = scene.size
    points = np.random.default_rng(1).uniform((x0, y0), (x1, y1), (20_000, 2))
    solid = np.zeros(len(points), dtype=bool)
    for box in scene.room.boxes.boxes:
        if box[2] < room.HEIGHTS[1] and box[5] > room.HEIGHTS[0]:
            solid |= ((points > box[:2]) & (points < box[3:5])).all(axis=1)
    corner = (grid.info.origin.position.x, grid.info.origin.position.y)
    columns, rows = np.floor((points - corner) / room.RESOLUTION).astype(int).T
    assert (cells[rows, columns][solid] == 100).all()
    assert (cells[rows, columns][~solid] == 100).mean() < 0.06  # only cells at the edges


@NEWEST
def test_truth_calibration_and_pictures_are_those_of_the_corridor(bag: OpenBag) -> None:
    last, drive = last_in(bag('corridor')), make_corridor_drive('right')
    frame = list(drive.frames(SECONDS['corridor']))[-1]
    truth = last['/ground_truth'].pose.position
    assert (truth.x, truth.y) == pytest.approx((frame.pose.x, frame.pose.y), abs=1e-9)
    projection = last['/right/camera_info'].p.reshape(3, 4)
    assert projection[0, 3] == pytest.approx(-projection[0, 0] * drive.rig.baseline)
    assert not last['/left/camera_info'].p.reshape(3, 4)[:, 3].any()
    for side, expected in (('left', frame.left), ('right', frame.right)):
        image = picture_in(last[f'/{side}/image_rect/compressed'])
        assert image.shape == expected.shape
        assert np.abs(image.astype(int) - expected).mean() < 2.0
        assert last[f'/{side}/camera_info'].header.frame_id == f'{side}_camera_optical_frame'


@NEWEST
def test_a_raw_rig_records_raw_images_with_their_calibration(record: Record, tmp_path: Path) -> None:
    assert record('corridor', tmp_path / 'raw', '--raw') == 0
    last = last_in(tmp_path / 'raw')
    assert '/left/image_raw/compressed' in last
    info = last['/right/camera_info']
    assert np.all(info.d != 0.0, where=[True, True, True, True, False])
    assert not np.allclose(info.r.reshape(3, 3), np.eye(3), atol=1e-3)
