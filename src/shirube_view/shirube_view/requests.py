"""Requests of pages: checked, then done."""

import json
import math
from collections.abc import Mapping
from time import monotonic
from typing import Any

from shirube_core.geometry import SE2
from shirube_view.bag_process import BagProcess
from shirube_view.view_node import SERVICES, ViewNode

COORDINATE_MAX = 1e4  # largest coordinate of a goal [m]
SIMULATION = ('cover', 'lamps', 'kidnap', 'obstacle', 'walker', 'clear')


class RequestError(ValueError):
    """A request that is malformed or not allowed; the message is one line."""


def number(request: Mapping[str, Any], name: str, limit: float) -> float:
    """Return a finite number of a request within a limit; raise a RequestError otherwise."""
    value = request.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= limit:
        raise RequestError(f'{name} must be a number from {-limit:g} to {limit:g}; reload the page')
    return float(value)


def word(request: Mapping[str, Any], name: str, allowed: Any) -> str:
    """Return a text of a request that is among those allowed; raise a RequestError otherwise."""
    value = request.get(name)
    if not isinstance(value, str) or value not in allowed:
        raise RequestError(f'{name} must be one of {", ".join(allowed)}; reload the page')
    return value


def pose(request: Mapping[str, Any]) -> SE2:
    """Return the pose of a request; raise a RequestError if it has none."""
    x, y = (number(request, name, COORDINATE_MAX) for name in ('x', 'y'))
    return SE2(x, y, math.remainder(number(request, 'yaw', 100.0), math.tau))


class Commands:
    """Does what pages command to the robot."""

    def __init__(self, node: ViewNode, recorder: BagProcess) -> None:
        """Set the node that publishes, and the recorder of bags."""
        self.node, self._recorder = node, recorder

    def do(self, page: Any, request: Mapping[str, Any]) -> str:
        """Do what a page commands; return it in words or empty, or raise a RequestError if it cannot be done."""
        node, kind = self.node, request['do']
        if kind == 'drive':
            forward, turn = (number(request, name, 1.0) for name in ('forward', 'turn'))
            return self._drive(page, forward, turn, is_first=request.get('first') is True)
        if kind == 'let_go':
            node.driver.release(page, monotonic())
            return ''
        if kind in ('goal', 'initialpose'):
            place, send = pose(request), node.send_goal if kind == 'goal' else node.send_initial_pose
            node.run_soon(lambda: send(place))
            return f'{"goal" if kind == "goal" else "initial pose"} at x {place.x:.2f} m, y {place.y:.2f} m'
        if kind in ('stop', 'release'):
            node.run_soon(lambda: node.send_stop(kind == 'stop'))
            return 'emergency stop' if kind == 'stop' else 'emergency stop released'
        if kind == 'call':
            name = word(request, 'name', SERVICES)
            node.run_soon(lambda: node.call(name, page.report))
            return ''
        return self._recorder.toggle() if kind == 'record' else self._simulate(request)

    def _drive(self, page: Any, forward: float, turn: float, *, is_first: bool) -> str:
        refusal = self.node.driver.drive(page, forward, turn, monotonic())
        if refusal:
            raise RequestError(refusal)
        if is_first:
            # The planner would drive to its goal at the same time.
            self.node.run_soon(lambda: self.node.call('cancel', lambda _text, _is_done: None))
        return ''

    def _simulate(self, request: Mapping[str, Any]) -> str:
        if not self.node.is_simulated:
            raise RequestError('no simulation is running; start ./shirube demo')
        what = word(request, 'what', SIMULATION)
        asked: dict[str, Any] = {'what': what}
        if what == 'cover':
            asked['camera'] = word(request, 'camera', ('floor', 'ceiling', 'stereo', 'depth'))
        if what in ('cover', 'lamps'):
            asked['on'] = request.get('on') is True
        elif what != 'clear':
            place = pose(request)
            asked |= {'x': place.x, 'y': place.y, 'yaw': place.yaw}
        self.node.run_soon(lambda: self.node.send_simulation(json.dumps(asked)))
        return f'simulation: {what}'


KINDS = ('drive', 'let_go', 'goal', 'initialpose', 'stop', 'release', 'call', 'record', 'simulate')
"""Requests that command the robot."""
