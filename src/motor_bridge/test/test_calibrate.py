"""The command, with given and with measured runs."""

import math
import shutil
from pathlib import Path
from threading import Lock

import numpy as np
import pytest
import yaml

from motor_bridge.commands import calibrate
from motor_bridge.emulator.emulated_controller import EmulatedController
from motor_bridge.emulator.firmware import EmulatorSettings
from motor_bridge.emulator.pseudo_terminal import PseudoTerminal

CONFIG = Path(__file__).resolve().parents[3] / 'config' / 'motor_bridge.yaml'
MANY_NODES = """\
motor_bridge:
  ros__parameters:
    wheel_radius: 0.033  # m

# of the wheels' distance
    wheel_separation: 0.2
another:
  ros__parameters:
    wheel_radius: 9.0"""


@pytest.fixture
def params(tmp_path):
    return Path(shutil.copy(CONFIG, tmp_path / 'robot.yaml'))


def wheels(path):
    content = yaml.safe_load(path.read_text())
    values = content.get('motor_bridge', content.get('/**'))['ros__parameters']
    return values['wheel_radius'], values['wheel_separation']


def test_numbers_scale_the_wheels_and_nothing_else(params, capsys):
    numbers = ['--straight', '2.0', '1.9', '--turn', '3600', '3500']
    assert calibrate.main(['--params', str(params), *numbers]) == 0
    radius, separation = wheels(params)
    assert radius == pytest.approx(0.033 * 0.95, rel=1e-4)
    assert separation == pytest.approx(0.2 * 0.95 * 3600 / 3500, rel=1e-4)
    before, after = CONFIG.read_text().splitlines(), params.read_text().splitlines()
    assert sum(a != b for a, b in zip(before, after, strict=True)) == 2
    assert 'wheel_radius' in capsys.readouterr().out


NUMBERS = ['--straight', '1.0', '1.1', '--turn', '360', '360']


def test_values_that_stood_nowhere_are_added_and_the_source_can_stay(tmp_path):
    source, out = tmp_path / 'a.yaml', tmp_path / 'b.yaml'
    source.write_text('motor_bridge:\n  ros__parameters:\n    port: /dev/x\n')
    assert calibrate.main(['--params', str(source), *NUMBERS, '--out', str(out)]) == 0
    assert wheels(out) == pytest.approx((0.0363, 0.22), rel=1e-4)
    assert 'wheel_radius' not in source.read_text()


def test_other_nodes_in_the_file_keep_their_wheels(tmp_path):
    path, other = tmp_path / 'robot.yaml', 'other_driver:\n  ros__parameters:\n    wheel_radius: 9.0\n'
    for text in (f'{other}motor_bridge:\n  ros__parameters:\n    port: /dev/x\nnext_{other}', MANY_NODES):
        path.write_text(text)
        assert calibrate.main(['--params', str(path), *NUMBERS]) == 0
        assert wheels(path) == pytest.approx((0.0363, 0.22), rel=1e-4)
        assert path.read_text().count('wheel_radius: 9.0') == text.count('wheel_radius: 9.0')
        assert path.read_text().count('wheel_') == text.count('wheel_') + (2 if text != MANY_NODES else 0)


def test_a_pushed_robot_is_measured(params, monkeypatch):
    true = EmulatorSettings(wheel_radius=0.04, wheel_separation=0.3, encoder_noise=0.0)
    controller = EmulatedController(true, np.random.default_rng(0))
    ways = iter([(2.0, 2.0), (2.5, 2.5), (-4.7124, 4.7124), (-6.0, 6.0)])

    def ask(question):
        if 'How far' not in question:
            return ''
        left, right = (way / 0.04 for way in next(ways))
        before = controller._body.wheel_angles
        controller._body.wheel_angles = before[0] + left, before[1] + right
        return str(0.04 * left if left > 0.0 else math.degrees(0.08 * right / 0.3))

    monkeypatch.setattr('builtins.input', ask)
    with PseudoTerminal(controller, Lock()) as terminal:
        assert calibrate.main(['--params', str(params), '--port', terminal.path]) == 0
    assert wheels(params) == pytest.approx((0.04, 0.3), rel=1e-3)


RUNS = '--straight 1 1 --turn 9 9'


@pytest.mark.parametrize(
    ('content', 'arguments', 'words'),
    [
        (CONFIG.read_text(), '--straight 2 2', 'give at least one straight and one turn'),
        (CONFIG.read_text(), '--straight 2 90 --turn 360 360', 'which is implausible'),
        (CONFIG.read_text(), '--port /no/such/port', '/no/such/port does not exist'),
        (CONFIG.read_text(), '--port /no/such/port --turn 1 1', '--port measures new runs'),
        (None, RUNS, 'robot.yaml: cannot be read'),
        ('a: [', RUNS, 'robot.yaml: is no YAML'),
        ('other: {}', RUNS, 'has no /**: ros__parameters: and none of motor_bridge'),
        ('motor_bridge: {ros__parameters: {wheel_radius: -1.0}}', RUNS, 'setting wheel_radius is -1.0'),
        ('motor_bridge: {ros__parameters: {wheel_radius: 0.03}}', RUNS, 'one parameter per line'),
    ],
)
def test_bad_measures_and_files_are_one_line_and_change_nothing(tmp_path, capsys, content, arguments, words):
    path = tmp_path / 'robot.yaml'
    if content is not None:
        path.write_text(content)
    assert calibrate.main(['--params', str(path), *arguments.split()]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert words in line
    assert content is None or path.read_text() == content


def test_an_answer_that_is_no_number_and_an_early_end_are_reported(params, capsys, monkeypatch):
    def end(_):
        raise EOFError

    with PseudoTerminal(EmulatedController(EmulatorSettings(), np.random.default_rng(0)), Lock()) as terminal:
        for ask, words in ((lambda _: 'far', "'far' is not a number"), (end, 'nothing is written')):
            monkeypatch.setattr('builtins.input', ask)
            assert calibrate.main(['--params', str(params), '--port', terminal.path]) == 1
            assert words in capsys.readouterr().err
