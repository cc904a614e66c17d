"""A fisheye lens, and a part of the sensor with binning, give the pose of the floor under the robot."""

import cv2
import numpy as np
import pytest
from floor_views import is_right
from sensor_msgs.msg import CameraInfo, RegionOfInterest

from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.dots import DotMap
from floor_localizer.core.fix import Fix
from floor_localizer.core.localizer import FloorLocalizer
from scene_simulator.floor.camera import FloorCamera
from scene_simulator.floor.dot_floor import FloorDesign, generate_dot_floor
from shirube_core.geometry import SE2, CameraMount, LensModel, PinholeCamera
from shirube_ros.camera.info import camera_from_camera_info

FLOOR = generate_dot_floor(FloorDesign(size=(0.7, 0.7), count=2640), seed=4)
MOUNT = CameraMount((0.05, -0.02, 0.13))
POSE = SE2(0.33, 0.37, 0.8)
# 94 degrees from side to side, 116 from corner to corner.
LENS = (-0.012, 0.021, -0.018, 0.004)
WIDE = PinholeCamera(640, 480, 390.0, 391.0, 322.0, 238.0, LENS, LensModel.EQUIDISTANT)


@pytest.fixture(scope='module')
def image() -> np.ndarray:
    """A picture behind OpenCV's own fisheye model, from a sharper one of a pinhole."""
    pinhole = PinholeCamera(1800, 1500, 500.0, 500.0, 899.5, 749.5)
    v, u = np.mgrid[: WIDE.height, : WIDE.width].astype(np.float64)
    places = np.column_stack([u.ravel(), v.ravel()])[:, None]
    rays = cv2.fisheye.undistortPoints(places, WIDE.matrix, np.array(LENS))[:, 0]
    maps = (rays * 500.0 + (899.5, 749.5)).astype(np.float32)
    flat = FloorCamera(pinhole).photograph(FLOOR, [POSE], MOUNT).image
    return cv2.remap(flat, *(each.reshape(u.shape) for each in maps.T), cv2.INTER_CUBIC)


@pytest.fixture(scope='module')
def located_by() -> FloorLocalizer:
    return FloorLocalizer(index_map(DotMap(FLOOR.points, FLOOR.diameters)), MOUNT)


def test_a_fisheye_lens_gives_the_pose(image: np.ndarray, located_by: FloorLocalizer) -> None:
    fix = located_by.locate(image, WIDE)
    assert is_right(fix, POSE, position=0.0005, heading=0.002)
    assert isinstance(fix, Fix)
    assert fix.match_rate > 0.9


@pytest.mark.parametrize('binning', [1, 2])
def test_a_part_of_the_sensor_gives_the_same_pose(image: np.ndarray, located_by: FloorLocalizer, binning: int) -> None:
    x, y, width, height = 61, 37, 500, 402
    part = image[y : y + height, x : x + width]
    size = (width // binning, height // binning)
    part = cv2.resize(part, size, interpolation=cv2.INTER_AREA)  # the mean of each block, as the sensor's
    message = CameraInfo(
        width=640, height=480, distortion_model='equidistant', d=LENS, k=WIDE.matrix.ravel(),
        roi=RegionOfInterest(x_offset=x, y_offset=y, width=width, height=height), binning_x=binning, binning_y=binning,
    )  # fmt: skip
    assert is_right(located_by.locate(part, camera_from_camera_info(message, 't')), POSE, 0.0002, 0.001)
