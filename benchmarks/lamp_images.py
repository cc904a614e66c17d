"""Poses from rendered images of lamps and of printed markers (ArUco, AprilTag) in their places, with bounds.

Four kinds of light and a camera that moves: what is found, how far centres and poses are off, and how near the lamps'
errors are to the Cramér-Rao bound. Methods other than least squares are compared by `lamp_pose`.
"""

from __future__ import annotations

import math

import numpy as np
from _figures import error, mean, rate, rms
from _harness import Option, Run, progress, run_benchmark, use_one_core
from _lamp_finders import LAMPS, Found, finders, locate_by_centres
from _lamp_pictures import LIGHTS, centre_sigma_bound
from _lamp_room import IDS, View, cramer_rao_bound, random_views
from numpy.typing import NDArray

Seen = list[tuple[View, Found]]


def main(run: Run, images: int) -> None:
    """Find lamps and markers in images of the same views."""
    use_one_core()
    views = [v for v in random_views(30 * images, np.random.default_rng(run.seed)) if v.visible.sum() >= 2][
        :images
    ]
    heads: tuple[str, ...] = 'found', 'false', 'centre px: rms', 'poses', 'cm: median / 95 % / max'
    table = run.table('Lamps and markers', 'light', 'what', *heads)
    heads = 'centre px: stated', 'least', 'rms / bound of the stated', 'rms / bound of the measured'
    bounds = run.table('Comparison with the bound', 'light', *heads)
    for light in progress(LIGHTS):
        for name, finder in finders(run).items():
            rng = np.random.default_rng(run.seed)
            seen = [(view, finder.find(view, light, rng)) for view in views]
            offsets = np.concatenate([found.centres - view.pixels[found.ids - 1] for view, found in seen])
            errors = np.array([position_error(*each) for each in seen])
            shown = sum(int(view.visible.sum()) for view in views)
            table.add(
                *(light.name, name, rate(len(offsets), shown)),
                rate(sum(found.false for _, found in seen), shown, 'lower'),
                *(
                    rms(offsets),
                    rate(int(np.isfinite(errors).sum()), len(views)),
                    error(errors, '.3f', 100.0),
                ),
            )
            if name == LAMPS:
                stated = np.concatenate([found.sigmas for _, found in seen])
                posed = [each for each, off in zip(seen, errors, strict=True) if np.isfinite(off)]
                measured = np.sqrt(np.mean(offsets**2, axis=0))
                bounds.add(
                    *(light.name, mean(stated, '.4f'), f'{centre_sigma_bound(light):.4f}'),
                    *(rms(errors / rms_bound(posed, noise), better='') for noise in (None, measured)),
                )


def position_error(view: View, found: Found) -> float:
    """Return the error of the pose by least squares of the centres [m], NaN where there is none."""
    place = locate_by_centres(found)
    return math.nan if place is None else math.hypot(place[0] - view.pose.x, place[1] - view.pose.y)


def rms_bound(seen: Seen, noise: NDArray[np.float64] | None) -> float:
    """Return the bound of the position [m], root mean square over views.

    Args:
        seen: lamps with poses.
        noise: shape (2,), of all centres along u and v, None for what the detector states [px].
    """
    squares = []
    for view, found in seen:
        sigmas = np.ones((4, 2)) if noise is None else np.broadcast_to(noise, (4, 2))
        if noise is None:
            sigmas[found.ids - 1] = found.sigmas[:, None]
        only_found = View(view.pose, view.pixels, np.isin(IDS, found.ids))
        squares.append(cramer_rao_bound(only_found, sigmas, height_known=False))
    return math.sqrt(np.mean(squares))


if __name__ == '__main__':
    run_benchmark(main, images=Option(100, 8, 'of each light and each kind'))
