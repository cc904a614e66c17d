"""Edit commands of the page."""

from __future__ import annotations

from collections.abc import Callable

from shirube_core.geometry import SE2
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching import edits
from stereo_landmark.core.teaching.teaching_state import Region, TeachingState
from stereo_landmark.page import request_fields as read
from stereo_landmark.page.request_fields import Request

Edit = Callable[[TeachingState, Request], TeachingState]

EDITS: dict[str, Edit] = {
    'rename_place': lambda state, r: edits.rename_place(state, read.text(r, 'name')),
    'set_map_pose': lambda state, r: edits.set_map_pose(state, _pose(r)),
    'set': lambda state, r: edits.set_processing(state, read.text(r, 'name'), read.number(r, 'value')),
    'reset': lambda state, r: edits.reset_processing(state, read.text(r, 'group')),
    'show_kind': lambda state, r: edits.show_kind(state, read.kind(r), shown=read.flag(r, 'shown')),
    'add_target': lambda state, _: edits.add_target(state),
    'remove_target': lambda state, r: edits.remove_target(state, read.integer(r, 'target')),
    'activate_target': lambda state, r: edits.activate_target(state, read.integer(r, 'target')),
    'rename_target': lambda state, r: edits.rename_target(
        state, read.integer(r, 'target'), read.text(r, 'name')
    ),
    'set_region': lambda state, r: edits.set_region(state, _region(r)),
    'drop': lambda state, r: edits.remove_primitive(state, read.text(r, 'name')),
    'rename_primitive': lambda state, r: edits.rename_primitive(
        state, read.text(r, 'name'), read.text(r, 'to')
    ),
    'move': lambda state, r: edits.move_primitive(state, read.text(r, 'name'), read.integer(r, 'place')),
    'set_points_used': lambda state, r: edits.set_points_used(
        state, read.text_list(r, 'points'), used=read.flag(r, 'used')
    ),
}
"""Edits by the value of the field ``do``; each may raise a StereoLandmarkError."""


def _pose(request: Request) -> SE2 | None:
    if request.get('pose') is None:
        return None
    x, y, yaw = _numbers(request, 'pose', 3)
    return SE2(x, y, yaw)


def _region(request: Request) -> Region | None:
    if request.get('region') is None:
        return None
    return Region(*_numbers(request, 'region', 4))


def _numbers(request: Request, name: str, count: int) -> list[float]:
    values = request[name]
    if not isinstance(values, list) or len(values) != count:
        raise StereoLandmarkError(f'request: {name} must be {count} numbers; reload the page')
    return [read.number({name: value}, name) for value in values]
