"""What a benchmark measures: figures with their standard errors, and when two of them differ."""

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

RATIO_TOLERANCE = 0.05  # of ratios of time; loads and caches change them by less
STANDARD_ERRORS = 2.0

Values = dict[str, tuple[float, float]]


@dataclass(frozen=True)
class Figure:
    """One figure of a table.

    Attributes:
        kind: 'ratio' of times, 'rate', 'error', 'time' or 'count'.
        text: the cell of the table.
        values: what is compared, by name: value and standard error.
        better: 'lower', 'higher', 'one' (nearer to 1) or '' (a change is neither better nor worse).
    """

    kind: str
    text: str
    values: Values
    better: str = 'lower'

    def as_json(self) -> dict[str, Any]:
        """Return it for a JSON file; five digits are enough to compare."""
        values = {name: [_rounded(number) for number in pair] for name, pair in self.values.items()}
        return asdict(self) | {'values': values}


@dataclass(frozen=True)
class Change:
    """A value that left its tolerance; ``verdict`` is 'better', 'worse' or 'other'."""

    name: str
    before: float
    after: float
    verdict: str


def figure_from_json(found: dict[str, Any]) -> Figure:
    """Return the figure of `Figure.as_json`."""
    values = {}
    for name, (value, sigma) in found['values'].items():
        values[name] = (math.nan if value is None else value, sigma or 0.0)
    return Figure(found['kind'], found['text'], values, found['better'])


def changes(before: Figure, after: Figure) -> list[Change]:
    """Return the values that differ by more than 5 % (ratios of time) and by more than two standard errors."""
    if after.kind == 'time':
        return []
    found = []
    for name in before.values.keys() & after.values.keys():
        (a, sigma_a), (b, sigma_b) = before.values[name], after.values[name]
        tolerance = STANDARD_ERRORS * math.hypot(sigma_a, sigma_b)
        if after.kind == 'ratio':
            tolerance = max(tolerance, RATIO_TOLERANCE * abs(a))
        # NaN stands for what was not found at all.
        if math.isnan(a) != math.isnan(b) or abs(b - a) > tolerance + 1e-4 * abs(a):
            found.append(Change(name, a, b, _verdict(a, b, after.better)))
    return sorted(found, key=lambda change: change.name)


def _verdict(before: float, after: float, better: str) -> str:
    if not better:
        return 'other'
    if math.isnan(before) or math.isnan(after):
        return 'worse' if math.isnan(after) else 'better'
    if better == 'one':
        is_better = abs(math.log(max(after, 1e-12))) < abs(math.log(max(before, 1e-12)))
    else:
        is_better = (after < before) == (better == 'lower')
    return 'better' if is_better else 'worse'


def rate(count: int, total: int, better: str = 'higher', form: str = '') -> Figure:
    """Return how many of all; its standard error is the binomial one, with Laplace's rule near 0 and 1.

    Args:
        count: number of successes.
        total: number of tries.
        better: see `Figure`.
        form: 'percent' for the share alone.
    """
    share = (count + 1) / (total + 2)
    sigma = math.sqrt(share * (1.0 - share) / max(total, 1))
    text = percent(count / max(total, 1)) if form == 'percent' else f'{count} of {total}'
    return Figure('rate', text, {'': (count / max(total, 1), sigma)}, better)


def outcomes(verdicts: Iterable[str], kinds: Sequence[str] = ('right', 'none', 'wrong')) -> Figure:
    """Return the numbers of right, no and wrong poses; what is not right and what is wrong is compared."""
    found = Counter(verdicts)
    total = found.total()
    wrong = rate(found[kinds[-1]], total).values['']
    values = {f'not {kinds[0]}': rate(total - found[kinds[0]], total).values[''], kinds[-1]: wrong}
    return Figure('rate', ' / '.join(str(found[kind]) for kind in kinds), values)


