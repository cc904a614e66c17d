"""Random corridors with five meters in a row; each seed gives a different one."""

import math
from dataclasses import dataclass

import numpy as np

from scene_simulator.corridor.fittings import Door, NoticeBoard, Pipe, RoundSign, Sign
from scene_simulator.corridor.instruments import Cabinet, Meter
from scene_simulator.corridor.scene import CorridorScene, Person, SceneObject
from scene_simulator.corridor.shapes import Surface, facing_wall
from scene_simulator.corridor.walls import CorridorShell
from scene_simulator.errors import SceneError, check_seed

METERS = 5  # as in the paper's experiment (5)
_TEXTS = (
    ('EXIT',),
    ('DANGER', 'HIGH VOLTAGE'),
    ('NO ENTRY',),
    ('ROOM 204',),
    ('PUMP HALL', 'LEVEL 2'),
    ('VALVES', '1 TO 9'),
)


@dataclass(frozen=True)
class CorridorDesign:
    """Parameters of a generated corridor; the seed decides the rest.

    Attributes:
        seed: random seed.
        even: the meters are evenly spaced; otherwise their gaps differ by up to a quarter.
        bare: nothing else is on the end wall, so that only the spacing distinguishes the meters.
        people: number of people in the corridor.
        tile: width of the tiles on the walls, 0 is plaster [m]; small ones make many segments.
        needles: seed of what the meters read; the corridor itself does not depend on it.
        case: case of the meters, see `Meter`.
        posters: the same poster hangs above each meter, and the same plate below it.
    """

    seed: int = 0
    even: bool = False
    bare: bool = False
    people: int = 0
    tile: float = 0.0
    needles: int = 0
    case: str = 'round'
    posters: bool = False

    def __post_init__(self) -> None:
        """Refuse negative seeds or numbers of people with a SceneError."""
        check_seed(self.seed)
        check_seed(self.needles)
        if self.people < 0:
            raise SceneError(f'{self.people} people in a corridor are impossible: give zero or more')
        if self.tile != 0.0 and not 0.02 <= self.tile < math.inf:
            raise SceneError(f'tiles of {self.tile} m cannot be drawn: give 0 for plaster, or 0.02 or more')


def corridor(design: CorridorDesign | None = None) -> CorridorScene:
    """Return a corridor that ends at a wall with meters, panels and doors.

    The end wall is the map's plane x = 0, seen along x; a robot at (-3, 0) with yaw 0 faces its centre.
    Names: ``meter_0`` to ``meter_4`` from left to right, ``cabinet``, ``fuse_box``, ``door``, ``board``, ``sign_0``...
    """
    chosen = design or CorridorDesign()
    rng = np.random.default_rng(chosen.seed)
    shell = CorridorShell(
        float(rng.uniform(4.3, 4.8)),
        float(rng.uniform(2.7, 2.95)),
        float(rng.choice([0.0, 1.1, 1.2])),
        (float(rng.uniform(0.0, 4.0)), float(rng.uniform(0.0, 4.0))),
        chosen.tile,
    )
    objects: list[SceneObject] = [shell, *_side_walls(shell, rng)]
    if not chosen.bare:
        objects += _end_wall(shell, rng)
    meters = _meters(chosen, rng)
    objects += (*meters, *(_repeated(meters, shell) if chosen.posters else ()))
    return CorridorScene((*objects, *people(chosen.people, rng)))


def people(count: int, rng: np.random.Generator) -> list[Person]:
    """Return people in front of the end wall, farthest first."""
    distances = np.sort(rng.uniform(0.5, 1.8, count)).tolist()
    sides = rng.uniform(-1.3, 1.3, count).tolist()
    found = []
    for index, (distance, side) in enumerate(zip(distances, sides, strict=True)):
        jacket, trousers, helmet = rng.uniform((0.15, 0.1, 0.4), (0.6, 0.4, 0.95)).tolist()
        height = float(rng.uniform(1.6, 1.9))
        found.append(Person(f'person_{index}', facing_wall(-distance), (side, 0.0), height, (jacket, trousers, helmet)))
    return found


def _meters(design: CorridorDesign, rng: np.random.Generator) -> list[Meter]:
    """Return the row of meters about the middle of the end wall."""
    radius = float(rng.uniform(0.085, 0.11))
    gaps = np.full(METERS - 1, rng.uniform(2.5, 2.9) * radius)
    if not design.even:
        gaps *= rng.uniform(1.0, 1.25, METERS - 1)
    places = np.concatenate([[0.0], np.cumsum(gaps)])
    left, height = rng.uniform(-0.06, 0.06) - 0.5 * places[-1], float(rng.uniform(1.5, 1.62))
    readings = np.random.default_rng((design.seed, design.needles)).uniform(0.02, 0.98, METERS)
    return [
        Meter(
            f'meter_{i}', facing_wall(0.0), (float(left + places[i]), height), radius, float(readings[i]), design.case
        )
        for i in range(METERS)
    ]


