"""Coming back under hard conditions: part of the target hidden, other light, blur, noise, a person, a landmark moved.

Corridors are taught once; peers are ORB and SIFT with stereo and PnP, taught with the same pair. Right is within 5 cm
and 1.5 degrees.
"""

import math
from collections import defaultdict
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from typing import NamedTuple

import numpy as np
from _harness import Option, Run, progress, run_benchmark, use_one_core
from _landmark_corridor import TAUGHT, TaughtCorridor, teach_corridor
from _pose_scores import PoseScore, pose_cells, score_found
from _stereo_peers import FeaturePipeline
from _stereo_scenes import CAMERAS, RIG, Pair, displacement_of, random_offset

from scene_simulator.corridor.generator import CorridorDesign, corridor
from scene_simulator.corridor.scene import CorridorScene, Person
from scene_simulator.corridor.shapes import facing_wall
from scene_simulator.corridor.stereo_rig import StereoCamera, StereoOptics, render_pair
from shirube_core.geometry import SE2
from stereo_landmark.core.landmark_localizer import LandmarkLocalizer
from stereo_landmark.core.settings import PAPER, LandmarkSettings

HIDDEN_FRACTION = 0.3  # part of the target's primitives that is covered
OFFSET_MAX, YAW_MAX = 0.4, math.radians(10.0)
RIGHT_WITHIN = 0.05, math.radians(1.5)
OURS, PAPER_MODE = 'stereo_landmark', 'stereo_landmark, paper mode'

Changed = Callable[[CorridorScene, TaughtCorridor, np.random.Generator], CorridorScene]


class Condition(NamedTuple):
    """What is otherwise than when the place was taught: the corridor, the optics, factors of gain and of noise."""

    name: str
    scene: Changed = lambda scene, taught, rng: scene  # noqa: ARG005
    optics: StereoOptics = StereoOptics()
    gain: float = 1.0
    noise: float = 1.0

    def camera(self, camera: StereoCamera) -> StereoCamera:
        """Return a camera as it is now."""
        usual, noise = camera.sensor, self.noise
        light = replace(usual, full_well=usual.full_well / noise**2, read_noise=usual.read_noise / noise)
        return replace(camera, optics=self.optics, sensor=replace(light, gain=self.gain * usual.gain))


def hide_landmarks(scene: CorridorScene, taught: TaughtCorridor, rng: np.random.Generator) -> CorridorScene:
    """Cover part of the target, chosen at random; not the cabinet as a whole, for its fields are half of the target."""
    names = [part.name.replace(' ', '/') for part in taught.place.targets[0].primitives]
    alone = [name for name in names if not any(other.startswith(f'{name}/') for other in names)]
    for name in rng.permutation(alone)[: round(HIDDEN_FRACTION * len(names))]:
        scene = scene.cover_landmark(str(name))
    return scene


def add_person(scene: CorridorScene, _: TaughtCorridor, rng: np.random.Generator) -> CorridorScene:
    """Put somebody before the wall."""
    side, away = rng.uniform(-0.7, 0.7), rng.uniform(0.5, 1.5)
    return scene.with_objects([Person('passer_by', facing_wall(-away), (float(side), 0.0))])


def move_object(scene: CorridorScene, _: TaughtCorridor, rng: np.random.Generator) -> CorridorScene:
    """Hang the round sign elsewhere."""
    return scene.move_object('round_sign', float(rng.choice([-0.2, 0.2])), float(rng.uniform(-0.1, 0.15)))


CONDITIONS = (
    Condition('nothing but the readings of the meters'),
    Condition('30 % of the target hidden', scene=hide_landmarks),
    Condition('a person in front', scene=add_person),
    Condition('one landmark moved', scene=move_object),
    Condition('40 % brighter', gain=1.4),
    Condition('40 % darker', gain=0.6),
    Condition('out of focus, sigma 2 px', optics=StereoOptics(blur=2.0)),
    Condition('out of focus, sigma 3 px', optics=StereoOptics(blur=3.0)),
    Condition('motion of 3 px', optics=StereoOptics(motion_blur=(3.0, 0.0))),
    Condition('motion of 6 px', optics=StereoOptics(motion_blur=(6.0, 0.0))),
    Condition('noise three times as strong', noise=3.0),
)


def repeat(taught: TaughtCorridor, seed: int, condition: Condition, rng: np.random.Generator) -> tuple[Pair, SE2]:
    """Return a pair of images under a condition, and the true displacement."""
    scene = corridor(CorridorDesign(seed=seed, needles=1 + int(rng.integers(1000))))
    scene = condition.scene(scene, taught, rng)
    cameras = replace(RIG, left=condition.camera(RIG.left), right=condition.camera(RIG.right))
    truth = random_offset(OFFSET_MAX, YAW_MAX, rng)
    return render_pair(scene, cameras, TAUGHT @ truth, rng), truth


def main(run: Run, places: int, views: int, only: str) -> None:
    """Come back under all conditions."""
    use_one_core()
    pipelines = [FeaturePipeline(name, CAMERAS) for name in ('ORB', 'SIFT')]
    chosen = [condition for condition in CONDITIONS if only in condition.name]
    scores = defaultdict[tuple[str, str], list[PoseScore]](list)
    for seed in progress(range(places), 'places'):
        taught = teach_corridor(corridor(CorridorDesign(seed=seed)))
        localizers = {
            OURS: LandmarkLocalizer([taught.place]),
            PAPER_MODE: LandmarkLocalizer([taught.place], LandmarkSettings(mode=PAPER)),
        }
        features = [pipeline.teach(taught.images) for pipeline in pipelines]
        for condition, view in product(chosen, range(views)):
            rng = np.random.default_rng((seed, CONDITIONS.index(condition), view))
            images, truth = repeat(taught, seed, condition, rng)
            found = {name: displacement_of(each.locate(*images)) for name, each in localizers.items()}
            for pipeline, known in zip(pipelines, features, strict=True):
                found[pipeline.name] = pipeline.locate(known, pipeline.features(images[0]))
            for method, pose in found.items():
                scores[condition.name, method].append(score_found(pose, truth, RIGHT_WITHIN))
    heads = 'otherwise | method | right / none / wrong | mm: median / 95 % | °: median / 95 %'
    table = run.table('Hard repeats', heads)
    for names, found_all in scores.items():
        table.add(*names, *pose_cells(found_all, '.1f'))


if __name__ == '__main__':
    run_benchmark(
        main,
        places=Option(3, 1, 'corridors that are taught'),
        views=Option(8, 1, 'of each corridor under each condition'),
        only=Option('', '', 'conditions whose name holds this'),
    )
