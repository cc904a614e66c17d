"""Poses from rendered images of lamps and of printed markers (ArUco, AprilTag) in their places.

Four kinds of light and a camera that moves: what is found, and how far centres and poses are off. Methods other than
least squares, and the Cramér-Rao bound, are the matter of `lamp_pose`.
"""

import numpy as np
from _figures import error, rate, rms
from _harness import Option, Run, progress, run_benchmark, use_one_core
from _lamp_finders import finders, position_error
from _lamp_pictures import LIGHTS
from _lamp_room import random_views


def main(run: Run, images: int) -> None:
    """Find lamps and markers in images of the same views."""
    use_one_core()
    views = [v for v in random_views(30 * images, np.random.default_rng(run.seed)) if v.visible.sum() >= 2][:images]
    heads = 'found', 'false', 'centre px: rms', 'poses', 'cm: median / 95 % / max'
    table = run.table('Lamps and markers', 'light', 'what', *heads)
    for light in progress(LIGHTS):
        for name, find in finders(run).items():
            rng = np.random.default_rng(run.seed)
            seen = [(view, find(view, light, rng)) for view in views]
            offsets = np.concatenate([found.centres - view.pixels[found.ids - 1] for view, found in seen])
            errors = np.array([position_error(*each) for each in seen])
            shown = sum(int(view.visible.sum()) for view in views)
            table.add(
                *(light.name, name, rate(len(offsets), shown)),
                rate(sum(found.false for _, found in seen), shown, 'lower'),
                *(rms(offsets), rate(int(np.isfinite(errors).sum()), len(views)), error(errors, '.3f', 100.0)),
            )


if __name__ == '__main__':
    run_benchmark(main, images=Option(100, 4, 'of each light and each kind'))
