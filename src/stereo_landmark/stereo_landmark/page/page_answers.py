"""What the page asks and what it is told: one request after another, JSON in and JSON out."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from shirube_ros.file_errors import CameraFileError
from stereo_landmark.core.landmark_localizer import LandmarkSettings
from stereo_landmark.core.place.place_fix import NoPlaceFix
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching import edits
from stereo_landmark.core.teaching.teaching_session import StereoImages, TeachingSession
from stereo_landmark.core.teaching.teaching_state import TeachingState
from stereo_landmark.core.teaching.weak_choices import weak_procedure
from stereo_landmark.page import request_fields as read
from stereo_landmark.page.page_edits import EDITS
from stereo_landmark.page.pair_source import PairSource
from stereo_landmark.page.place_saver import PlaceExistsError, PlaceSaver
from stereo_landmark.page.request_fields import Request
from stereo_landmark.page.snapshot import answer_entry, edges, greeting, hint_entries, snapshot

Answer = dict[str, Any]


class PageAnswers:
    """Answers the requests of a page; not to be called by two threads at once.

    A request names what to do in its field ``do``. Every answer to a step holds the whole new ``state``; a step that
    cannot be made is answered by ``error``, one line, and changes nothing.

    Args:
        source: of the pairs of images.
        saver: keeps what was taught.
        state: to begin with, None for an empty place.
        settings: with which targets are tried, None for the defaults.
    """

    def __init__(
        self,
        source: PairSource,
        saver: PlaceSaver,
        state: TeachingState | None = None,
        settings: LandmarkSettings | None = None,
    ) -> None:
        self._source = source
        self._saver = saver
        self.session = TeachingSession(source.images, source.rig, state, settings)
        self._others: dict[str, Callable[[Request], Answer]] = {
            'hello': lambda _: {'greeting': greeting(source), **self._state()},
            'snapshot': lambda _: self._state(),
            'undo': lambda _: self._step_back(self.session.history.undo),
            'redo': lambda _: self._step_back(self.session.history.redo),
            'toggle': self._toggle,
            'edges': self._edges,
            'take_pair': self._take_pair,
            'take': self._take,
            'check': self._check,
            'test': self._test,
            'save': self._save,
        }

    def images(self, number: int) -> StereoImages:
        """Return a pair of images.

        Raises:
            StereoLandmarkError: there is none of that number, or it is no rectified pair.
            CameraFileError: its files cannot be used.
        """
        return self._source.images(number)

    def answer(self, request: Request) -> Answer:
        """Return the answer to a request."""
        name = str(request.get('do'))
        try:
            if name in EDITS:
                self._edit(name, request)
                return self._state()
            if name in self._others:
                return self._others[name](request)
        except PlaceExistsError as fault:
            return {'error': str(fault), 'exists': True}
        except (StereoLandmarkError, CameraFileError) as fault:
            return {'error': str(fault)}
        except OSError as fault:
            return {'error': f'{fault.filename or "the place"}: {fault.strerror}; choose a writable place'}
        return {'error': f'request: there is nothing called {name!r} to do; reload the page'}

    def _edit(self, name: str, request: Request) -> None:
        self.session.do(lambda state: EDITS[name](state, request), str(request.get('gesture', '')))

    def _state(self) -> Answer:
        return {'state': snapshot(self.session, self._source)}

    def _step_back(self, step: Callable[[], None]) -> Answer:
        step()
        return self._state()

    def _toggle(self, request: Request) -> Answer:
        self.session.toggle(read.kind(request), read.whole(request, 'number'))
        return self._state()

    def _edges(self, request: Request) -> Answer:
        """Draw the edges with a number that is being changed; the detectors wait for the end of the movement."""
        if 'name' in request:
            self._edit('set', request)
        images = self.session.images
        wanted = read.sides(request)
        return {'edges': {side: edges(self.session.segments(getattr(images, side))) for side in wanted}}

    def _take_pair(self, request: Request) -> Answer:
        number = read.whole(request, 'pair')
        self.images(number)
        self.session.do(partial(edits.take_pair, pair=number))
        return self._state()

    def _take(self, _: Request) -> Answer:
        number = self._source.take()
        self.session.do(partial(edits.take_pair, pair=number))
        return self._state()

    def _check(self, request: Request) -> Answer:
        number = read.whole(request, 'target')
        edits.work_on_target(self.session.state, number)
        trials = self.session.check(number)
        rows = [
            {'hidden': list(trial.hidden), 'outcome': trial.outcome.value, 'detail': trial.detail}
            for trial in trials
        ]
        name = self.session.state.targets[number].name
        return {'trials': rows, 'hints': hint_entries(weak_procedure(name, trials))}

    def _test(self, request: Request) -> Answer:
        return {'answer': answer_entry(self.session.locate(read.whole(request, 'pair')))}

    def _save(self, request: Request) -> Answer:
        place = self.session.place()
        for draft in self.session.state.targets:
            fix = self.session.report(draft).fix
            if isinstance(fix, NoPlaceFix):
                raise StereoLandmarkError(f'target {draft.name}: {fix.reason.value} ({fix.detail})')
        path = self._saver.save(place, self.session.images, replace=read.flag(request, 'replace'))
        return {'saved': str(path)}
