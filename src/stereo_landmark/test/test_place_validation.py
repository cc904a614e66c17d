import pytest
from taught_wall import write_files

from stereo_landmark.core.settings import LandmarkSettings, SearchSettings
from stereo_landmark.files.place_file import load_places
from stereo_landmark.files.yaml_file import LandmarkFileError
from stereo_landmark.node import validate_places


@pytest.fixture
def folder(tmp_path):
    return write_files(tmp_path).places


def test_a_good_place_is_found_in_its_own_images(folder):
    assert validate_places(folder, load_places(folder), LandmarkSettings()) == []


def test_parameters_with_which_a_place_cannot_be_found_are_reported(folder):
    strict = LandmarkSettings(search=SearchSettings(log_likelihood_ratio_min=100.0))
    (line,) = validate_places(folder, load_places(folder), strict)
    assert (
        'place wall is not found in the images it was taught from: the match could be due to chance' in line
    )


def test_a_missing_image_is_refused(folder):
    next(folder.glob('wall_left_*.png')).unlink()
    with pytest.raises(LandmarkFileError, match=r'wall\.yaml: images\.left: .* cannot be read'):
        validate_places(folder, load_places(folder), LandmarkSettings())
