"""The robot's pose with its covariance: how it moves on and how a measurement mends it."""

from __future__ import annotations

import math
from typing import NamedTuple

from pose_arbiter.core.arbiter_settings import ArbiterSettings
from pose_arbiter.core.covariance import (
    Covariance,
    added,
    conjugated,
    diagonal,
    inverse,
    levered,
    product,
    scaled,
    turned,
)
from pose_arbiter.core.odometry_mark import OdometryMark, motion_between

_CREEP_XY, _CREEP_YAW = 2e-3, 2e-3  # what nobody sees, after a second [m, rad]


class Estimate(NamedTuple):
    """A pose at an instant.

    Attributes:
        mark: odometry at that instant.
        x, y, yaw: ``T_map_base`` [m, rad].
        scatter: covariance of what more poses average away.
        lasting_xy, lasting_yaw: standard deviation of what they do not [m, rad].
    """

    mark: OdometryMark
    x: float
    y: float
    yaw: float
    scatter: Covariance
    lasting_xy: float = 0.0
    lasting_yaw: float = 0.0

    @property
    def covariance(self) -> Covariance:
        """Of (x, y, yaw), all in all."""
        return added(self.scatter, diagonal(self.lasting_xy**2, self.lasting_yaw**2))


def moved_on(estimate: Estimate, mark: OdometryMark, settings: ArbiterSettings) -> Estimate:
    """Return the estimate at a later mark: moved by odometry, less sure."""
    motion = motion_between(estimate.mark, mark)
    between = estimate.yaw - estimate.mark.yaw  # trail to map
    cos, sin = math.cos(between), math.sin(between)
    x, y = cos * motion.x - sin * motion.y, sin * motion.x + cos * motion.y
    noise = added(
        turned(motion.covariance, cos, sin),
        diagonal(
            (settings.drift_speed * motion.blind) ** 2 + _CREEP_XY**2 * motion.seconds,
            (settings.drift_turn_rate * motion.blind) ** 2 + _CREEP_YAW**2 * motion.seconds,
        ),
    )
    # A heading that is lastingly wrong leads astray as one that is wrong by chance does.
    aside = (estimate.lasting_yaw**2 * y * y, -(estimate.lasting_yaw**2) * x * y, 0.0)
    lasting = (*aside, estimate.lasting_yaw**2 * x * x, 0.0, 0.0)
    scatter = added(added(levered(estimate.scatter, x, y), noise), lasting)
    return Estimate(
        mark,
        estimate.x + x,
        estimate.y + y,
        math.remainder(estimate.yaw + motion.yaw, math.tau),
        scatter,
        estimate.lasting_xy,
        estimate.lasting_yaw,
    )


def residual(estimate: Estimate, x: float, y: float, yaw: float) -> tuple[float, float, float]:
    """Return how a measured pose differs from the estimate [m, m, rad]."""
    return x - estimate.x, y - estimate.y, math.remainder(yaw - estimate.yaw, math.tau)


def mended(
    estimate: Estimate, difference: tuple[float, float, float], noise: Covariance, lasting_share: float
) -> Estimate:
    """Return the estimate after a measurement.

    The gain is that of all the uncertainty, ``K = T (T + R)⁻¹``. Joseph's form then holds for the part that averages
    away, while the lasting parts of estimate and measurement are taken to be the same error, whose deviations add.

    Args:
        estimate: at the stamp of the measurement.
        difference: measured pose less estimate [m, m, rad].
        noise: R, covariance of the measurement.
        lasting_share: share of R that is the same in each pose of the source.
    """
    total = estimate.covariance
    gain = product(total, inverse(added(total, noise)))
    (kxx, kxy, kxt), (kyx, kyy, kyt), (ktx, kty, ktt) = gain
    dx, dy, dt = difference
    rest = ((1.0 - kxx, -kxy, -kxt), (-kyx, 1.0 - kyy, -kyt), (-ktx, -kty, 1.0 - ktt))
    scatter = added(conjugated(rest, estimate.scatter), conjugated(gain, scaled(noise, 1.0 - lasting_share)))
    weight = 0.5 * (kxx + kyy)
    sigma_xy = math.sqrt(lasting_share * 0.5 * (noise[0] + noise[3]))
    sigma_yaw = math.sqrt(lasting_share * noise[5])
    return Estimate(
        estimate.mark,
        estimate.x + kxx * dx + kxy * dy + kxt * dt,
        estimate.y + kyx * dx + kyy * dy + kyt * dt,
        math.remainder(estimate.yaw + ktx * dx + kty * dy + ktt * dt, math.tau),
        scatter,
        abs((1.0 - weight) * estimate.lasting_xy + weight * sigma_xy),
        abs((1.0 - ktt) * estimate.lasting_yaw + ktt * sigma_yaw),
    )
