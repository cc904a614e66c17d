"""Requests of the page: valid edits change the state, invalid ones return an error and change nothing."""

import json
from importlib.resources import files

import numpy as np
import pytest
from taught_wall import HERE, METERS, T_MAP_PLACE
from teaching_wall import images_of, meters_of, new_session, pairs_of_wall

from stereo_landmark.core.place.place_locator import NoPlaceFixReason
from stereo_landmark.core.procedure.target_search import NoDetectionReason
from stereo_landmark.core.teaching.procedure_check import Outcome, TrialRun
from stereo_landmark.core.view_localizer import ViewFault
from stereo_landmark.files.place_file import load_images, load_place
from stereo_landmark.page.place_saver import PlaceSaver
from stereo_landmark.page.request_handler import RequestHandler

pytestmark = pytest.mark.newest_set_only


@pytest.fixture
def answers(tmp_path):
    return RequestHandler(pairs_of_wall(), PlaceSaver(tmp_path))


def ask(answers, what, **fields):
    """Send requests like a browser."""
    return json.loads(json.dumps(answers.answer(json.loads(json.dumps({'do': what, **fields})))))


def choose_meters(answers, count=4):
    for kind, number in meters_of(new_session())[:count]:
        ask(answers, 'toggle', kind=kind.value, number=number)


def test_a_whole_lesson(answers, tmp_path):
    configuration = ask(answers, 'hello')['configuration']
    assert (configuration['width'], configuration['baseline']) == (376, pytest.approx(0.2))
    names = {each['name'] for each in configuration['settings']}
    assert names >= {'edges.threshold', 'tolerances.corner.angle'}
    choose_meters(answers)
    (target,) = ask(answers, 'move', name='ellipse 4', place=0)['state']['targets']
    assert [part['name'] for part in target['primitives']] == [f'ellipse {k}' for k in (4, 1, 2, 3)]
    assert target['expected']['position_sigma'] < 0.02
    trials = ask(answers, 'check', target=0)['trials']
    assert {trial['outcome'] for trial in trials} == {'found'}
    found = ask(answers, 'test', pair=1)['answer']
    assert [found['x'], found['y'], found['yaw']] == pytest.approx([HERE[0], HERE[1], HERE[3]], abs=0.02)
    ask(answers, 'rename_place', name='wall')
    ask(answers, 'set_map_pose', pose=[T_MAP_PLACE.x, T_MAP_PLACE.y, T_MAP_PLACE.yaw])
    path = ask(answers, 'save', replace=False)['saved']
    place = load_place(tmp_path / 'wall.yaml')
    assert path == str(tmp_path / 'wall.yaml')
    assert place.T_map_place == T_MAP_PLACE
    assert place.targets[0].primitives[0].name == 'ellipse 4'
    true = np.array([[3.0, meter.y, meter.z] for meter in METERS])
    assert place.coordinates.positions == pytest.approx(true[[3, 0, 1, 2]], abs=0.01)
    assert np.array_equal(load_images(tmp_path / 'wall.yaml').left, images_of(0).left)


def test_tests_are_kept_for_each_selection_and_use_the_given_tilt(answers):
    choose_meters(answers)
    level = ask(answers, 'test', pair=1)
    assert level['state']['tests']['1']['found']['target_1'] == [f'ellipse {k}' for k in (1, 2, 3, 4)]
    tilted = ask(answers, 'test', pair=1, tilt=[0.0, 0.02])['answer']
    assert tilted['x'] != level['answer']['x']
    assert ask(answers, 'move', name='ellipse 4', place=0)['state']['tests'] == {}
    assert ask(answers, 'undo')['state']['tests'].keys() == {'1'}
    assert 'roll and pitch' in ask(answers, 'test', pair=1, tilt=[0.0, 1.0])['error']


def test_every_reason_has_a_technicians_words():
    words = (files('stereo_landmark.page') / 'static' / 'words.js').read_text(encoding='utf-8')
    assert all(f"'{each.value}':" in words for each in (*NoDetectionReason, *NoPlaceFixReason, *ViewFault))


def test_sliders_get_edges_at_once_and_are_one_step(answers):
    ask(answers, 'hello')
    counts = []
    for value in (4.0, 40.0, 100.0):
        fields = {'name': 'edges.threshold', 'value': value, 'gesture': 'a', 'sides': ['left']}
        counts.append(ask(answers, 'edges', **fields)['edges']['left']['count'])
    assert counts[0] >= counts[1] >= counts[2] < counts[0]
    state = ask(answers, 'undo')['state']
    assert state['processing']['edges.threshold'] == 6.0
    assert not state['can_undo']


