"""The diagnostics in each state."""

from localizer_results import REASON, a_fix, no_fix

from floor_localizer.node import LocalizerReport
from shirube_ros.diagnostics import Level


def test_before_the_first_image_there_is_a_warning():
    status = LocalizerReport('hall.csv').status()
    assert (status.level, status.values['map']) == (Level.WARN, 'hall.csv')
    assert status.message == 'no image received'


def test_a_fix_is_fine_and_shows_its_quality():
    report = LocalizerReport('hall.csv')
    report.add(a_fix(), 0.0123)
    status = report.status()
    assert (status.level, status.message) == (Level.OK, 'fix')
    assert status.values['dots matched'] == '2'
    assert status.values['sigma x, y, yaw'] == '0.100 mm, 0.200 mm, 1.000 mrad'
    assert status.values['camera height over nominal'] == '+1.00 %'
    assert status.values['time for the latest image [ms]'] == '12.3'


def test_no_fix_says_why_and_is_counted():
    report = LocalizerReport('hall.csv')
    for result in (no_fix(), a_fix(), no_fix()):
        report.add(result, 0.0)
    status = report.status()
    assert (status.level, status.message) == (Level.WARN, f'no fix: {REASON.value}')
    assert status.values['detail'] == '2 of 7'
    assert status.values['images with a fix'] == '1'
    assert status.values[f'images without: {REASON.value}'] == '2'
