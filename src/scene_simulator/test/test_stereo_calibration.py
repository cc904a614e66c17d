"""Calibration files are what camera_calibration writes."""

from __future__ import annotations

import numpy as np
import yaml

from scene_simulator.stereo_calibration import calibration_yaml
from scene_simulator.stereo_rig import raw_rig


def test_the_file_holds_the_calibration() -> None:
    for found, name in zip(raw_rig().calibrations(), ('left', 'right'), strict=True):
        read = yaml.safe_load(calibration_yaml(found, name))
        assert (read['image_width'], read['image_height'], read['camera_name']) == (752, 480, name)
        assert read['distortion_model'] == 'plumb_bob'
        for field, shape, values in (
            ('camera_matrix', (3, 3), found.camera.matrix),
            ('distortion_coefficients', (1, 5), found.camera.distortion),
            ('rectification_matrix', (3, 3), found.rotation),
            ('projection_matrix', (3, 4), found.projection),
        ):
            assert (read[field]['rows'], read[field]['cols']) == shape
            np.testing.assert_array_equal(
                np.array(read[field]['data']).reshape(shape), np.reshape(values, shape)
            )
