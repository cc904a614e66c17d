import numpy as np
import pytest

from stereo_landmark.core.edges.edges import check_grey_image
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError


@pytest.mark.parametrize(
    ('image', 'expected'),
    [
        (np.zeros((40, 40)), 'float64'),
        ([[1]], 'list'),
        (np.zeros((40, 40, 3), np.uint8), r'\(40, 40, 3\)'),
        (np.zeros((40, 8), np.uint8), '8 x 40 px'),
    ],
)
def test_refuses_what_is_no_grey_image_in_one_line(image, expected):
    with pytest.raises(StereoLandmarkError, match=expected) as caught:
        check_grey_image(image)
    assert '\n' not in str(caught.value)


def test_takes_a_grey_image():
    check_grey_image(np.zeros((16, 16), np.uint8))
