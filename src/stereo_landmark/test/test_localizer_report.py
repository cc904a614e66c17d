from dataclasses import replace

from located_pairs import with_fix, without_fix

from shirube_ros.diagnostics import Level
from stereo_landmark.localizer_report import LocalizerReport


class Clock:
    now = 0.0

    def __call__(self):
        return self.now


def test_silence_before_and_after_pairs_is_told():
    clock = Clock()
    report = LocalizerReport('places', clock)
    assert (report.status().level, report.status().message[:11]) == (Level.WARN, 'no pair yet')
    report.add(with_fix(), 0.05)
    assert (report.status().level, report.status().message) == (Level.OK, 'at wall')
    clock.now = 3.0
    assert (report.status().level, report.status().message[:16]) == (Level.WARN, 'pairs have stopp')


def test_a_pair_without_a_fix_is_told_with_its_reason():
    report = LocalizerReport('places', Clock())
    report.add(with_fix(), 0.05)
    report.add(without_fix(), 0.05)
    status = report.status()
    assert (status.level, status.message) == (Level.WARN, 'no fix: nothing looks like it')
    assert status.values['pairs at wall'] == '1'
    assert status.values['pairs without: nothing looks like it'] == '1'
    assert status.values['detail'] == 'place wall: meters'


def test_an_imu_that_tells_nothing_of_the_moment_is_told():
    report = LocalizerReport('places', Clock())
    report.add(replace(with_fix(), lacks_tilt=True), 0.05)
    assert (report.status().level, report.status().message[:24]) == (Level.WARN, 'at wall, taken for level')
    report.add(replace(without_fix(), lacks_tilt=True), 0.05)
    assert report.status().values['tilt'] == 'taken for level'


def test_a_fix_tells_its_numbers():
    report = LocalizerReport('places', Clock())
    report.add(with_fix(), 0.0521)
    values = report.status().values
    assert values['targets found'] == 'meters'
    assert values['compared with the taught images'] == 'nothing; measured by outlines'
    assert values['points used'] == '3'
    assert values['x, y, yaw'] == '0.1500 m, -0.1000 m, 0.0600 rad'
    assert values['sigma x, y, yaw'] == '0.0010 m, 0.0020 m, 0.0100 rad'
    assert values['time for the latest pair [ms]'] == '52.1'


def test_what_was_compared_with_the_taught_images_is_named():
    report, located = LocalizerReport('places', Clock()), with_fix()
    report.add(replace(located, answer=replace(located.answer, compared=('panel/a', 'panel/b'))), 0.05)
    assert report.status().values['compared with the taught images'] == 'panel/a, panel/b'
