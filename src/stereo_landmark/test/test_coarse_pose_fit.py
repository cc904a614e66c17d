import numpy as np
import pytest
from place_scenes import RIG, panel, random_state, teach, view

from stereo_landmark.core.place.joint_fit import fit_reprojection
from stereo_landmark.core.procedure.coarse_pose import DETECTED_SIGMA, fit_coarse_pose
from stereo_landmark.core.procedure.stereo_view import StereoView
from stereo_landmark.core.settings import PlaceSettings
from stereo_landmark.core.stereo import StereoPoints

VIEW = StereoView(None, None, RIG)
KNOWN_TILT = PlaceSettings(pixel_sigma=0.0, tilt_sigma=0.0)


@pytest.mark.parametrize('outliers', [0, 2])
def test_it_fits_as_the_fit_of_the_displacement_does(outliers):
    """A second, independent implementation gives the same pose, also with outliers."""
    rng = np.random.default_rng(outliers)
    for seed in range(10):
        points, state = panel(count=8, seed=seed), random_state(rng)
        taught = teach(points, 0.3, rng)
        seen = view(points, state, DETECTED_SIGMA, rng)
        seen.pixels[:outliers] += 20.0
        noise = np.tile(DETECTED_SIGMA**2 * np.eye(4), (len(points), 1, 1))
        weighted = StereoPoints(seen.names, seen.pixels, noise)
        expected = fit_reprojection(weighted, taught, RIG, np.zeros(6), KNOWN_TILT)
        found = fit_coarse_pose(np.zeros(4), taught.positions, taught.covariances, seen.pixels, VIEW)
        assert found == pytest.approx(expected.state[:4], abs=1e-5)


def test_one_point_or_one_position_determines_no_pose():
    points = np.repeat(panel(count=1), 3, axis=0)
    seen = view(points, np.zeros(6)).pixels
    nothing = np.zeros((3, 3, 3))
    assert fit_coarse_pose(np.zeros(4), points[:1], nothing[:1], seen[:1], VIEW) is None
    assert fit_coarse_pose(np.zeros(4), points, nothing, seen, VIEW) is None
