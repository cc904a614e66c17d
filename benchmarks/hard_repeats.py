"""Coming back under hard conditions: part of the target hidden, other light, blur, noise, a person, a landmark moved.

Corridors are taught once; peers are ORB and SIFT with stereo and PnP, taught with the same pair. Right is within 5 cm
and 1.5 degrees.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from _harness import Option, Run, progress, run_benchmark, use_one_core
from _landmark_corridor import TAUGHT, TaughtCorridor, teach_corridor
from _pose_scores import PoseScore, pose_cells, score_found
from _stereo_peers import FeaturePipeline
from _stereo_scenes import CAMERAS, RIG, Pair, displacement_of, random_offset

from scene_simulator.corridor.generator import CorridorDesign, corridor
from scene_simulator.corridor.scene import CorridorScene, Person
from scene_simulator.corridor.shapes import facing_wall
from scene_simulator.corridor.stereo_rig import StereoCamera, render_pair
from shirube_core.geometry import SE2
from stereo_landmark.core.landmark_localizer import LandmarkLocalizer
from stereo_landmark.core.settings import PAPER, LandmarkSettings

HIDDEN_FRACTION = 0.3  # part of the target's primitives that is covered
OFFSET_MAX, YAW_MAX = 0.4, math.radians(10.0)
RIGHT_WITHIN = 0.05, math.radians(1.5)
OURS, PAPER_MODE = 'stereo_landmark', 'stereo_landmark, paper mode'

Changed = Callable[[CorridorScene, TaughtCorridor, np.random.Generator], CorridorScene]
Camera = Callable[[StereoCamera], StereoCamera]


class Condition(NamedTuple):
    """What is otherwise than when the place was taught: a change of the corridor, and one of each camera."""

    name: str
    scene: Changed = lambda scene, taught, rng: scene  # noqa: ARG005
    camera: Camera = lambda camera: camera


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


def with_gain(factor: float) -> Camera:
    """Return cameras of another gain."""
    return lambda camera: replace(camera, sensor=replace(camera.sensor, gain=factor * camera.sensor.gain))


def with_blur(blur: float = 0.6, motion_blur: float = 0.0) -> Camera:
    """Return cameras out of focus, or in motion [px]."""
    changed: dict[str, Any] = {'blur': blur, 'motion_blur': (motion_blur, 0.0)}
    return lambda camera: replace(camera, optics=replace(camera.optics, **changed))


def with_noise(factor: float) -> Camera:
    """Return cameras with more noise."""

    def noisy(camera: StereoCamera) -> StereoCamera:
        sensor = camera.sensor
        well, read_noise = sensor.full_well / factor**2, sensor.read_noise / factor
        return replace(camera, sensor=replace(sensor, full_well=well, read_noise=read_noise))

    return noisy


CONDITIONS = (
    Condition('nothing but the readings of the meters'),
    Condition('30 % of the target hidden', scene=hide_landmarks),
    Condition('a person in front', scene=add_person),
    Condition('one landmark moved', scene=move_object),
    Condition('40 % brighter', camera=with_gain(1.4)),
    Condition('40 % darker', camera=with_gain(0.6)),
    Condition('out of focus, sigma 2 px', camera=with_blur(blur=2.0)),
    Condition('out of focus, sigma 3 px', camera=with_blur(blur=3.0)),
    Condition('motion of 3 px', camera=with_blur(motion_blur=3.0)),
    Condition('motion of 6 px', camera=with_blur(motion_blur=6.0)),
    Condition('noise three times as strong', camera=with_noise(3.0)),
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
    scores: dict[tuple[str, str], list[PoseScore]] = {
        (condition.name, method): [] for condition in chosen for method in (OURS, PAPER_MODE, 'ORB', 'SIFT')
    }
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