@pytest.mark.parametrize(
    ('request_', 'said'),
    [
        ({}, "unknown command 'None'"),
        ({'do': 'rm'}, "unknown command 'rm'"),
        ({'do': 'toggle', 'kind': 'circle', 'number': 0}, 'kind must be ellipse or'),
        ({'do': 'toggle', 'kind': 'ellipse', 'number': '0'}, 'number must be an integer'),
        ({'do': 'toggle', 'kind': 'ellipse', 'number': -1}, 'select one that is shown'),
        ({'do': 'set_region', 'region': [1, 2, 3]}, 'region must be 4 numbers'),
        ({'do': 'set_region', 'region': [1, 2, 'x', 4]}, 'region must be a number'),
        ({'do': 'set', 'name': 'edges.threshold', 'value': 1e9}, 'allowed is'),
        ({'do': 'set', 'name': 'edges.threshold', 'value': float('nan')}, 'value must be a number'),
        ({'do': 'select_pair', 'pair': 9}, 'there is no pair 10, there are 2'),
        ({'do': 'take'}, '--live only'),
        ({'do': 'check', 'target': 4}, 'there is no target 5'),
        ({'do': 'save', 'replace': False}, 'target_1 has no shape'),
        ({'do': 'rename_place', 'name': '../../etc/passwd'}, 'is not a valid place name'),
        ({'do': 'set_map_pose', 'pose': [0, 0, True]}, 'pose must be a number'),
        ({'do': 'set_map_pose', 'pose': [0, 0, 10**400]}, 'pose must be a number'),
        ({'do': 'set_map_pose', 'pose': [1e308, 0, 0]}, 'pose must be a number'),
        ({'do': 'set', 'name': 'edges.threshold', 'value': -(10**400)}, 'value must be a number'),
        ({'do': 'edges', 'sides': ['tilt']}, 'sides must be left or right'),
        ({'do': 'edges', 'sides': ['__class__']}, 'sides must be left or right'),
    ],
)
def test_an_invalid_request_returns_an_error_and_changes_nothing(answers, request_, said):
    before = answers.session.state
    answer = answers.answer(request_)
    assert said in answer['error']
    assert '\n' not in answer['error']
    assert answers.session.state is before


def test_too_few_points_are_not_saved(answers, tmp_path):
    choose_meters(answers, 1)
    assert 'too few points' in ask(answers, 'save', replace=False)['error']
    assert not list(tmp_path.iterdir())


def test_what_is_not_saved_is_known_whoever_asks(answers):
    assert ask(answers, 'hello')['state']['save_status'] == 'new'
    choose_meters(answers)
    for command, status in (
        ({'do': 'hello'}, 'unsaved'),
        ({'do': 'save', 'replace': False}, 'saved'),
        ({'do': 'show_kind', 'kind': 'corner', 'shown': True}, 'saved'),
        ({'do': 'set', 'name': 'edges.threshold', 'value': 7.0}, 'unsaved'),
        ({'do': 'reset', 'group': 'edges.'}, 'saved'),
        ({'do': 'undo'}, 'unsaved'),
        ({'do': 'undo'}, 'saved'),
        ({'do': 'set_map_pose', 'pose': [1.0, 2.0, 3.0]}, 'unsaved'),
    ):
        assert answers.answer(command)['state']['save_status'] == status


def test_red_hints_stop_a_place_from_being_saved_until_the_choice_is_another(answers, tmp_path, monkeypatch):
    choose_meters(answers)
    wrong_pose = TrialRun(('ellipse 1',), Outcome.WRONG_POSE, '0.40 m away')
    monkeypatch.setattr(answers.session, 'check', lambda _: [wrong_pose])
    refused = ask(answers, 'save', replace=False)
    assert 'not saved: target_1: without ellipse 1 a wrong position is found' in refused['error']
    assert not list(tmp_path.iterdir())
    (hint,) = refused['state']['checks']['0']['hints']
    assert hint['severity'] == 'stop'
    moved = ask(answers, 'set_map_pose', pose=[1.0, 2.0, 3.0])['state']
    assert moved['checks'] == refused['state']['checks']
    monkeypatch.undo()
    assert 'not saved' in ask(answers, 'save', replace=False)['error']
    reordered = ask(answers, 'move', name='ellipse 4', place=0)['state']
    assert reordered['checks'] == {}
    assert reordered['selection'] != moved['selection']
    assert ask(answers, 'save', replace=False)['saved']
    assert ask(answers, 'undo')['state']['selection'] == moved['selection']


def test_a_place_from_elsewhere_is_replaced_only_on_purpose(answers, tmp_path):
    choose_meters(answers)
    path = tmp_path / 'place_1.yaml'
    assert all(ask(answers, 'save', replace=False)['saved'] for _ in range(2))
    other = RequestHandler(pairs_of_wall(), PlaceSaver(tmp_path))
    choose_meters(other, 3)
    answer = ask(other, 'save', replace=False)
    assert answer['exists']
    assert 'exists' in answer['error']
    assert len(load_place(path).targets[0].primitives) == 4
    assert ask(other, 'save', replace=True)['saved']
    assert len(load_place(path).targets[0].primitives) == 3


def test_another_pair_may_be_taught_and_that_can_be_undone(answers):
    assert ask(answers, 'select_pair', pair=1)['state']['pair'] == 1
    assert ask(answers, 'undo')['state']['pair'] == 0
    assert ask(answers, 'redo')['state']['pair'] == 1
