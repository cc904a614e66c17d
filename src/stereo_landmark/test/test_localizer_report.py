from dataclasses import replace

from located_pairs import with_fix, without_fix

from shirube_ros.diagnostics import Level
from stereo_landmark.node_output import LocalizerReport


class Clock:
    now = 0.0

    def __call__(self):
        return self.now


def test_missing_and_stopped_pairs_are_reported():
    clock = Clock()
    report = LocalizerReport('places', clock)
    assert (report.status().level, report.status().message[:13]) == (Level.WARN, 'no image pair')
    report.add(with_fix(), 0.05)
    assert (report.status().level, report.status().message) == (Level.OK, 'at wall')
    clock.now = 3.0
    assert (report.status().level, report.status().message[:17]) == (Level.WARN, 'image pairs timed')


def test_a_pair_without_a_fix_is_reported_with_its_reason():
    report = LocalizerReport('places', Clock())
    report.add(with_fix(), 0.05)
    report.add(without_fix(), 0.05)
    status = report.status()
    assert (status.level, status.message) == (Level.WARN, 'no fix: no similar shapes in view')
    assert status.values['pairs at wall'] == '1'
    assert status.values['pairs without: no similar shapes in view'] == '1'
    assert status.values['detail'] == 'place wall: meters'


def test_a_missing_imu_reading_is_reported():
    report = LocalizerReport('places', Clock())
    report.add(replace(with_fix(), is_tilt_missing=True), 0.05)
    assert (report.status().level, report.status().message[:22]) == (Level.WARN, 'at wall, assumed level')
    report.add(replace(without_fix(), is_tilt_missing=True), 0.05)
    assert report.status().values['tilt'] == 'assumed level'


def test_a_fix_is_reported_with_its_values():
    report = LocalizerReport('places', Clock())
    report.add(with_fix(), 0.0521)
    values = report.status().values
    assert values['targets found'] == 'meters'
    assert values['measured by patches'] == 'none; measured by outlines'
    assert values['points used'] == '3'
    assert values['x, y, yaw'] == '0.1500 m, -0.1000 m, 0.0600 rad'
    assert values['sigma x, y, yaw'] == '0.0010 m, 0.0020 m, 0.0100 rad'
    assert values['processing time [ms]'] == '52.1'


def test_what_was_compared_with_the_taught_images_is_named():
    report, located = LocalizerReport('places', Clock()), with_fix()
    report.add(replace(located, result=replace(located.result, matched_patches=('panel/a', 'panel/b'))), 0.05)
    assert report.status().values['measured by patches'] == 'panel/a, panel/b'
