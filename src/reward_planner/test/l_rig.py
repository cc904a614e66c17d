"""Three cameras in an L in a room of boxes, and their images."""

from functools import lru_cache

import numpy as np

from scene_simulator.room.box_room import BoxRoom, forward_camera
from scene_simulator.room.room_drive import render_picture
from shirube_core.geometry import PinholeCamera

CAMERA = PinholeCamera(320, 240, 262.5, 262.5, 159.5, 119.5)
BASELINE = 0.1
ROOM = BoxRoom((-1.0, -2.0, 0.0, 3.3, 2.0, 2.4), ((1.3, -0.5, 0.0, 1.7, 0.1, 0.7), (2.0, 0.3, 0.5, 2.4, 1.0, 1.2)))


def projection(camera=CAMERA, x=0.0, y=0.0):
    """Projection matrix of a camera at a position in the left camera's optical frame [m]."""
    P = np.zeros((3, 4))
    P[:, :3] = camera.matrix
    P[0, 3], P[1, 3] = -camera.fx * x, -camera.fy * y
    return P


@lru_cache
def picture(x=0.0, y=0.0, noise=1.0, seed=0, room=ROOM):
    """Image of a camera at that position."""
    T = forward_camera(0.0, 0.0, 0.6, 0.1)
    T[:3, 3] += T[:3, 0] * x + T[:3, 1] * y
    return render_picture(room, CAMERA, T, noise, np.random.default_rng([seed, int(1e3 * x) % 997, int(1e3 * y) % 997]))


@lru_cache
def true_depth(room=ROOM):
    """Depth of the left camera's pixels."""
    return room.depth_image(CAMERA, forward_camera(0.0, 0.0, 0.6, 0.1))
