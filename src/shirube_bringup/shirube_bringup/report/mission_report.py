"""Writes the report of a mission to a folder: HTML page and figures."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from shirube_bringup.mission_traces import MissionTraces
from shirube_bringup.report.plan_pictures import draw_map, draw_tracks
from shirube_bringup.report.report_page import page
from shirube_bringup.report.time_pictures import draw_errors, draw_measurement_status, draw_speed, draw_timing
from shirube_core.files import write_text

PAGE = 'report.html'


def write_report(folder: Path, summary: Mapping[str, Any], traces: MissionTraces) -> Path:
    """Write the report and return the path of its page.

    Args:
        folder: folder for page and figures.
        summary: summary of the mission, as in `summary.json`.
        traces: time series of the mission.

    Raises:
        OSError: the folder is not writable.
    """
    draw_tracks(folder / 'tracks.png', traces)
    draw_errors(folder / 'errors.png', traces)
    draw_measurement_status(folder / 'trust.png', traces)
    draw_map(folder / 'map.png', traces)
    draw_speed(
        folder / 'speed.png', traces, [(command['time'], command['order']) for command in summary['orders']]
    )
    draw_timing(folder / 'timing.png', traces)
    write_text(folder / PAGE, page(summary, traces))
    return folder / PAGE
