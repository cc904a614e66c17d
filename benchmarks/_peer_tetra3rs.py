"""The star solver tetra3rs on a floor: its dots become stars on a strip of sky along the equator.

A view of 90 mm is a field of one degree, so that the paper's floor is a strip of 105 by 20 degrees. The right scale is
given (to one per cent, as the strip is not quite flat) and tilt is none: the solver searches neither. Its pattern
database is built for this field and density.
"""

import math
import struct
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from _paper_views import CAMERA, MOUNT, PaperView
from numpy.typing import NDArray

from shirube_core.geometry import SE2, wrap_angle

# Degrees of a field of view, and the sky's longitude of the floor's origin.
FIELD, ORIGIN = 1.0, 100.0
MAGNITUDES = (1.0, 8.0)
SCALE_ERROR = 0.01
DEGREES_PER_METRE = FIELD / (CAMERA.width / CAMERA.fx * MOUNT.xyz[2])
# Best of the settings tried, see BENCHMARK.md: more patterns find more and take no longer.
DATABASE = {
    'pattern_max_error': 0.005,
    'lattice_field_oversampling': 100,
    'patterns_per_lattice_field': 200,
    'max_fov_deg': FIELD,
    'star_max_magnitude': MAGNITUDES[1] + 1.0,
    'verification_stars_per_fov': 150,
    'epoch_proper_motion_year': None,
    'catalog_nside': 64,
}
SOLVER = {
    'match_radius': 0.01,
    'pattern_checking_stars': 24,
    'solve_timeout_ms': 1000,
    'fov_estimate_deg': FIELD,
    'fov_max_error_deg': SCALE_ERROR * FIELD,
    'image_width': CAMERA.width,
    'image_height': CAMERA.height,
}
_STAR = np.dtype([('id', '<i8'), ('ra', '<f8'), ('dec', '<f8'), ('mag', '<f4'), ('pm_ra', '<f4'), ('pm_dec', '<f4')])


class StarSolver:
    """Locates views of one floor."""

    def __init__(self, tetra3rs: Any, floor: NDArray[np.float64], seed: int) -> None:
        """Build the database of a floor's dots, shape (N, 2) [m]; the magnitudes are uniformly distributed."""
        self._middle = float(floor[:, 0].max()) / 2.0
        self._magnitudes = np.random.default_rng([seed, 1]).uniform(*MAGNITUDES, len(floor))
        stars = np.zeros(len(floor), dtype=_STAR)
        stars['id'] = np.arange(1, len(floor) + 1)
        stars['ra'] = ORIGIN + floor[:, 1] * DEGREES_PER_METRE
        stars['dec'] = (floor[:, 0] - self._middle) * DEGREES_PER_METRE
        stars['mag'] = self._magnitudes
        with tempfile.TemporaryDirectory() as folder:
            catalogue = Path(folder) / 'floor.bin'
            catalogue.write_bytes(b'GDR3' + struct.pack('<IQ', 1, len(stars)) + stars.tobytes())
            self._database = tetra3rs.SolverDatabase.generate_from_gaia(str(catalogue), **DATABASE)
            saved = Path(folder) / 'floor.database'
            self._database.save_to_file(str(saved))
            self.database_bytes = saved.stat().st_size

    def centroids(self, view: PaperView, *, with_sizes: bool) -> NDArray[np.float64]:
        """Return a view as the solver takes it: x, y from the middle [px] and brightness, shape (n, 3).

        A dot is exactly as bright as on the map, or of random brightness without sizes.
        """
        # A view's own random numbers: the same whenever it is asked for.
        rng = np.random.default_rng(len(view.pixels))
        magnitudes = rng.uniform(*MAGNITUDES, len(view.pixels))
        if with_sizes:
            magnitudes = np.where(view.map_dots >= 0, self._magnitudes[view.map_dots], magnitudes)
        return np.column_stack([view.pixels - (CAMERA.cx, CAMERA.cy), 10.0 ** (-0.4 * magnitudes)])

    def locate(self, centroids: NDArray[np.float64]) -> SE2 | None:
        """Return the pose of the view, whose origin is the middle of the image."""
        found = self._database.solve_from_centroids(centroids, **SOLVER)
        if not found:
            return None
        x = self._middle + found.dec_deg / DEGREES_PER_METRE
        y = (found.ra_deg - ORIGIN) / DEGREES_PER_METRE
        return SE2(x, y, wrap_angle(math.radians(found.roll_deg + 180.0)))
