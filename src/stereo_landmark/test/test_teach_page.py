"""Invalid options of the page are reported at start, and Ctrl-C saves a draft."""

import pytest
from pair_bag import write_pairs
from stereo_calibrations import rectified_calibration
from taught_wall import CALIBRATIONS, CAMERA, HERE, seen
from teaching_wall import meters_of

from stereo_landmark.commands.teach import main
from stereo_landmark.files.place_file import load_place, load_places
from stereo_landmark.page import teach_page

pytestmark = pytest.mark.newest_set_only


@pytest.fixture
def served(monkeypatch):
    """Call a function with the request handler instead of serving it."""

    def during(work):
        monkeypatch.setattr(teach_page, 'serve', lambda server, *_: work(server.answers))

    return during


def choose_meters(answers):
    answers.answer({'do': 'rename_place', 'name': 'hall'})
    for kind, number in meters_of(answers.session):
        assert 'error' not in answers.answer({'do': 'toggle', 'kind': kind.value, 'number': number})
    answers.answer({'do': 'add_target'})


@pytest.mark.parametrize(
    ('options', 'said'),
    [
        (('--name', '../x'), 'is not a valid place name'),
        (('--tilt', 'nan', '0'), '--tilt: roll and pitch must be finite angles'),
        (('--places', 'left.png/places'), 'is not writable'),
        (('--places', 'left.png'), 'is not writable'),
    ],
)
def test_options_that_would_fail_at_the_end_are_refused_at_the_start(
    shared_files, served, capsys, monkeypatch, options, said
):
    served(lambda _: pytest.fail('the page was opened'))
    monkeypatch.chdir(shared_files.places.parent)
    assert main(shared_files.options(*options)) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line


def test_what_was_not_saved_is_kept_as_a_draft_to_go_on_with(files, served, capsys):
    served(choose_meters)
    assert main(files.options()) == 0
    assert 'hall was not saved; continue from the draft' in capsys.readouterr().err
    assert [place.name for place in load_places(files.places)] == ['wall']
    draft = files.places / 'unsaved' / 'hall.yaml'

    def save(answers):
        assert answers.session.state.name == 'hall'
        assert 'error' not in answers.answer({'do': 'save', 'replace': False})

    served(save)
    assert main(['--place', str(draft)]) == 0
    assert capsys.readouterr().err == ''
    assert len(load_place(files.places / 'hall.yaml').targets[0].primitives) == 4


def test_an_empty_draft_is_reported(files, served, capsys):
    served(lambda answers: answers.answer({'do': 'rename_place', 'name': 'hall'}))
    assert main(files.options()) == 0
    assert 'hall was not saved, and no draft could be written' in capsys.readouterr().err


def drive(path, calibrations=CALIBRATIONS):
    return str(write_pairs(path, [(t * 10**9, seen(HERE)) for t in (1, 2)], calibrations))


def test_a_place_is_tried_in_other_drives(shared_files, served, tmp_path):
    def look(answers):
        state = answers.answer({'do': 'hello'})['state']
        assert state['pairs'] == ['as taught', 'later 0.0 s', 'later 1.0 s']
        found = answers.answer({'do': 'test', 'pair': 2})['answer']
        assert [found['x'], found['y'], found['yaw']] == pytest.approx([HERE[0], HERE[1], HERE[3]], abs=0.02)

    served(look)
    place = str(shared_files.places / 'wall.yaml')
    assert main(['--place', place, '--test-bag', drive(tmp_path / 'later')]) == 0


def test_drives_of_other_cameras_are_refused(shared_files, served, tmp_path, capsys):
    served(lambda _: pytest.fail('the page was opened'))
    wider = rectified_calibration(CAMERA), rectified_calibration(CAMERA, 0.25)
    place = str(shared_files.places / 'wall.yaml')
    assert main(['--place', place, '--test-bag', drive(tmp_path / 'other', wider)]) == 1
    assert 'other was recorded with other cameras' in capsys.readouterr().err
    assert main(['--live', '--test-bag', str(tmp_path / 'other')]) == 1
    assert 'with --live capture further pairs' in capsys.readouterr().err


@pytest.mark.parametrize('port', ['-1', '65536', 'http'])
def test_what_is_no_port_is_refused(port, capsys):
    with pytest.raises(SystemExit):
        main(['--left', 'l.png', '--right', 'r.png', '--port', port])
    assert f'{port} is not a port; choose 0 to 65535' in capsys.readouterr().err
