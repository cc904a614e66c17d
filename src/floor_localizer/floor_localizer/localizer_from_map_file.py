"""Puts a localizer together from the settings and the map file."""

from __future__ import annotations

from floor_localizer.core.localizer import FloorLocalizer, LocalizerSettings
from floor_localizer.files.dot_map_file import load_dot_map
from floor_localizer.node_settings import NodeSettings


def localizer_from_map_file(node_settings: NodeSettings, settings: LocalizerSettings) -> FloorLocalizer:
    """Return a localizer for the map that the settings name.

    Raises:
        FloorLocalizerError: a map that is missing, malformed or not in metres.
    """
    return FloorLocalizer(load_dot_map(node_settings.map_path), node_settings.mount, settings)
