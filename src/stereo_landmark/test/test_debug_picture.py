import numpy as np
from located_pairs import detection, with_fix, without_fix

from stereo_landmark.node_output import debug_picture


def test_points_are_marked_where_they_are_seen_used_ones_in_another_colour():
    picture = debug_picture(with_fix()).astype(int)
    colours = [picture[v, u] for u, v in np.rint(detection().points.pixels[:, :2]).astype(int)]
    assert [bool(colour[1] > colour[0]) for colour in colours] == [True] * 4
    assert [bool(colour[2] > 200) for colour in colours] == [False, False, False, True]


def test_without_a_fix_there_is_only_the_reason():
    picture = debug_picture(without_fix())
    assert (picture[30:] == 100).all()
    assert (picture[:30] != 100).any()
