"""Poses and odometry by stamp: interpolation, extrapolation, and the motion between two stamps with its covariance."""

from shirube_core.motion.cumulative_odometry import CumulativeOdometry, Motion, motion_between, motion_covariance
from shirube_core.motion.odometry_buffer import NoPoseReason, OdometryBuffer

__all__ = ['CumulativeOdometry', 'Motion', 'NoPoseReason', 'OdometryBuffer', 'motion_between', 'motion_covariance']
