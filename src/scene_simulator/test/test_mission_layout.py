"""Each seed has its own room, always the same, in which every goal can be reached and nothing is too high."""

import numpy as np
import pytest

from scene_simulator.errors import SceneError
from scene_simulator.mission.layout import (
    CEILING_MOUNT,
    PASSAGE,
    ROBOT_HEIGHT,
    ROBOT_RADIUS,
    ROOM,
    is_connected,
    mission_layout,
    mission_obstacles,
)
from scene_simulator.room.box_room import BoxRoom
from scene_simulator.room.furniture import FurnishedRoom, crate


def flood(room: BoxRoom, start: tuple[float, float], step: float = 0.1) -> set[tuple[int, int]]:
    """Return the places that a robot reaches in steps, tested one by one."""

    def is_free(x: float, y: float) -> bool:
        away = min(x, y, ROOM[3] - x, ROOM[4] - y)
        for x0, y0, _, x1, y1, _ in room.boxes:
            away = min(away, np.hypot(max(x0 - x, 0, x - x1), max(y0 - y, 0, y - y1)))
        return away > ROBOT_RADIUS + PASSAGE - 0.07

    seen, open_list = set(), [(round(start[0] / step), round(start[1] / step))]
    while open_list:
        i, j = place = open_list.pop()
        if place not in seen and is_free(i * step, j * step):
            seen.add(place)
            open_list += [(i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)]
    return seen


@pytest.mark.parametrize('seed', range(4))
def test_a_flood_from_the_start_reaches_every_goal(seed):
    layout = mission_layout(seed)
    room = mission_obstacles(seed, layout)
    reached = flood(room.boxes, (layout.start.x, layout.start.y))
    for goal in layout.goals:
        assert (round(goal.x / 0.1), round(goal.y / 0.1)) in reached


def test_equal_seeds_give_equal_rooms_and_others_give_others():
    rooms = [mission_obstacles(seed, mission_layout(seed)) for seed in (3, 3, 4)]
    assert rooms[0] == rooms[1]
    assert rooms[0].boxes != rooms[2].boxes


def test_nothing_is_as_high_as_what_looks_over_it():
    boxes = mission_obstacles(1, mission_layout(1)).boxes.boxes
    assert max(box[5] for box in boxes) <= CEILING_MOUNT.xyz[2] <= ROBOT_HEIGHT


def test_a_wall_of_crates_cuts_the_room_in_two():
    row = crate(0.3, 5.9, 0.5).translate(4.0, 0.05)
    room = FurnishedRoom(ROOM, (row,))
    assert is_connected(room, [(1.0, 1.0), (2.0, 5.0)])
    assert not is_connected(room, [(1.0, 1.0), (6.0, 1.0)])


def test_a_negative_seed_is_refused():
    with pytest.raises(SceneError, match='seed is -1'):
        mission_layout(-1)
