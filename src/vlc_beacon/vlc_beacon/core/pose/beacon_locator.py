"""The method ``centroid``: least squares for x, y, z and yaw on the centres of lamps at known positions.

Two lamps and the quadratic equation of `closed_form` give the initial state, all lamps the pose. If they are
inconsistent, the pose with the largest consensus set is used and the outliers are classified.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import chdtri

from shirube_geometry import CameraMount, LevelCamera, PinholeCamera, level_camera
from vlc_beacon.core.pose.agreement import SAME_WITHIN, Agreement, best_agreements, chosen_agreement
from vlc_beacon.core.pose.beacon import Beacon
from vlc_beacon.core.pose.closed_form import ClosedForm
from vlc_beacon.core.pose.doubts import named_doubts, unclear_doubts
from vlc_beacon.core.pose.known_states import KnownStates
from vlc_beacon.core.pose.lamp_rays import LampRays, lamp_rays
from vlc_beacon.core.pose.pose_fix import BeaconDoubt, BeaconFix, ExpectedPose, NoBeaconFix, NoFixReason
from vlc_beacon.core.pose.pose_least_squares import PoseEstimate, PoseLeastSquares
from vlc_beacon.core.pose.settings import PoseSettings

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
        known: KnownStates | None = None,
        settings: PoseSettings | None = None,
    ) -> None:
        """Set the known quantities.

        Args:
            beacons: known lamps, each ID once.
            mount: pose of the camera on the robot.
            known: known components of the pose, None for none.
            settings: noise settings, None for the defaults.
        """
        self.beacons = {beacon.id: beacon for beacon in beacons}
        self._mount = mount
        self._known = known or KnownStates()
        self._settings = settings or PoseSettings()

    def rays(
        self,
        camera: PinholeCamera,
        ids: ArrayLike,
        pixels: ArrayLike,
        sigmas: ArrayLike,
        motions: ArrayLike | None = None,
    ) -> LampRays:
        """Return the rays of the known lamps; arguments as in `lamp_rays`."""
        rays = lamp_rays(camera, ids, pixels, sigmas, motions)
        return rays.subset(np.isin(rays.ids, list(self.beacons)))

    def locate(
        self,
        rays: LampRays,
        tilt: tuple[float, float] = (0.0, 0.0),
        expected: ExpectedPose | None = None,
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
        camera = level_camera(self._mount, *tilt)
        lamps = np.array([self.beacons[int(id_)].xyz for id_ in rays.ids])
        squares = PoseLeastSquares(rays, lamps, camera, self._known, self._settings)
        closed = ClosedForm(rays, lamps, camera, self._known)
        if len(set(rays.ids.tolist())) < 2:
            doubts = unclear_doubts(rays) if rays.copied.any() else ()
            return NoBeaconFix(NoFixReason.TOO_FEW_LAMPS, f'only lamp {rays.ids[0]} is in view', doubts)
        all_fit = self._all_together(squares, closed, expected)
        if all_fit is not None:
            return all_fit
        return self._majority(squares, closed, camera, expected)

    def _all_together(
        self, squares: PoseLeastSquares, closed: ClosedForm, expected: ExpectedPose | None
    ) -> BeaconFix | NoBeaconFix | None:
        """Return the result if one pose explains all lamps, None otherwise."""
        rays = squares.rays
        if rays.copied.any():
            return None
        used = np.ones(len(rays), dtype=np.bool_)
        fits: list[PoseEstimate] = []
        for start in _starts(closed, START_PAIRS):
            fit = squares.refine(start, used)
            if (
                fit is not None
                and self._explains(fit)
                and not any(fit.is_within(SAME_WITHIN, known) for known in fits)
            ):
                fits.append(fit)
            if fits and 2 * len(rays) > self._known.unknowns + 1:
                break
        if not fits:
            return None
        if len(fits) > 1 and expected is not None:
            fits = [fit for fit in fits if fit.distance_from(expected) < EXPECTED_SIGMAS] or fits
        if len(fits) > 1:
            return NoBeaconFix(NoFixReason.AMBIGUOUS, f'{len(fits)} poses explain {_names(rays)}')
        alone = 2 * len(rays) <= self._known.unknowns
        if alone and expected is not None and fits[0].distance_from(expected) > EXPECTED_SIGMAS:
            detail = f'{fits[0].distance_from(expected):.0f} standard deviations away by {_names(rays)}'
            return NoBeaconFix(NoFixReason.UNEXPECTED, detail, unclear_doubts(rays))
        return _fix(fits[0], used)

    def _explains(self, fit: PoseEstimate) -> bool:
        """Return whether the residuals of a fit to all lamps pass the chi-square test."""
        if not fit.in_front.all():
            return False
        freedom = fit.residuals.size - self._known.unknowns
        gate = chdtri(max(freedom, 1), GATE_PROBABILITY)
        return bool(np.sum(fit.residuals**2) + np.sum(self._tilt_sigmas(fit) ** 2) < gate)

    def _tilt_sigmas(self, fit: PoseEstimate) -> NDArray[np.float64]:
        sigma = self._settings.tilt_sigma
        return fit.state[4:] / sigma if sigma > 0.0 else np.zeros(2)

    def _majority(
        self,
        squares: PoseLeastSquares,
        closed: ClosedForm,
        camera: LevelCamera,
        expected: ExpectedPose | None,
    ) -> BeaconFix | NoBeaconFix:
        """Return the pose with the largest consensus set, and classify the outliers."""
        rays, gate = squares.rays, self._settings.gate_sigmas
        if not closed.widest_pairs(1):
            return NoBeaconFix(NoFixReason.POOR_GEOMETRY, _names(rays))
        places = np.array([beacon.xyz for beacon in self.beacons.values()])
        starts = _starts(closed, PAIRS_MAX)
        agreements = best_agreements(squares, starts, places, camera, gate)
        chosen = chosen_agreement(agreements, self._known.unknowns, expected, EXPECTED_SIGMAS)
        if chosen is None:
            several = len(agreements) > 1 and agreements[0].swapped.any()
            reason = NoFixReason.AMBIGUOUS if several else NoFixReason.INCONSISTENT
            return NoBeaconFix(reason, _names(rays), unclear_doubts(rays))
        return self._fix_of_majority(squares, chosen, camera)

    def _fix_of_majority(
        self, squares: PoseLeastSquares, chosen: Agreement, camera: LevelCamera
    ) -> BeaconFix:
        doubts = named_doubts(squares.rays, chosen, list(self.beacons.values()), camera)
        return _fix(chosen.fit, chosen.own, doubts)


def _fix(fit: PoseEstimate, used: NDArray[np.bool_], doubts: tuple[BeaconDoubt, ...] = ()) -> BeaconFix:
    return BeaconFix(
        fit.pose,
        float(fit.state[2]),
        fit.covariance[:4, :4],
        (float(fit.state[4]), float(fit.state[5])),
        used,
        fit.residuals,
        doubts,
    )


def _names(rays: LampRays) -> str:
    return 'lamps ' + ', '.join(str(id_) for id_ in sorted(rays.ids.tolist()))


def _starts(closed: ClosedForm, pairs: int) -> Iterator[NDArray[np.float64]]:
    """Yield initial states from the widest pairs."""
    for pair in closed.widest_pairs(pairs):
        yield from closed.states_of_pair(*pair)
