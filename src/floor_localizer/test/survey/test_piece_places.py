import numpy as np
import pytest

from floor_localizer.core.survey import piece_places
from floor_localizer.core.survey.piece_graph import Link, solve_graph
from floor_localizer.core.survey.piece_places import PiecePlaces

LANE = 20
DRIFT = 0.0005
"""Yaw error of each submap relative to the previous one [rad]."""


def lanes(count: int, seed: int = 3) -> tuple[np.ndarray, np.ndarray, list[list[Link]]]:
    """Submaps in lanes over a floor, their true similarities, and edges to the previous and the neighbouring one."""
    rng = np.random.default_rng(seed)
    row, along = np.divmod(np.arange(count), LANE)
    shifts = 0.5 * np.where(row % 2 == 0, along, LANE - 1 - along) + 0.1j * row
    turns = np.exp(1j * rng.uniform(-3.0, 3.0, count))
    turns[0] = 1.0
    links: list[list[Link]] = []
    for k in range(count):
        beside = 2 * LANE * (k // LANE) - 1 - k
        others = [k - 1] * (k > 0) + [beside] * (0 <= beside < k - 1)
        links.append([link_between(k, other, turns, shifts, rng) for other in others])
    return turns, shifts, links


def link_between(k: int, other: int, turns: np.ndarray, shifts: np.ndarray, rng: np.random.Generator) -> Link:
    shared = 0.5 * (shifts[k] + shifts[other]) + rng.uniform(-0.1, 0.1, 9) + 1j * rng.uniform(-0.1, 0.1, 9)
    in_first, in_second = ((shared - shifts[j]) / turns[j] for j in (other, k))
    bent = np.exp(1j * rng.normal(0.0, DRIFT))
    return Link(other, k, in_first, bent * in_second, other != k - 1)


def placed(links: list[list[Link]]) -> PiecePlaces:
    places = PiecePlaces()
    for new in links:
        places.append(1.0 + 0.0j, 0.0j)
        places.add_edges(new)
    return places


def test_pieces_lie_right_while_they_are_linked() -> None:
    turns, shifts, links = lanes(200)
    found_turns, found_shifts = placed(links).arrays()
    assert np.abs(found_shifts - shifts).max() < 0.01
    assert np.abs(found_turns - turns).max() < 0.01


def test_the_work_grows_with_the_number_of_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    sizes: list[int] = []

    def counted(turns: np.ndarray, *rest: object) -> tuple[np.ndarray, np.ndarray]:
        sizes.append(len(turns))
        return solve_graph(turns, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(piece_places, 'solve_graph', counted)
    work = []
    for count in (200, 800):
        sizes.clear()
        placed(lanes(count)[2])
        work.append(sum(sizes))
    assert work[1] < 6 * work[0]


def test_a_loop_that_was_far_off_is_mended_far_back() -> None:
    """A ring whose drift shows only when it closes, more submaps later than the sliding window."""
    count, rng = 150, np.random.default_rng(5)
    turns = np.exp(1j * rng.uniform(-3.0, 3.0, count))
    turns[0] = 1.0
    shifts = 10.0 * np.exp(2j * np.pi * np.arange(count) / count) - 10.0
    links = [[link_between(k, k - 1, turns, shifts, rng)] if k else [] for k in range(count)]
    before = placed(links)
    closing = link_between(count - 1, 0, turns, shifts, rng)
    links[-1].append(closing)
    after = placed(links)
    assert gap(before, closing) > 0.02
    assert gap(after, closing) < 0.002
    # All of the ring has moved, not only the last submaps.
    assert np.abs(after.arrays()[1] - before.arrays()[1])[10:40].min() > 0.0005


def gap(places: PiecePlaces, link: Link) -> float:
    turns, shifts = places.arrays()
    ends = (
        turns[link.first] * link.in_first + shifts[link.first],
        turns[link.second] * link.in_second + shifts[link.second],
    )
    return float(np.abs(ends[0] - ends[1]).max())