def _repeated(meters: list[Meter], shell: CorridorShell) -> list[SceneObject]:
    """Return the same poster above each meter and the same plate below it, which only look like landmarks."""
    objects: list[SceneObject] = []
    for meter in meters:
        (x, y), radius = meter.position, meter.radius
        poster = (x, y + 2.3 * radius), (1.8 * radius, 2.2 * radius)
        objects += [
            NoticeBoard(f'repeated_poster_{meter.name}', shell.surface, *poster, 7),
            Sign(f'repeated_plate_{meter.name}', shell.surface, (x, y - 1.5 * radius), (1.6 * radius, 0.05), ('PUMP',)),
        ]
    return objects


def _end_wall(shell: CorridorShell, rng: np.random.Generator) -> list[SceneObject]:
    """Return the objects around the meters; their side is random."""
    wall, mirror = shell.surface, float(rng.choice([-1.0, 1.0]))
    half = 0.5 * shell.width
    door_at, board_at = mirror * (half - rng.uniform(0.62, 0.7)), -mirror * (half - rng.uniform(0.62, 0.75))
    cabinet = _cabinet(wall, rng)
    lines = [_TEXTS[i] for i in rng.permutation(len(_TEXTS))]
    pipe_at = -mirror * (half - 0.12)
    inlet = mirror * (half - 1.34)
    door_grey, number = float(rng.uniform(0.28, 0.5)), f'{rng.integers(10, 99)}'
    return [
        Door('door', wall, (door_at, 0.0), (0.86, 2.03), door_grey, number, mirror > 0),
        Sign('sign_0', wall, (door_at, 2.22), (0.42, 0.18), ('EXIT',), True),
        NoticeBoard('board', wall, (board_at, float(rng.uniform(1.5, 1.6))), (0.8, 0.56), int(rng.integers(1000))),
        Cabinet(
            'fuse_box', wall, (board_at - 0.22, 0.5), (0.44, 0.58), 0.09, float(rng.uniform(0.5, 0.75)), 1, 2, 'F 12'
        ),
        cabinet,
        RoundSign('round_sign', wall, (inlet, float(rng.uniform(1.0, 1.22)))),
        Sign('sign_1', wall, (float(rng.uniform(-0.5, 0.5)), 1.99), (0.5, 0.22), lines[0]),
        Sign('sign_2', wall, (inlet, 0.72), (0.26, 0.2), lines[1], True),
        Pipe('pipe_0', wall, (-half, shell.height - 0.16), (shell.width, 0.0), 0.05, 0.75),
        Pipe('pipe_1', wall, (-half, shell.height - 0.31), (shell.width, 0.0), 0.035, 0.5),
        Pipe('pipe_2', wall, (pipe_at, 0.0), (0.0, shell.height), 0.05, 0.6),
    ]


def _cabinet(wall: Surface, rng: np.random.Generator) -> Cabinet:
    """Return the large cabinet below the meters."""
    size = float(rng.uniform(0.85, 1.1)), float(rng.uniform(0.6, 0.72))
    position = float(rng.uniform(-0.1, 0.1)) - 0.5 * size[0], float(rng.uniform(0.5, 0.55))
    columns, label = int(rng.integers(3, 5)), f'MCC {rng.integers(1, 9)}'
    depth, grey = float(rng.uniform(0.08, 0.16)), float(rng.uniform(0.35, 0.5))
    return Cabinet('cabinet', wall, position, size, depth, grey, columns, 2, label)


def _side_walls(shell: CorridorShell, rng: np.random.Generator) -> list[SceneObject]:
    """Return doors, boxes and pipes on the walls to the left and to the right."""
    objects: list[SceneObject] = []
    for side, wall, towards in (('left', shell.left_wall, -1.0), ('right', shell.right_wall, 1.0)):
        first = float(rng.uniform(1.0, 1.6))
        for index, at in enumerate((first, first + 2.6, first + 5.2)):
            number, text = f'{rng.integers(10, 99)}', _TEXTS[int(rng.integers(len(_TEXTS)))]
            box_at = towards * (at + 1.3) - 0.2, 0.9
            objects += [
                Door(f'{side}_door_{index}', wall, (towards * at, 0.0), label=number),
                Sign(f'{side}_sign_{index}', wall, (towards * (at + 0.75), 1.6), (0.3, 0.2), text),
                Cabinet(f'{side}_box_{index}', wall, box_at, (0.4, 0.5), 0.15, 0.6, 1, 1, 'P 3'),
            ]
        start = 0.0 if towards > 0.0 else -12.0
        objects.append(Pipe(f'{side}_pipe', wall, (start, shell.height - 0.25), (12.0, 0.0), 0.06, 0.65))
    return objects
