"""The recorded pictures of the mission through the localizers: each finds the robot, or says nothing where it cannot."""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from floor_localizer.bag_localization import BagLocalization as FloorRun
from floor_localizer.bag_localization import choose_topics as floor_topics
from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.dot_map import DotMap
from floor_localizer.core.fix import Fix
from floor_localizer.core.localizer import FloorLocalizer
from floor_localizer.core.tracker import FloorTracker
from scene_simulator.lamp_bag import write_beacons
from scene_simulator.mission_floor import BELLY_MOUNT, surveyed_floor
from scene_simulator.mission_lamps import CEILING_CAMERA, CEILING_MOUNT, LAMP_RADIUS, LAMP_RATE, LAMPS
from scene_simulator.mission_layout import CARPET
from scene_simulator.mission_sensors import STEREO_RIG
from shirube_bags.bag_reader import BagReader
from shirube_bags.bag_trajectory import header_stamp
from shirube_geometry import PlanarPose
from shirube_mission.place_teaching import teach_places
from shirube_ros.pose_conversion import planar_pose
from stereo_landmark.bag_localization import BagLocalization as LandmarkRun
from stereo_landmark.core.landmark_localizer import LandmarkSettings
from stereo_landmark.core.pair.pair_stream import PairStream
from stereo_landmark.core.pair.settings import PairSettings
from stereo_landmark.files.place_file import load_places
from stereo_landmark.pair_recording import choose_topics as pair_topics
from vlc_beacon.commands.locate import locate as locate_lamps
from vlc_beacon.commands.locate import make_parser as lamp_options
