import pytest

from shirube_core.settings import SettingsError, check_settings
from stereo_landmark.core.settings import EdgeSettings
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError


def test_is_a_value_error_that_one_line_explains():
    with pytest.raises(ValueError, match='the image is too small'):
        raise StereoLandmarkError('the image is too small')


def test_defaults_of_the_edges_are_allowed_and_others_refused():
    check_settings(EdgeSettings())
    with pytest.raises(SettingsError, match='filter_sigma'):
        check_settings(EdgeSettings(filter_sigma=0.0))
