"""Heave and tilt of a robot's body, the resulting camera mount, and what an inertial unit reads."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from shirube_core.geometry import CameraMount, matrix_from_rpy

_FREQUENCIES = (0.07, 0.19, 0.43)
"""Frequencies of the oscillation; each motion has its own phase [Hz]."""


@dataclass(frozen=True)
class Suspension:
    """Slow motion of the body about the point of ``base_link`` on the floor.

    Attributes:
        heave: greatest height above or below rest [m].
        tilt: greatest tilt [rad].
        seed: seed of the phases.
    """

    heave: float = 0.0026
    tilt: float = math.radians(1.0)
    seed: int = 0

    def motion_at(self, time: float) -> NDArray[np.float64]:
        """Return heave [m], roll and pitch [rad] at a time [s], shape (3,)."""
        phases = np.random.default_rng(self.seed).uniform(0.0, math.tau, (3, len(_FREQUENCIES)))
        oscillation = np.sin(math.tau * np.array(_FREQUENCIES) * time + phases).mean(axis=1)
        return np.asarray(oscillation * (self.heave, self.tilt / math.sqrt(2.0), self.tilt / math.sqrt(2.0)))

    def mount_at(self, time: float, mount_at_rest: CameraMount) -> CameraMount:
        """Return where the camera is at a time [s], given its pose in ``base_link``: see ``apply_body_motion``.

        The body turns about ``base_link``, whose place and heading on the floor are the robot's pose; so a
        camera that looks straight down at ``base_link`` keeps looking there.
        """
        return apply_body_motion(mount_at_rest, *(float(part) for part in self.motion_at(time)))


def apply_body_motion(mount_at_rest: CameraMount, heave: float, roll: float, pitch: float) -> CameraMount:
    """Return where the camera is when the body has heaved [m] and turned [rad] about ``base_link``, pitch after roll.

    The returned pose is in the frame of the floor under ``base_link``: upright, with the robot's heading.
    """
    turn = matrix_from_rpy((roll, pitch, 0.0))
    x, y, z = turn @ mount_at_rest.xyz + (0.0, 0.0, heave)
    rpy = Rotation.from_matrix(turn @ mount_at_rest.rotation).as_euler('xyz')
    return CameraMount((float(x), float(y), float(z)), (float(rpy[0]), float(rpy[1]), float(rpy[2])))


@dataclass(frozen=True)
class TiltErrors:
    """Errors of roll and pitch.

    Attributes:
        bias: standard deviation of the constant error of each axis, drawn once a run [rad].
        noise: standard deviation of a reading [rad].
    """

    bias: float = math.radians(0.05)
    noise: float = math.radians(0.03)


@dataclass(frozen=True)
class TiltReading:
    """A reading of the inertial unit.

    Attributes:
        time: [s].
        roll: fixed-axis roll of the body [rad].
        pitch: fixed-axis pitch of the body [rad].
    """

    time: float
    roll: float
    pitch: float


def simulate_tilt(
    tilt_at: Callable[[float], tuple[float, float]],
    times: Sequence[float],
    errors: TiltErrors,
    rng: np.random.Generator,
) -> list[TiltReading]:
    """Return readings of the tilt.

    Args:
        tilt_at: gives the true roll and pitch at a time [s].
        times: when the unit is read [s].
        errors: its errors.
        rng: source of bias and noise.
    """
    bias = errors.bias * rng.standard_normal(2)
    true = np.array([tilt_at(time) for time in times]).reshape(-1, 2)
    read = true + bias + errors.noise * rng.standard_normal(true.shape)
    return [TiltReading(time, float(roll), float(pitch)) for time, (roll, pitch) in zip(times, read, strict=True)]
