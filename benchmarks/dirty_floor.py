"""A floor that was mapped clean, with all its chips, and is located dirty, with larger minimum sizes of dots.

So the paper explains its missing dots (3.2.2): small chips are on the map, but the filter against dirt removes them
from the image. Rendered images of chips of 1 to 3 mm through the detector; rates are relative to the chips in view.
"""

from dataclasses import replace

import numpy as np
from _figures import outcomes, rate
from _floor_photographs import CAMERA, MOUNT, SurveyedFloor
from _harness import Option, Run, progress, run_benchmark
from _pose_scores import score_pose
from scipy.spatial import cKDTree

from floor_localizer.core.dot_extraction.detector import DotDetector
from floor_localizer.core.settings import DotDetectorSettings
from scene_simulator.floor.camera import FloorCamera
from scene_simulator.floor.disturbances import FloorArea, crumbs, dust, hairs
from scene_simulator.floor.dot_floor import DARK_ON_LIGHT

DESIGN = replace(DARK_ON_LIGHT, diameters=(0.001, 0.003))
LITTER = (crumbs, 1000.0), (dust, 5000.0), (hairs, 200.0)  # dirt and its density for a level of 1 [1/m^2]
SMALLEST = (3.0, 4.0, 5.0, 6.0)  # minimum diameters [px]; a pixel is 0.38 mm
POLE_STAR_EVERY = 5  # places of which the pole star, which takes a second for each, is run at one


def main(run: Run, places: int, dirt: tuple[float, ...]) -> None:
    """Locate images for each level of dirt and each minimum diameter."""
    surveyed, camera = SurveyedFloor(DESIGN), FloorCamera(CAMERA)
    matchers = {name: surveyed.localizer_by(name) for name in ('constellation', 'pole_star')}
    heads = 'dirt | minimum diameter px | missing % | spurious % | right / none / wrong'
    table = run.table('Mapped clean, located dirty', heads, 'pole star: right / none / wrong')
    for level in dirt:
        verdicts: dict[tuple[float, str], list[str]] = {}
        counts = {smallest: np.zeros(3, dtype=np.int64) for smallest in SMALLEST}
        for number, pose in enumerate(progress(surveyed.places(places), f'dirt {level}', places)):
            area = FloorArea((pose.x - 0.1, pose.y - 0.1), (pose.x + 0.1, pose.y + 0.1))
            strewn = [litter(area, level * density, number + 1) for litter, density in LITTER]
            rng = np.random.default_rng([run.seed, number])
            image = camera.photograph(surveyed.floor, [pose], MOUNT, strewn, rng).image
            chips, pixels = camera.visible_chips(surveyed.floor, pose, MOUNT)
            radii = np.asarray(0.5 * surveyed.floor.diameters[chips] * CAMERA.fx / MOUNT.xyz[2])
            for smallest in SMALLEST:
                found = DotDetector(DotDetectorSettings(minimum_diameter=smallest)).detect(image)
                distances, nearest = map(np.asarray, cKDTree(pixels).query(found.pixels))
                seen = len(np.unique(nearest[distances < radii[nearest]]))
                counts[smallest] += len(pixels), len(pixels) - seen, len(found) - seen
                for name, localizer in matchers.items():
                    if name == 'constellation' or number % POLE_STAR_EVERY == 0:
                        score = score_pose(localizer.locate_dots(found, CAMERA), pose)
                        verdicts.setdefault((smallest, name), []).append(score.verdict)
        for smallest, count in counts.items():
            in_view, missing, spurious = (int(each) for each in count)
            table.add(
                *(f'x{level:g}', f'{smallest:g}', rate(missing, in_view, '', form='percent')),
                rate(spurious, in_view, '', form='percent'),
                *(outcomes(verdicts[smallest, name]) for name in matchers),
            )


if __name__ == '__main__':
    run_benchmark(
        main,
        places=Option(100, 5, 'images of each level of dirt'),
        dirt=Option((0.0, 1.0, 4.0), (1.0,), 'levels of dirt'),
    )
