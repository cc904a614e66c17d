"""The robot's pose from the dots of the floor under it."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.dots import DotMap
from floor_localizer.core.fix import NoFix
from floor_localizer.core.localizer import FloorLocalizer
from floor_localizer.files.dot_map_file import load_indexed_map
from floor_localizer.localization.localizer_from_map_file import DEMO_MAP, NodeSettings
from shirube.inputs import as_camera, as_image, as_numbers, as_triple, prepare
from shirube.results import Result, as_pose
from shirube_core.geometry import CameraMount, PinholeCamera


class Localizer:
    """Finds the robot on a map of dots from one image of the floor; has no state between images.

    Args:
        map: dot map file (CSV or .dotmap), or x, y of the dots, shape (n, 2) [m]; None for the demo floor.
        camera_xyz: position of the camera in the robot's frame [m].
        camera_rpy: fixed-axis roll, pitch, yaw of its optical frame there [rad]; by default it looks down.

    Raises:
        InputError, FloorLocalizerError: a map or a mount that cannot be used.
    """

    def __init__(
        self,
        map: str | Path | ArrayLike | None = None,  # noqa: A002 the word that users know
        camera_xyz: Sequence[float] = NodeSettings.camera_xyz,
        camera_rpy: Sequence[float] = NodeSettings.camera_rpy,
    ) -> None:
        mount = CameraMount(as_triple('camera_xyz', camera_xyz), as_triple('camera_rpy', camera_rpy))
        prepare('floor_localizer')
        if map is None or isinstance(map, str | Path):
            floor = load_indexed_map(DEMO_MAP if map is None else Path(map))
        else:
            points = as_numbers('map', map, (None, 2))
            floor = index_map(DotMap(points, np.full(len(points), np.nan)))
        self._localizer = FloorLocalizer(floor, mount)

    def locate(self, image: ArrayLike, camera: PinholeCamera | str | Path) -> Result:
        """Return the pose from one image, or the reason for none.

        Args:
            image: shape (h, w) grey or (h, w, 3) BGR, values 0 to 255.
            camera: a `Camera`, or the path of its calibration.

        Raises:
            InputError: the image is malformed or not of the camera's size.
        """
        camera = as_camera(camera)
        found = self._localizer.locate(as_image(image, camera), camera)
        if isinstance(found, NoFix):
            return Result(reason=f'{found.reason.value} ({found.detail})')
        return Result(as_pose(found.T_map_base), found.covariance)
