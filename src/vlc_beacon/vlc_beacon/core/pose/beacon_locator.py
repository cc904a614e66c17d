"""The method ``centroid``: least squares for x, y, z and yaw on the centres of lamps at known positions.

Two lamps and the quadratic equation of `closed_form` give the initial state, all lamps the pose. If they are
inconsistent, the pose with the largest consensus set is used and the outliers are classified.
"""

import cmath
import math
from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import chdtri

from shirube_core.geometry import SE3, CameraMount, PinholeCamera, gravity_aligned_camera
from vlc_beacon.core.pose.consensus import (
    SAME_POSE_TOLERANCE,
    classify_anomalies,
    find_consensus_sets,
    select_consensus_set,
    unclassified_anomalies,
)
from vlc_beacon.core.pose.lamp_rays import Beacon, LampRays, lamp_rays
from vlc_beacon.core.pose.pose_fix import BeaconAnomaly, BeaconFix, ExpectedPose, NoBeaconFix, NoFixReason
from vlc_beacon.core.pose.pose_least_squares import STATES, PoseEstimate, PoseLeastSquares
from vlc_beacon.core.settings import PoseSettings

SLOPE_MAX = 20.0
"""Maximum slope; lamps within 3 degrees of the horizon do not determine the height."""


class TwoLampSolver:
    """The lamps of one image as complex numbers."""

    def __init__(
        self, rays: LampRays, lamps: NDArray[np.float64], camera: SE3, known_height: float | None = None
    ) -> None:
        """Set the observations; arguments as in `PoseLeastSquares`."""
        self._known_height = known_height
        self._positions = lamps[:, 0] + 1j * lamps[:, 1]
        directions = np.column_stack([rays.rays, np.ones(len(rays))]) @ camera.rotation.T
        upward = directions[:, 2]
        flat = np.hypot(directions[:, 0], directions[:, 1])
        self._usable = np.abs(upward) * SLOPE_MAX > flat
        slopes = (directions[:, 0] + 1j * directions[:, 1]) / np.where(self._usable, upward, 1.0)
        turns = np.exp(1j * rays.motions[:, 2])
        camera_offset = complex(camera.position[0], camera.position[1])
        height_offset = lamps[:, 2] - camera.position[2]
        self._A = rays.motions[:, 0] + 1j * rays.motions[:, 1] + turns * (camera_offset + height_offset * slopes)
        self._B = turns * slopes

    def widest_pairs(self, count: int) -> list[tuple[int, int]]:
        """Return up to ``count`` pairs of different lamps, those with the largest separation first."""
        first, second = np.triu_indices(len(self._B), 1)
        valid = self._usable[first] & self._usable[second] & (self._positions[first] != self._positions[second])
        first, second = first[valid], second[valid]
        order = np.argsort(-np.abs(self._B[first] - self._B[second]), kind='stable')[:count]
        return [(int(first[k]), int(second[k])) for k in order]

    def solve_pair(self, i: int, j: int) -> list[NDArray[np.float64]]:
        """Return the states consistent with two lamps, each of shape (6,); none, one or two."""
        baseline = complex(self._positions[i] - self._positions[j])
        D, E = complex(self._A[i] - self._A[j]), complex(self._B[i] - self._B[j])
        if abs(E) < 1e-9:
            return []
        states = []
        for z in self._heights(baseline, D, E):
            seen = D - z * E
            if abs(seen) > 0.0:
                k = baseline / seen
                states.append(self._state(k / abs(k), z, [i, j]))
        return states

    def _heights(self, baseline: complex, D: complex, E: complex) -> list[float]:
        if self._known_height is not None:
            return [self._known_height]
        middle = (D * E.conjugate()).real / abs(E) ** 2
        # Noise can make the discriminant negative where both solutions coincide.
        squared = middle**2 - (abs(D) ** 2 - abs(baseline) ** 2) / abs(E) ** 2
        height_offset = math.sqrt(max(squared, 0.0))
        return [middle - height_offset, middle + height_offset] if height_offset > 0.0 else [middle]

    def _state(self, k: complex, z: float, indices: list[int]) -> NDArray[np.float64]:
        position = complex(np.mean(self._positions[indices] - k * (self._A[indices] - z * self._B[indices])))
        state = np.zeros(STATES)
        state[:4] = position.real, position.imag, z, cmath.phase(k)
        return state


GATE_PROBABILITY = 1e-6
"""Probability of rejecting consistent lamps."""
START_PAIRS, PAIRS_MAX = 4, 66
"""Number of tested lamp pairs if all lamps are consistent, and otherwise (all pairs of 12 lamps)."""
EXPECTED_SIGMAS = 5.0


