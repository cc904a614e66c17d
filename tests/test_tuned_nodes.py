"""A node whose parameters are changed at run time gives the same results as one that is started with them."""

from pathlib import Path
from typing import Any

import pytest
from golden_runs import BAGS, CORRIDOR, Parameters, Result, replay
from rclpy.parameter import Parameter

from floor_localizer.node import FloorLocalizerNode
from pose_arbiter.node import PoseArbiterNode
from reward_planner.node import RewardPlannerNode
from shirube_ros.managed_node import ManagedNode
from stereo_landmark.commands.teach import main as teach
from stereo_landmark.node import StereoLandmarkNode
from vlc_beacon.node import VlcBeaconNode

pytestmark = [pytest.mark.newest_set_only, pytest.mark.timeout(300)]

IMAGES = ('/image_raw/compressed', '/camera_info', '/odom')
STEREO = [f'/{side}/{topic}' for side in ('left', 'right') for topic in ('image_rect/compressed', 'camera_info')]
TOP = ['/top/image_rect/compressed', '/top/camera_info']
COMPRESSED = {'image_transport': 'compressed'}
SOURCES = [f'/{name}/pose_with_covariance' for name in ('floor_localizer', 'stereo_landmark', 'vlc_beacon')]
# Node, its parameters, those that are changed (settings and the mount), and the drive.
CASES: dict[str, tuple[type[ManagedNode], Parameters, Parameters, tuple[str, Any, float]]] = {
    'floor_localizer': (
        FloorLocalizerNode,
        COMPRESSED,
        {'camera_xyz': [0.02, 0.0, 0.131], 'map_sigma': 0.001, 'dots.noise_sigmas': 8.0},
        ('floor_drive', IMAGES, 2.0),
    ),
    'vlc_beacon': (
        VlcBeaconNode,
        {**COMPRESSED, 'beacons_file': str(BAGS / 'lamp_drive/beacons.yaml'), 'camera_xyz': [0.0, 0.0, 0.0]},
        {'camera_xyz': [0.1, 0.0, 0.0], 'pose.pixel_sigma': 3.0, 'odometry.slip': 0.1, 'lamps.lamps_max': 9},
        ('lamp_drive', (*IMAGES, '/imu'), 6.0),
    ),
    'stereo_landmark': (
        StereoLandmarkNode,
        {**COMPRESSED, **CORRIDOR},
        {'place.method': 'closed_form', 'place.tilt_sigma': 0.0, 'search.window': 10.0},
        ('corridor_left', [*STEREO, '/imu'], 3.5),
    ),
    'reward_planner': (
        RewardPlannerNode,
        {**COMPRESSED, 'source': 'trinocular', 'camera_xyz': [0.1, 0.05, 0.4]},
        {'camera_xyz': [0.1, 0.05, 0.6], 'log_odds_occupied': 2.0, 'hit_fraction_min': 0.2},
        ('room_drive', ['/pose', *STEREO, *TOP], 3.0),
    ),
    'pose_arbiter': (
        PoseArbiterNode,
        {},
        {'floor_localizer.offset': [0.1, 0.0, 0.0], 'gate_margin_xy': 0.2, 'bias_fraction': 0.1},
        ('mission', [*SOURCES, '/odom'], 8.0),
    ),
}


@pytest.mark.parametrize('name', CASES)
def test_a_tuned_node_equals_one_started_so(name: str, tmp_path: Path) -> None:
    create, parameters, changes, drive = CASES[name]
    if name == 'stereo_landmark':
        assert teach(['--batch', str(BAGS / 'corridor_teach/lesson.yaml'), '--places', str(tmp_path)]) == 0
        parameters = {**parameters, 'places_dir': str(tmp_path)}

    def create_and_tune(**options: Any) -> ManagedNode:
        node = create(**options)
        result = node.set_parameters_atomically([Parameter(n, value=v) for n, v in changes.items()])
        assert result.successful, result.reason
        return node

    def published(create: Any, more: Parameters) -> Result:
        result = replay(create, name, {**parameters, **more}, [drive])[drive[0]]
        return {key: value for key, value in result.items() if key != 'levels'}

    tuned = published(create_and_tune, {})
    assert tuned == published(create, changes)
    assert tuned != published(create, {})
