"""Handles the requests of the page sequentially, with JSON requests and responses."""

from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from enum import Enum
from functools import partial
from typing import Any

from shirube_ros.errors import CameraFileError
from stereo_landmark.core.landmark_localizer import LandmarkFix, NoLandmarkFix
from stereo_landmark.core.settings import LandmarkSettings
from stereo_landmark.core.stereo import StereoImages
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching import edits
from stereo_landmark.core.teaching.edits import TeachingState
from stereo_landmark.core.teaching.hints import Severity
from stereo_landmark.core.teaching.procedure_check import check_trials
from stereo_landmark.core.teaching.teaching_session import TeachingSession
from stereo_landmark.page import page_edits as read
from stereo_landmark.page.page_edits import EDITS, Request
from stereo_landmark.page.pair_source import StereoPairs
from stereo_landmark.page.place_saver import PlaceExistsError, PlaceSaver
from stereo_landmark.page.snapshot import configuration, edges, hint_entries, snapshot, test_result, test_summary

Answer = dict[str, Any]


class SaveStatus(Enum):
    """Save status of the place."""

    NEW = 'new'
    """No edits yet."""
    UNSAVED = 'unsaved'
    SAVED = 'saved'


class RequestHandler:
    """Handles the requests of a page; not thread-safe.

    The field ``do`` of a request names the command. The response to an edit contains the whole new ``state``; a
    rejected edit returns ``error``, one line, and changes nothing.

    Args:
        source: source of the stereo pairs.
        saver: writer of the places.
        state: initial state, None for an empty place.
        settings: localization settings for tests, None for the defaults.
        results: results of the pairs with the initial state, as a teach drive gives them.
    """

    def __init__(
        self,
        source: StereoPairs,
        saver: PlaceSaver,
        state: TeachingState | None = None,
        settings: LandmarkSettings | None = None,
        results: Sequence[LandmarkFix | NoLandmarkFix] = (),
    ) -> None:
        self._source = source
        self._saver = saver
        self.session = TeachingSession(source.images, source.rig, state, settings)
        self._initial_content = self.session.state.content_key
        self._saved_content = self._initial_content if saver.is_own(self.session.state.name) else None
        self._selection_numbers: dict[Hashable, int] = {}
        self._checks: dict[tuple[int, int], Answer] = {}
        self._tests: dict[tuple[int, int], Answer] = {}
        for pair, result in enumerate(results):
            self._tests[self._selection_number, pair] = test_result(result)
        self._steps: dict[str, Callable[[Request], None]] = {
            'snapshot': lambda _: None,
            'undo': lambda _: self.session.undo(),
            'redo': lambda _: self.session.redo(),
            'toggle': lambda r: self.session.toggle(read.kind(r), read.integer(r, 'number')),
            'select_pair': self._select_pair,
            'remove_refused': lambda _: self.session.remove_refused(),
            'take': lambda _: self._use_pair(source.capture()),
        }
        """Commands that are answered by the state after them, as edits are."""
        self._handlers: dict[str, Callable[[Request], Answer]] = {
            'hello': lambda _: {'configuration': configuration(source), **self._state()},
            'edges': self._edges,
            'check': self._check,
            'test': self._test,
            'save': self._save,
        }

    def images(self, number: int) -> StereoImages:
        """Return a stereo pair.

        Raises:
            StereoLandmarkError: the number does not exist, or the pair is not rectified.
            CameraFileError: its files are malformed.
        """
        return self._source.images(number)

    @property
    def save_status(self) -> SaveStatus:
        """Whether there are unsaved changes."""
        work = self.session.state.content_key
        if work == self._saved_content:
            return SaveStatus.SAVED
        return SaveStatus.NEW if work == self._initial_content else SaveStatus.UNSAVED

    @property
    def display_state(self) -> Hashable:
        """State shared by all pages; pages need no update while it is equal."""
        return self.session.state, self._saved_content, len(self._checks), len(self._tests)

    def answer(self, request: Request) -> Answer:
        """Handle a request and return the response."""
        name = str(request.get('do'))
        try:
            if name in self._handlers:
                return self._handlers[name](request)
            if name in EDITS:
                self._edit(name, request)
            elif name in self._steps:
                self._steps[name](request)
            else:
                return {'error': f'request: unknown command {name!r}; reload the page'}
            return self._state()
        except PlaceExistsError as fault:
            return {'error': str(fault), 'exists': True}
        except (StereoLandmarkError, CameraFileError) as fault:
            return {'error': str(fault)}
        except OSError as fault:
            return {'error': f'{fault.filename or "the place"}: {fault.strerror}; choose a writable place'}

    def _edit(self, name: str, request: Request) -> None:
        self.session.apply(lambda state: EDITS[name](state, request), str(request.get('gesture', '')))

    def _state(self) -> Answer:
        selection = self._selection_number
        checks, tests = (
            {number: result for (of, number), result in results.items() if of == selection}
            for results in (self._checks, self._tests)
        )
        shown = {**snapshot(self.session, self._source), 'selection': selection, 'checks': checks}
        shown['tests'] = {pair: test_summary(result) for pair, result in tests.items()}
        return {'state': {**shown, 'save_status': self.save_status.value}}

    @property
    def _selection_number(self) -> int:
        """Number of the current selection; the same selection has the same number, also after undo."""
        return self._selection_numbers.setdefault(self.session.state.selection_key, len(self._selection_numbers))

    def _edges(self, request: Request) -> Answer:
        """Return the edges with a setting that is being changed; the detectors run after the gesture ends."""
        if 'name' in request:
            self._edit('set', request)
        images = self.session.images
        wanted = read.sides(request)
        return {'edges': {side: edges(self.session.segments(getattr(images, side))) for side in wanted}}

    def _select_pair(self, request: Request) -> None:
        number = read.integer(request, 'pair')
        self.images(number)
        self._use_pair(number)

    def _use_pair(self, number: int) -> None:
        self.session.apply(partial(edits.select_pair, pair=number))

    def _check(self, request: Request) -> Answer:
        number = read.integer(request, 'target')
        edits.activate_target(self.session.state, number)
        return {**self._check_target(number), **self._state()}

    def _check_target(self, number: int) -> Answer:
        """Test the procedure tree of a target, once for each selection."""
        key = self._selection_number, number
        if key not in self._checks:
            trials = self.session.check(number)
            rows = [
                {'hidden': list(trial.hidden), 'outcome': trial.outcome.value, 'detail': trial.detail}
                for trial in trials
            ]
            name = self.session.state.targets[number].name
            self._checks[key] = {'trials': rows, 'hints': hint_entries(check_trials(name, trials))}
        return self._checks[key]

    def _test(self, request: Request) -> Answer:
        """Test the selection on a pair, with its tilt or a given one; the latest result of each pair is shown."""
        pair = read.integer(request, 'pair')
        tilt = read.tilt(request) or self.images(pair).tilt
        answer = {**test_result(self.session.locate(pair, tilt)), 'pair': pair, 'tilt': list(tilt)}
        self._tests[self._selection_number, pair] = answer
        return {'answer': answer, **self._state()}

    def _save(self, request: Request) -> Answer:
        replace = read.flag(request, 'replace')
        place = self.session.place()
        stop = next(self._blocking_hints(), None)
        if stop is not None:
            return {'error': f'not saved: {stop["target"]}: {stop["text"]}', **self._state()}
        path = self._saver.save(place, self.session.images, replace=replace)
        self._saved_content = self.session.state.content_key
        return {'saved': str(path), 'left_out': self.session.left_out, **self._state()}

    def _blocking_hints(self) -> Iterator[dict[str, str]]:
        """Yield the hints that prevent saving, the cheap checks first."""
        targets = self.session.state.targets
        for target in targets:
            yield from _select_blocking(hint_entries(self.session.report(target).hints))
        for number in range(len(targets)):
            yield from _select_blocking(self._check_target(number)['hints'])


def _select_blocking(hints: Iterable[dict[str, str]]) -> Iterator[dict[str, str]]:
    return (hint for hint in hints if hint['severity'] == Severity.STOP.value)
