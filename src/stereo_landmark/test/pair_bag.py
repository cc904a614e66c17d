"""Writes a bag of stereo pairs."""

import numpy as np
from taught_wall import CALIBRATIONS, SIDES

from scene_simulator.messages import camera_info, compressed_image, imu
from scene_simulator.robot.leg_drive import TiltReading
from shirube_bags.bag_writer import BagWriter

IMAGE, INFO = 'sensor_msgs/msg/CompressedImage', 'sensor_msgs/msg/CameraInfo'


def info_of(calibration, stamp_ns=0):
    """Return a CameraInfo with R and P."""
    R, P = np.reshape(calibration.rotation, (3, 3)), np.reshape(calibration.projection, (3, 4))
    return camera_info(calibration.raw, 'camera', stamp_ns, R, P)


def write_pairs(path, pairs, calibrations=CALIBRATIONS, tilt=None):
    """Write images and calibrations, and return the path.

    Args:
        path: path of the bag.
        pairs: stamp of the left image [ns], both images, and how much later the right one is [ns] if it is.
        calibrations: calibrations of the left and the right camera.
        tilt: roll and pitch of an IMU reading before each pair [rad], None without IMU.
    """
    with BagWriter(path) as bag:
        for begin_ns, images, *later in pairs:
            if tilt is not None:
                before_ns = begin_ns - 20_000_000
                message = imu(TiltReading(before_ns * 1e-9, *tilt), 'base_link', before_ns)
                bag.write('/imu', 'sensor_msgs/msg/Imu', message, before_ns)
            stamps = begin_ns, sum(later, begin_ns)
            for side, stamp_ns, image, calibration in zip(SIDES, stamps, images, calibrations):
                bag.write(f'/{side}/camera_info', INFO, info_of(calibration, stamp_ns), stamp_ns)
                message = compressed_image(image, 'camera', stamp_ns, 100)
                bag.write(f'/{side}/image_rect/compressed', IMAGE, message, stamp_ns)
    return path
