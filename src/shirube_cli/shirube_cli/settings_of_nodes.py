"""The settings classes of every node, from which parameters, their page and their migration come."""

from floor_localizer.core.settings import LocalizerSettings
from floor_localizer.localization.localizer_from_map_file import NodeSettings as FloorLocalizerSettings
from motor_bridge.core.diff_drive_kinematics import DriveSettings
from motor_bridge.node_settings import NodeSettings as MotorBridgeSettings
from pose_arbiter.core.settings import ArbiterSettings, SourceSettings
from pose_arbiter.node_settings import NodeSettings as PoseArbiterSettings
from reward_planner.core.safety.safety_settings import CollisionMonitorSettings
from reward_planner.core.safety.safety_settings import SourceSettings as RangeSourceSettings
from reward_planner.core.settings import (
    DrivingSettings,
    MappingSettings,
    PlannerSettings,
    RewardSettings,
    VoxelSettings,
)
from reward_planner.interface.monitor_inputs import MonitorNodeSettings
from reward_planner.node_settings import NodeSettings as RewardPlannerSettings
from shirube_camera.frame_source import CameraSettings
from shirube_camera.node import OutputSettings
from stereo_landmark.core.primitives.primitive import ImageProcessing
from stereo_landmark.core.settings import LandmarkSettings
from stereo_landmark.node_settings import NodeSettings as StereoLandmarkSettings
from vlc_beacon.core.settings import AuthorizationSettings, ReceiverSettings
from vlc_beacon.node_settings import NodeSettings as VlcBeaconSettings

SETTINGS_OF_NODES: dict[str, dict[str, type]] = {
    'camera': {'the camera': CameraSettings, 'the output': OutputSettings},
    'collision_monitor': {'the node': MonitorNodeSettings, 'footprint, braking and zones': CollisionMonitorSettings},
    'floor_localizer': {'the node': FloorLocalizerSettings, 'the method': LocalizerSettings},
    'motor_bridge': {'the node': MotorBridgeSettings, 'wheels and limits': DriveSettings},
    'pose_arbiter': {'the node': PoseArbiterSettings, 'the method': ArbiterSettings},
    'reward_planner': {
        'the node': RewardPlannerSettings,
        'obstacles': VoxelSettings,
        'poses and map': MappingSettings,
        'routes': PlannerSettings,
        'the reward rule': RewardSettings,
        'driving': DrivingSettings,
    },
    'stereo_landmark': {'the node': StereoLandmarkSettings, 'the method': LandmarkSettings},
    'vlc_beacon': {
        'the node': VlcBeaconSettings,
        'light and pose': ReceiverSettings,
        'authorization': AuthorizationSettings,
    },
}
"""Classes whose fields are parameters of a node, by node and by a title for each class."""
OTHER_SETTINGS: dict[str, type] = {
    'collision_monitor: each source, as `<name>.type` and so on': RangeSourceSettings,
    'pose_arbiter: each source, as `<name>.topic` and so on': SourceSettings,
    'stereo_landmark: image processing, taught for each place': ImageProcessing,
}
"""Classes whose fields are set elsewhere or under a prefix, by title."""