class BeaconLocator:
    """Computes the robot's pose from known lamps."""

    def __init__(
        self,
        beacons: Iterable[Beacon],
        mount: CameraMount,
        known_height: float | None = None,
        settings: PoseSettings | None = None,
    ) -> None:
        """Set the known quantities.

        Args:
            beacons: known lamps, each ID once.
            mount: pose of the camera on the robot.
            known_height: height of the base in the map frame [m], None if it is estimated.
            settings: noise settings, None for the defaults.
        """
        self.beacons = {beacon.id: beacon for beacon in beacons}
        self._mount = mount
        self._known_height = known_height
        self._unknowns = 4 if known_height is None else 3
        self._settings = settings or PoseSettings()

    def rays(
        self,
        camera: PinholeCamera,
        ids: ArrayLike,
        pixels: ArrayLike,
        sigmas: ArrayLike,
        motions: ArrayLike | None = None,
    ) -> LampRays:
        """Return the rays of the known lamps where the lens model is valid; arguments as in `lamp_rays`."""
        rays = lamp_rays(camera, ids, pixels, sigmas, motions)
        return rays.subset(np.isin(rays.ids, list(self.beacons)) & rays.is_valid)

    def locate(
        self, rays: LampRays, tilt: tuple[float, float] = (0.0, 0.0), expected: ExpectedPose | None = None
    ) -> BeaconFix | NoBeaconFix:
        """Compute the pose.

        Args:
            rays: rays to known lamps, see `rays`.
            tilt: roll and pitch of the robot [rad].
            expected: expected pose: it resolves ambiguities, and a pose from the minimum number of lamps must be
                consistent with it.
        """
        if len(rays) == 0:
            return NoBeaconFix(NoFixReason.NO_LAMP, 'no lamp of the file is in view')
        if len(set(rays.ids.tolist())) < 2:
            anomalies = unclassified_anomalies(rays) if rays.is_duplicate.any() else ()
            return NoBeaconFix(NoFixReason.TOO_FEW_LAMPS, f'only lamp {rays.ids[0]} is in view', anomalies)
        camera = gravity_aligned_camera(self._mount, *tilt)
        lamps = np.array([self.beacons[int(id_)].xyz for id_ in rays.ids])
        problem = PoseLeastSquares(rays, lamps, camera, self._known_height, self._settings)
        solver = TwoLampSolver(rays, lamps, camera, self._known_height)
        # Poses that explain all lamps; normally there is one.
        fits = [] if rays.is_duplicate.any() else self._fit_all(problem, solver)
        if fits:
            return self._choose_fit(rays, fits, expected)
        # Otherwise the pose that explains most lamps; the others moved, were swapped or are duplicates.
        if not solver.widest_pairs(1):
            return NoBeaconFix(NoFixReason.POOR_GEOMETRY, _lamp_names(rays))
        lamp_positions = np.array([beacon.xyz for beacon in self.beacons.values()])
        starts, gate = _initial_states(solver, PAIRS_MAX), self._settings.gate_sigmas
        consensus_sets = find_consensus_sets(problem, starts, lamp_positions, camera, gate)
        chosen = select_consensus_set(consensus_sets, self._unknowns, expected, EXPECTED_SIGMAS)
        if chosen is None:
            several = len(consensus_sets) > 1 and consensus_sets[0].swapped.any()
            reason = NoFixReason.AMBIGUOUS if several else NoFixReason.INCONSISTENT
            return NoBeaconFix(reason, _lamp_names(rays), unclassified_anomalies(rays))
        anomalies = classify_anomalies(rays, chosen, list(self.beacons))
        return _make_fix(chosen.fit, chosen.inliers, anomalies)

    def _fit_all(self, problem: PoseLeastSquares, solver: TwoLampSolver) -> list[PoseEstimate]:
        """Return the distinct poses that explain all lamps."""
        used = np.ones(len(problem.rays), dtype=np.bool_)
        fits: list[PoseEstimate] = []
        for initial_state in _initial_states(solver, START_PAIRS):
            fit = problem.refine(initial_state, used)
            if (
                fit is not None
                and self._passes_chi_square(fit)
                and not any(fit.is_within(SAME_POSE_TOLERANCE, known) for known in fits)
            ):
                fits.append(fit)
            if fits and 2 * len(used) > self._unknowns + 1:
                break
        return fits

    def _passes_chi_square(self, fit: PoseEstimate) -> bool:
        """Return whether the residuals of a fit to all lamps pass the chi-square test."""
        if not fit.in_front.all():
            return False
        gate = chdtri(max(fit.residuals.size - self._unknowns, 1), GATE_PROBABILITY)
        sigma = self._settings.tilt_sigma
        tilt = fit.state[4:] / sigma if sigma > 0.0 else np.zeros(2)
        return bool(np.sum(fit.residuals**2) + np.sum(tilt**2) < gate)

    def _choose_fit(
        self, rays: LampRays, fits: list[PoseEstimate], expected: ExpectedPose | None
    ) -> BeaconFix | NoBeaconFix:
        """Return the pose that is consistent with the expected one."""
        if len(fits) > 1 and expected is not None:
            fits = [fit for fit in fits if fit.mahalanobis_distance_to(expected) < EXPECTED_SIGMAS] or fits
        if len(fits) > 1:
            return NoBeaconFix(NoFixReason.AMBIGUOUS, f'{len(fits)} poses explain {_lamp_names(rays)}')
        # The residuals of a minimal number of lamps do not show a wrong one.
        if 2 * len(rays) <= self._unknowns and expected is not None:
            distance = fits[0].mahalanobis_distance_to(expected)
            if distance > EXPECTED_SIGMAS:
                detail = f'{distance:.0f} standard deviations away by {_lamp_names(rays)}'
                return NoBeaconFix(NoFixReason.UNEXPECTED, detail, unclassified_anomalies(rays))
        return _make_fix(fits[0], np.ones(len(rays), dtype=np.bool_))


def _make_fix(fit: PoseEstimate, used: NDArray[np.bool_], anomalies: tuple[BeaconAnomaly, ...] = ()) -> BeaconFix:
    tilt = float(fit.state[4]), float(fit.state[5])
    height, covariance = float(fit.state[2]), fit.covariance[:4, :4]
    return BeaconFix(fit.pose, height, covariance, tilt, used, fit.residuals, anomalies)


def _lamp_names(rays: LampRays) -> str:
    return 'lamps ' + ', '.join(str(id_) for id_ in sorted(rays.ids.tolist()))


def _initial_states(solver: TwoLampSolver, pairs: int) -> Iterator[NDArray[np.float64]]:
    """Yield initial states from the widest pairs."""
    for pair in solver.widest_pairs(pairs):
        yield from solver.solve_pair(*pair)
