"""Pose filter: tracks the pose with odometry when too few lamps are in view for a pose.

An extended Kalman filter over x, y, z, yaw and three odometry biases: scale of the distance, scale of yaw, and yaw per
metre. The biases are estimated while lamps are in view and corrected in gaps.
"""

import math

import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry import SE2, SE3, wrap_angle
from vlc_beacon.core.pose.lamp_rays import LampRays
from vlc_beacon.core.pose.pose_fix import ExpectedPose
from vlc_beacon.core.pose.pose_least_squares import projections_with_jacobian
from vlc_beacon.core.settings import OdometrySettings, PoseSettings

X, Y, Z, YAW, DISTANCE_SCALE, YAW_SCALE, YAW_PER_METRE = range(7)
CORRELATION_DISTANCE = 1.0
"""Correlation length of the errors of lamp positions, lens and tilt [m]."""
TURN_DISTANCE = 0.3
"""Distance equivalent to a rotation by one radian, by the motion of lamps over the lens [m]."""
CORRELATED_IMAGES_MAX = 300
"""Maximum number of correlated images that count as one, five seconds of a stationary robot."""
HEIGHT_WALK = 0.001
"""Random walk of the floor height over one metre [m]."""
ITERATIONS = 2


class PoseFilter:
    """Extended Kalman filter of the robot's pose."""

    def __init__(
        self,
        T_map_base: SE2,
        height: float,
        covariance: NDArray[np.float64],
        settings: PoseSettings | None = None,
        odometry_settings: OdometrySettings | None = None,
    ) -> None:
        """Initialize with a pose.

        Args:
            T_map_base: initial pose of the robot.
            height: height of the base in the map frame [m].
            covariance: covariance of x, y, z [m] and yaw [rad], shape (4, 4), as in `BeaconFix`; a height with zero
                variance is constant.
            settings: measurement noise, None for the defaults.
            odometry_settings: odometry noise, None for the defaults.
        """
        self.apply_settings(settings or PoseSettings(), odometry_settings or OdometrySettings())
        self._state = np.array([T_map_base.x, T_map_base.y, height, T_map_base.yaw, 0.0, 0.0, 0.0])
        self._P = np.zeros((7, 7))
        self._P[:4, :4] = covariance
        self._P[range(4, 7), range(4, 7)] = self._bias_variance
        self._height_walk = HEIGHT_WALK if covariance[2, 2] > 0.0 else 0.0
        self._distance = math.inf
        self._gap_distance = 0.0
        self._cluster_distance = 0.0
        self._cluster_images = 0
        self._cluster_lamps: set[int] = set()

    def apply_settings(self, settings: PoseSettings, odometry: OdometrySettings) -> None:
        """Use other noise from the next step on; the state and its covariance are kept."""
        self._settings, self._odometry = settings, odometry
        errors = [odometry.scale_error, odometry.scale_error, odometry.turn_error]
        self._bias_variance = np.array(errors) ** 2

    @property
    def pose(self) -> SE2:
        """``T_map_base``."""
        return SE2(float(self._state[X]), float(self._state[Y]), float(self._state[YAW]))

    @property
    def height(self) -> float:
        """Height of the base in the map frame [m]."""
        return float(self._state[Z])

    @property
    def bearing_state(self) -> NDArray[np.float64]:
        """The pose as a state of `bearing_model`, shape (6,)."""
        return np.append(self._state[:4], (0.0, 0.0))

    @property
    def covariance(self) -> NDArray[np.float64]:
        """Covariance of x, y, z [m] and yaw [rad], shape (4, 4)."""
        return self._P[:4, :4].copy()

    @property
    def is_certain(self) -> bool:
        """Whether the position standard deviation is below the limit of the settings."""
        spread = float(np.linalg.eigvalsh(self._P[:2, :2])[-1])
        return math.sqrt(max(spread, 0.0)) <= self._odometry.position_sigma_max

    @property
    def is_confirmed(self) -> bool:
        """Whether a lamp was accepted within the maximum dead reckoning distance."""
        return self._gap_distance <= self._odometry.gap_distance_max

    def expected(self) -> ExpectedPose:
        """Return the predicted pose for `BeaconLocator.locate`."""
        keep = [X, Y, YAW]
        return ExpectedPose(self.pose, self._P[np.ix_(keep, keep)])

    def predict(self, T_before_after: SE2) -> None:
        """Predict the state with the odometry motion since the last call, in the previous base frame."""
        distance = math.hypot(T_before_after.x, T_before_after.y)
        turn = T_before_after.yaw
        traveled = distance + TURN_DISTANCE * abs(turn)
        self._distance += traveled
        self._gap_distance += traveled
        self._cluster_distance += distance
        scale, yaw_scale, yaw_per_metre = self._state[DISTANCE_SCALE:]
        step = np.array([T_before_after.x, T_before_after.y])
        # Half of the yaw correction applies at the middle of the step.
        yaw = self._state[YAW] + 0.5 * (yaw_scale * turn + yaw_per_metre * distance)
        cos, sin = math.cos(yaw), math.sin(yaw)
        heading = np.array([[cos, -sin], [sin, cos]])
        forward = heading @ step
        lateral = np.array([-forward[1], forward[0]]) * (1.0 + scale)
        F = np.eye(7)
        F[:2, YAW], F[:2, DISTANCE_SCALE] = lateral, forward
        F[:2, YAW_SCALE], F[:2, YAW_PER_METRE] = 0.5 * turn * lateral, 0.5 * distance * lateral
        F[YAW, YAW_SCALE], F[YAW, YAW_PER_METRE] = turn, distance
        self._state[:2] += (1.0 + scale) * forward
        self._state[YAW] = wrap_angle(float(self._state[YAW] + turn * (1.0 + yaw_scale) + yaw_per_metre * distance))
        self._P = F @ self._P @ F.T + self._process_noise(distance, abs(turn))

    def _process_noise(self, distance: float, turn: float) -> NDArray[np.float64]:
        noise = np.zeros(7)
        noise[[X, Y]] = self._odometry.slip**2 * distance
        noise[Z] = self._height_walk**2 * distance
        noise[YAW] = self._odometry.turn_slip**2 * (distance + turn)
        noise[DISTANCE_SCALE:] = self._bias_variance * distance / self._odometry.bias_correlation_length
        return np.diag(noise)

    def update(self, rays: LampRays, lamps: NDArray[np.float64], camera: SE3) -> NDArray[np.bool_]:
        """Update the state with the lamps of an image, one is enough; arguments as in `PoseLeastSquares`.

        Returns:
            mask of the lamps that pass the innovation gate, shape (n,); the others are rejected.
        """
        inliers = self._gate(rays, lamps, camera)
        if inliers.any():
            accepted = rays.subset(inliers)
            correlated = self._correlated_images(set(accepted.ids.tolist()))
            self._correct(accepted, lamps[inliers], camera, correlated)
            self._distance = self._gap_distance = 0.0
        return inliers

    def _correlated_images(self, lamps: set[int]) -> float:
        """Return the number of correlated images that count as one; call it once per image."""
        if self._cluster_distance > CORRELATION_DISTANCE:
            self._cluster_distance = 0.0
            self._cluster_lamps.clear()
        if not lamps <= self._cluster_lamps:
            self._cluster_lamps |= lamps
            self._cluster_images = 0
        self._cluster_images += 1
        correlated = max(CORRELATION_DISTANCE / max(self._distance, 1e-9), 1.0)
        if self._cluster_images > CORRELATED_IMAGES_MAX:
            return correlated
        return min(correlated, CORRELATED_IMAGES_MAX)

    def _gate(self, rays: LampRays, lamps: NDArray[np.float64], camera: SE3) -> NDArray[np.bool_]:
        residual, H, R = self._linearize(rays, lamps, camera, self._state, 1.0)
        S = H @ self._P @ H.T + R
        inliers = np.zeros(len(rays), dtype=np.bool_)
        for i in range(len(rays)):
            part = slice(2 * i, 2 * i + 2)
            distance = residual[part] @ np.linalg.solve(S[part, part], residual[part])
            inliers[i] = distance < self._settings.gate_sigmas**2
        return inliers

    def _correct(self, rays: LampRays, lamps: NDArray[np.float64], camera: SE3, correlated: float) -> None:
        """Iterated EKF update, because the rays are nonlinear in the position."""
        predicted, state = self._state, self._state
        for _ in range(ITERATIONS):
            residual, H, R = self._linearize(rays, lamps, camera, state, correlated)
            S = H @ self._P @ H.T + R
            K = np.linalg.solve(S, H @ self._P).T
            state = predicted + K @ (residual - H @ (predicted - state))
        self._state = state
        self._state[YAW] = wrap_angle(float(state[YAW]))
        joseph_factor = np.eye(7) - K @ H
        self._P = joseph_factor @ self._P @ joseph_factor.T + K @ R @ K.T

    def _linearize(
        self, rays: LampRays, lamps: NDArray[np.float64], camera: SE3, state: NDArray[np.float64], correlated: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Return innovation (2n,), Jacobian (2n, 7) and measurement noise (2n, 2n) of the rays.

        The common errors of lamps, lens and tilt are shared by ``correlated`` images, so their variance is multiplied.
        """
        seen, jacobian, depths = projections_with_jacobian(
            np.append(state[:4], (0.0, 0.0)), lamps, rays.motions, camera
        )
        count = len(rays)
        H = np.zeros((2 * count, 7))
        H[:, :4] = jacobian[:, :, :4].reshape(-1, 4)
        settings = self._settings
        noise = rays.covariances(0.0)
        bias = rays.covariances(settings.pixel_sigma) - noise
        bias += ((settings.beacon_sigma / np.maximum(depths, 0.1)) ** 2)[:, None, None] * np.eye(2)
        tilt = jacobian[:, :, 4:].reshape(-1, 2) * settings.tilt_sigma
        R = correlated * (tilt @ tilt.T)
        for i in range(count):
            part = slice(2 * i, 2 * i + 2)
            R[part, part] += noise[i] + correlated * bias[i]
        return (rays.rays - seen).ravel(), H, R
