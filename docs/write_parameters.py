"""Writes docs/parameters.md from the settings that the nodes declare: `python docs/write_parameters.py`."""

from __future__ import annotations

from pathlib import Path

from floor_localizer.core.settings import LocalizerSettings
from floor_localizer.node_settings import NodeSettings
from pose_arbiter.core.arbiter_settings import ArbiterSettings
from pose_arbiter.core.source_settings import SourceSettings
from pose_arbiter.node_settings import NodeSettings as PoseArbiterSettings
from reward_planner.core.driving.driving_settings import DrivingSettings
from reward_planner.core.mapping.mapping_settings import MappingSettings
from reward_planner.core.planner_settings import PlannerSettings
from reward_planner.core.reward.reward_settings import RewardSettings
from reward_planner.core.voxels.voxel_settings import VoxelSettings
from reward_planner.node_settings import NodeSettings as RewardPlannerSettings
from shirube_settings import settings_table
from stereo_landmark.core.landmark_localizer import LandmarkSettings
from stereo_landmark.core.procedure.detected_scene import ImageProcessing
from stereo_landmark.node_settings import NodeSettings as StereoLandmarkSettings
from vlc_beacon.core.receiver.settings import ReceiverSettings
from vlc_beacon.core.trust.trust_settings import TrustSettings
from vlc_beacon.node_settings import NodeSettings as VlcBeaconSettings

PAGE = Path(__file__).parent / 'parameters.md'


def parameters_page() -> str:
    """Return the page as it should stand."""
    return (
        '\n\n'.join(
            [
                '# Parameters',
                'Made by `python docs/write_parameters.py` from the definitions in the code; do not edit.',
                '## floor_localizer: the node',
                settings_table(NodeSettings).strip(),
                '## floor_localizer: the method',
                settings_table(LocalizerSettings).strip(),
                '## pose_arbiter: the node',
                'And `sources`, the names of the sources of poses; by default the three localizers.',
                settings_table(PoseArbiterSettings).strip(),
                '## pose_arbiter: each source, as `<name>.topic` and so on',
                settings_table(SourceSettings).strip(),
                '## pose_arbiter: the method',
                settings_table(ArbiterSettings).strip(),
                '## reward_planner: the node',
                settings_table(RewardPlannerSettings).strip(),
                '## reward_planner: obstacles',
                settings_table(VoxelSettings).strip(),
                '## reward_planner: poses and map',
                settings_table(MappingSettings).strip(),
                '## reward_planner: routes',
                settings_table(PlannerSettings).strip(),
                '## reward_planner: the reward rule',
                settings_table(RewardSettings).strip(),
                '## reward_planner: driving',
                settings_table(DrivingSettings).strip(),
                '## stereo_landmark: the node',
                settings_table(StereoLandmarkSettings).strip(),
                '## stereo_landmark: the method',
                settings_table(LandmarkSettings).strip(),
                '## stereo_landmark: image processing, taught for each place',
                settings_table(ImageProcessing).strip(),
                '## vlc_beacon: the node',
                settings_table(VlcBeaconSettings).strip(),
                '## vlc_beacon: light and pose',
                settings_table(ReceiverSettings).strip(),
                '## vlc_beacon: trust',
                settings_table(TrustSettings).strip(),
            ]
        )
        + '\n'
    )


if __name__ == '__main__':
    PAGE.write_text(parameters_page())