def error(
    samples: ArrayLike,
    form: str = '.2f',
    scale: float = 1.0,
    shown: Sequence[float] = (50.0, 95.0, 100.0),
    better: str = 'lower',
) -> Figure:
    """Return percentiles of errors; median and 95 % are compared, by the standard errors of their order statistics.

    Args:
        samples: errors, shape (n,); those that are not finite are left out.
        form: format of a number.
        scale: factor from the samples' unit to the table's.
        shown: percentiles of the cell.
        better: see `Figure`.
    """
    values = np.sort(_finite(samples, scale))
    if not len(values):
        return Figure('error', '–', {'median': (math.nan, 0.0)}, better)
    compared = {'median': _quantile(values, 0.5), '95 %': _quantile(values, 0.95)}
    return Figure('error', _percentiles(values, form, shown), compared, better)


def rms(samples: ArrayLike, form: str = '.3f', scale: float = 1.0, better: str = 'lower') -> Figure:
    """Return the root mean square of errors, shape (n,) or (n, k), NaN left out.

    Errors over their standard deviations have ``better='one'``.
    """
    squares = _finite(samples, scale) ** 2
    if not len(squares):
        return Figure('error', '–', {'rms': (math.nan, 0.0)}, better)
    value = math.sqrt(squares.mean())
    sigma = float(squares.std()) / math.sqrt(len(squares)) / (2.0 * value) if value else 0.0
    return Figure('error', format(value, form), {'rms': (value, sigma)}, better)


def mean(samples: ArrayLike, form: str = '.3f', scale: float = 1.0, better: str = 'lower') -> Figure:
    """Return the mean of samples, shape (n,)."""
    values = scale * np.asarray(samples, dtype=np.float64)
    if not len(values):
        return Figure('error', '–', {'mean': (math.nan, 0.0)}, better)
    sigma = float(values.std()) / math.sqrt(len(values))
    return Figure('error', format(values.mean(), form), {'mean': (float(values.mean()), sigma)}, better)


def time(samples: ArrayLike, form: str = '.2f', shown: Sequence[float] = (50.0, 95.0)) -> Figure:
    """Return percentiles of times [ms]; they are those of this machine and not compared."""
    values = np.sort(_finite(samples))
    if not len(values):
        return Figure('time', '–', {})
    return Figure('time', _percentiles(values, form, shown), {'median': _quantile(values, 0.5)})


def ratio(ours: ArrayLike, theirs: ArrayLike, form: str = '.3g', better: str = 'lower') -> Figure:
    """Return the median of times over that of others, measured side by side."""
    (a, sigma_a), (b, sigma_b) = (_quantile(np.sort(np.asarray(x, dtype=float)), 0.5) for x in (ours, theirs))
    value = a / b
    sigma = value * math.hypot(sigma_a / a, sigma_b / b)
    return Figure('ratio', format(value, form), {'ratio': (value, sigma)}, better)


def count(number: float, form: str = 'g', unit: str = '', better: str = '') -> Figure:
    """Return a number that is the same in each run."""
    return Figure('count', f'{number:{form}}{unit}', {'': (float(number), 0.0)}, better)


def measured(number: float, form: str = '.3g', unit: str = '') -> Figure:
    """Return a time, a size of memory or a load of this machine; not compared."""
    return Figure('time', f'{number:{form}}{unit}', {'': (float(number), 0.0)})


def percent(share: float) -> str:
    """Return a share as per cent, without zeros behind the point."""
    return f'{100.0 * share:.2f}'.rstrip('0').rstrip('.')


def _finite(samples: ArrayLike, scale: float = 1.0) -> np.ndarray[Any, Any]:
    values = scale * np.asarray(samples, dtype=np.float64).ravel()
    return values[np.isfinite(values)]


def _percentiles(values: np.ndarray[Any, Any], form: str, shown: Sequence[float]) -> str:
    return ' / '.join(format(value, form) for value in np.percentile(values, shown))


def _quantile(ordered: np.ndarray[Any, Any], share: float) -> tuple[float, float]:
    """Return a quantile of sorted values and its standard error: half of what lies between the ranks one sigma off."""
    total = len(ordered)
    if total == 1:
        return float(ordered[0]), abs(float(ordered[0]))
    off = math.sqrt(share * (1.0 - share) / total)
    low, middle, high = np.quantile(ordered, np.clip([share - off, share, share + off], 0.0, 1.0)).tolist()
    return middle, 0.5 * (high - low)


def _rounded(number: float) -> float | None:
    return float(f'{number:.5g}') if math.isfinite(number) else None
