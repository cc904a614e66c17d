"""Edit commands of the page."""

from __future__ import annotations

from collections.abc import Callable

from shirube_geometry import PlanarPose
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching import edits
from stereo_landmark.core.teaching.teaching_state import Region, TeachingState
from stereo_landmark.page import request_fields as read
from stereo_landmark.page.request_fields import Request

Edit = Callable[[TeachingState, Request], TeachingState]

EDITS: dict[str, Edit] = {
    'name_place': lambda state, r: edits.name_place(state, read.text(r, 'name')),
    'locate_place': lambda state, r: edits.locate_place(state, _pose(r)),
    'set': lambda state, r: edits.set_processing(state, read.text(r, 'name'), read.number(r, 'value')),
    'reset': lambda state, r: edits.reset_processing(state, read.text(r, 'group')),
    'show_kind': lambda state, r: edits.show_kind(state, read.kind(r), shown=read.flag(r, 'shown')),
    'add_target': lambda state, _: edits.add_target(state),
    'remove_target': lambda state, r: edits.remove_target(state, read.whole(r, 'target')),
    'work_on_target': lambda state, r: edits.work_on_target(state, read.whole(r, 'target')),
    'name_target': lambda state, r: edits.name_target(state, read.whole(r, 'target'), read.text(r, 'name')),
    'draw_region': lambda state, r: edits.draw_region(state, _region(r)),
    'drop': lambda state, r: edits.drop(state, read.text(r, 'name')),
    'name_primitive': lambda state, r: edits.name_primitive(state, read.text(r, 'name'), read.text(r, 'to')),
    'move': lambda state, r: edits.move(state, read.text(r, 'name'), read.whole(r, 'place')),
    'use_points': lambda state, r: edits.use_points(
        state, read.texts(r, 'points'), used=read.flag(r, 'used')
    ),
}
"""Edits by the value of the field ``do``; each may raise a StereoLandmarkError."""


def _pose(request: Request) -> PlanarPose | None:
    if request.get('pose') is None:
        return None
    x, y, yaw = _numbers(request, 'pose', 3)
    return PlanarPose(x, y, yaw)


def _region(request: Request) -> Region | None:
    if request.get('region') is None:
        return None
    return Region(*_numbers(request, 'region', 4))


def _numbers(request: Request, name: str, count: int) -> list[float]:
    values = request[name]
    if not isinstance(values, list) or len(values) != count:
        raise StereoLandmarkError(f'request: {name} must be {count} numbers; reload the page')
    return [read.number({name: value}, name) for value in values]
