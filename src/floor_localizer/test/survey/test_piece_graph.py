import numpy as np

from floor_localizer.core.survey.piece_graph import Link, connected_parts, solve_graph


def ring(count: int = 12) -> tuple[np.ndarray, np.ndarray, list[Link]]:
    """Submaps around a ring with true similarities, each with an edge of shared dots to the next one."""
    rng = np.random.default_rng(3)
    turns = np.exp(1j * rng.uniform(-3.0, 3.0, count)) * (1.0 + rng.normal(0.0, 0.0001, count))
    shifts = np.exp(1j * 2 * np.pi * np.arange(count) / count)
    turns[0], links = 1.0, []
    for k in range(count):
        other = (k + 1) % count
        shared = (
            0.5 * (shifts[k] + shifts[other]) + rng.uniform(-0.1, 0.1, 9) + 1j * rng.uniform(-0.1, 0.1, 9)
        )
        first, second = ((shared - shifts[j]) / turns[j] for j in (k, other))
        links.append(Link(k, other, first, second, other == 0))
    return turns, shifts, links


def test_the_true_places_come_back_from_nowhere() -> None:
    turns, shifts, links = ring()
    start = turns / np.abs(turns)
    found_turns, found_shifts = solve_graph(
        start, np.where(np.arange(12) == 0, shifts, 0.0), np.arange(12), links, np.arange(12) > 0, 0.0001
    )
    np.testing.assert_allclose(found_shifts, shifts, atol=0.0005)
    np.testing.assert_allclose(found_turns, turns, atol=0.0005)


def test_parts_without_a_link_are_told_apart() -> None:
    links = ring()[2]
    parts = connected_parts(13, [link for link in links if link.first not in (3, 8)])
    assert len(set(parts)) == 3
    assert parts[4] == parts[8] != parts[9]
    assert list(parts).count(parts[12]) == 1
