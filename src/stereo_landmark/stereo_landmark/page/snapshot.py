"""State and results of a session as JSON for the page."""

import base64
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shirube_core.settings import describe_settings
from stereo_landmark.core.edges.edges import Segments
from stereo_landmark.core.landmark_localizer import LandmarkFix, NoLandmarkFix
from stereo_landmark.core.place.place_locator import NoPlaceFix, PlaceFix
from stereo_landmark.core.primitives.primitive import ImageProcessing, Primitive, PrimitiveKind, primitive_kind
from stereo_landmark.core.procedure.target_search import TargetDetection
from stereo_landmark.core.teaching.edits import processing_values
from stereo_landmark.core.teaching.hints import Hint, TargetReport
from stereo_landmark.core.teaching.primitive_selection import TargetSelection
from stereo_landmark.core.teaching.teaching_session import SelectablePrimitive, TeachingSession
from stereo_landmark.page.pair_source import StereoPairs

_UNIT = 16.0
"""Edge points are sent as integers in this fraction of a pixel [1/px]."""


def configuration(source: StereoPairs) -> dict[str, Any]:
    """Return the constant configuration: cameras, settings, kinds of primitives."""
    rig = source.rig
    fields = ('name', 'description', 'unit', 'minimum', 'maximum', 'default')
    settings = [{name: getattr(each, name) for name in fields} for each in describe_settings(ImageProcessing)]
    return {
        'width': rig.left.width,
        'height': rig.left.height,
        'focal_length': rig.left.fx,
        'baseline': rig.baseline,
        'camera_xyz': list(rig.mount.xyz),
        'camera_rotation': rig.mount.rotation.tolist(),
        'settings': settings,
        'kinds': [kind.value for kind in PrimitiveKind],
        'is_live': source.is_live,
    }


def snapshot(session: TeachingSession, source: StereoPairs) -> dict[str, Any]:
    """Return the whole state of a session with its results."""
    state, view = session.state, session.view
    pose = state.T_map_place
    return {
        'place': state.name,
        'pair': state.pair,
        'pairs': list(source.labels),
        'pose': None if pose is None else {'x': pose.x, 'y': pose.y, 'yaw': pose.yaw},
        'can_undo': session.can_undo,
        'can_redo': session.can_redo,
        'processing': processing_values(state.processing),
        'segments': len(view.left.segments),
        'kinds': sorted(kind.value for kind in state.kinds),
        'counts': {kind.value: len(view.left.kinds[kind].primitives) for kind in PrimitiveKind},
        'found': [_found(session, each) for each in session.selectable()],
        'targets': [_target(target, session.report(target)) for target in state.targets],
        'active': state.active,
    }


def edges(segments: Segments) -> dict[str, Any]:
    """Return the edge points of an image in a compact form, all segments concatenated."""
    units = np.rint(segments.points * _UNIT).astype('<i2')
    return {
        'unit': _UNIT,
        'count': len(segments),
        'points': base64.b64encode(units.tobytes()).decode(),
        'starts': base64.b64encode(segments.starts.astype('<i4').tobytes()).decode(),
    }


def hint_entries(hints: Iterable[Hint]) -> list[dict[str, str]]:
    """Return hints as JSON."""
    return [
        {'severity': hint.severity.value, 'target': hint.target, 'about': hint.about, 'text': hint.text}
        for hint in hints
    ]


def test_result(answer: LandmarkFix | NoLandmarkFix) -> dict[str, Any]:
    """Return the result of a test on another pair as JSON; the page puts the reasons into a technician's words."""
    used = answer.displacement.names if isinstance(answer, LandmarkFix) else ()
    detections: list[dict[str, Any]] = []
    for each in answer.detections:
        entry: dict[str, Any] = {'target': each.target, 'found': [], 'points': []}
        if isinstance(each, TargetDetection):
            entry['found'] = [name.removeprefix(f'{each.target}/') for name in each.found]
            entry['points'] = [
                {'name': name, 'left': _rounded(pixels[:2]), 'right': _rounded(pixels[2:]), 'used': name in used}
                for name, pixels in zip(each.points.names, each.points.pixels, strict=True)
            ]
        else:
            entry |= {'reason': each.reason.value, 'detail': each.detail}
        detections.append(entry)
    if isinstance(answer, NoLandmarkFix):
        return {'is_fix': False, 'reason': answer.reason, 'detail': answer.detail, 'detections': detections}
    pose = answer.displacement.T_place_base
    return {
        'is_fix': True,
        'x': pose.x,
        'y': pose.y,
        'yaw': pose.yaw,
        'height': answer.displacement.height,
        **_sigmas(answer.displacement),
        'detections': detections,
    }


def test_summary(result: dict[str, Any]) -> dict[str, Any]:
    """Return what the plan and the recall of the shapes need of the result of a test."""
    found = {each['target']: each['found'] for each in result['detections']}
    names = ('is_fix', 'reason', 'x', 'y', 'yaw', 'position_sigma')
    return {**{name: result[name] for name in names if name in result}, 'found': found}


def _found(session: TeachingSession, found: SelectablePrimitive) -> dict[str, Any]:
    return {
        'kind': found.kind.value,
        'number': found.number,
        'outline': _lines(found.shape),
        'depth': found.depth,
        'chosen': session.selected_name(found.shape),
        'fault': found.fault,
    }


def _target(target: TargetSelection, report: TargetReport) -> dict[str, Any]:
    region = target.region
    return {
        'name': target.name,
        'region': None if region is None else [region.left, region.top, region.right, region.bottom],
        'primitives': [_primitive(name, shape, report.measured[name]) for name, shape in target.primitives.items()],
        'points': _points(target, report),
        'expected': _expected(report.fix),
        'hints': hint_entries(report.hints),
    }


def _primitive(name: str, shape: Primitive, measured: tuple[Primitive, Primitive] | str) -> dict[str, Any]:
    left, right = (shape, None) if isinstance(measured, str) else measured
    return {
        'name': name,
        'kind': primitive_kind(shape).value,
        'centre': _rounded(left.centre),
        'left': _lines(left),
        'right': [] if right is None else _lines(right),
        'fault': measured if isinstance(measured, str) else '',
    }


def _points(target: TargetSelection, report: TargetReport) -> list[dict[str, Any]]:
    points, space = report.points, report.coordinates
    return [
        {
            'name': name,
            'used': target.uses(name),
            'left': _rounded(pixels[:2]),
            'right': _rounded(pixels[2:]),
            'xyz': position.tolist(),
            'covariance': covariance.tolist(),
            'sigma': float(np.sqrt(np.linalg.eigvalsh(covariance)[-1])),
        }
        for name, pixels, position, covariance in zip(
            points.names, points.pixels, space.positions, space.covariances, strict=True
        )
    ]


def _expected(fix: PlaceFix | NoPlaceFix) -> dict[str, Any]:
    if isinstance(fix, NoPlaceFix):
        return {'is_fix': False, 'reason': fix.reason.value, 'detail': fix.detail}
    return {'is_fix': True, **_sigmas(fix)}


def _sigmas(fix: PlaceFix) -> dict[str, float]:
    return {'position_sigma': fix.position_sigma, 'yaw_sigma': fix.yaw_sigma}


def _lines(primitive: Primitive) -> list[list[list[float]]]:
    return [_rounded(line) for line in primitive.outline()]


def _rounded(pixels: NDArray[np.float64]) -> Any:
    return np.round(pixels, 2).tolist()
