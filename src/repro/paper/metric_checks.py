"""Checks of the published similarities that need no random motion.

- `composition` compares each Total with the product of the factors printed with it.
- `abstract_check` scores the published pairs on Eq. 10 and compares them with the abstract's 97.38 %.
- `pair_bounds` computes which Time values are possible with the Freq. values printed next to them.
- `torque_bounds` and `least_squares_torque` compute how large the torques of Table 10 can be.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from repro.model.dynamics import rebuild_torque, regressor
from repro.paper.published import NUMERIC_CASES, Published, PublishedValue, load_published
from repro.signals.metric import PUBLISHED_METRIC, MetricSettings, metr2ev
from repro.signals.trajectories import identification_trajectory

EXPONENT = PUBLISHED_METRIC.exponent

_FACTORS = ("time", "frequency")
_CELL = ("place", "case", "method", "joint")


@dataclass(frozen=True)
class AbstractCheck:
    """The published pairs scored on the identification trajectory."""

    cells: pd.DataFrame  # ``case, joint, time, frequency, total``, fractions of 1, for N1 ... N4 and both joints
    mean: float  # of the eight totals
    minimum: float
    published: float  # the similarity that the numeric tests exceed according to the abstract


def _triples(numbers: Published) -> list[tuple[PublishedValue, PublishedValue, PublishedValue]]:
    """Time, Freq. and Total of each cell of Tables 7 and 10."""
    totals = (t for place in ("Table 7", "Table 10") for t in numbers.select(place=place, quantity="total"))
    return [
        (numbers[t.id.replace("/total/", "/time/")], numbers[t.id.replace("/total/", "/frequency/")], t) for t in totals
    ]


def composition(published: Published | None = None) -> pd.DataFrame:
    """Check the published Totals of Tables 7 and 10 against the factors printed with them.

    If the power 0.4 is part of the printed factors, Total = Time x Freq. If it is applied to their product, Total =
    (Time x Freq.)^0.4. A Total agrees if the difference is within the rounding of all three printed numbers.
    """
    numbers = load_published() if published is None else published
    rows = []
    for time, frequency, total in _triples(numbers):
        product = time.value * frequency.value / 100.0
        # First order in the half steps: their product, 2.5e-7 %, is far below any difference found.
        spread = (time.half_step * frequency.value + frequency.half_step * time.value) / 100.0
        power_last = 100.0 * (product / 100.0) ** EXPONENT
        rows.append(
            {
                "id": total.id,
                **{name: getattr(total, name) for name in _CELL},
                "time": time.value,
                "frequency": frequency.value,
                "total": total.value,
                "product": product,
                "difference": total.value - product,
                "tolerance": total.half_step + spread,
                "agrees": abs(total.value - product) <= total.half_step + spread,
                "agrees_power_last": abs(total.value - power_last) <= total.half_step + spread,
            }
        )
    return pd.DataFrame(rows)


def abstract_check(
    published: Published | None = None, settings: MetricSettings = PUBLISHED_METRIC, h: float = 2.5e-3
) -> AbstractCheck:
    """Score the pairs of Tables 4 and 5 on Eq. 10 with ``metr2ev``, against the abstract's 97.38 %.

    Table 6, which contained these eight totals, is lost. According to the abstract they exceed this percentage.
    """
    numbers = load_published() if published is None else published
    motion = identification_trajectory(h=h)
    y = regressor(motion.q, motion.dq, motion.ddq)
    actual = rebuild_torque(y, numbers.parameter_sets("true"))
    s = metr2ev(actual, rebuild_torque(y, numbers.parameter_sets("algorithm1")), settings)
    cells = pd.DataFrame(
        {
            "case": np.repeat(NUMERIC_CASES, 2),
            "joint": np.tile([1, 2], len(NUMERIC_CASES)),
            "time": s.time.ravel(),
            "frequency": s.frequency.ravel(),
            "total": s.total.ravel(),
        }
    )
    stated = numbers["abstract/numeric/total"].value / 100.0
    return AbstractCheck(cells, float(s.total.mean()), float(s.total.min()), stated)


def _time_error(time: PublishedValue, step: float = 0.0) -> float:
    """Error of a printed Time value, with the value moved by `step` half steps of its last digit."""
    return float(1.0 - ((time.value + step * time.half_step) / 100.0) ** (1.0 / EXPONENT))


def _least_energy_error(frequency: PublishedValue, step: float = 0.0) -> float:
    """Least |x-y|^2 / |x|^2 that a printed Freq. value permits, with the value moved by `step` half steps."""
    distance = 1.0 - ((frequency.value + step * frequency.half_step) / 100.0) ** (1.0 / EXPONENT)
    return float(1.0 - (1.0 - 0.5 * distance**2) ** 2)


def pair_bounds(published: Published | None = None) -> pd.DataFrame:
    """Compute which Time values are possible with the printed Freq. values.

    Let the frequency error be d = |X/|X| - Y/|Y||. The DCT-II preserves inner products, so the signals have the cosine
    c = 1 - d^2/2, and |x - y|^2 >= |x|^2 (1 - c^2) for any scale of y. A time error |x-y|^2 / |x|^2 is therefore at
    least 1 - c^2 for any torque. A time error mean((x-y)^2) has no such limit, but it bounds the torque: rms(x) <=
    sqrt(error / (1 - c^2)). With unsigned spectra |X| instead of X the true c is smaller, and both bounds remain valid.
    """
    numbers = load_published() if published is None else published
    rows = []
    for time, frequency, _ in _triples(numbers):
        error, least = _time_error(time, -1.0), _least_energy_error(frequency, 1.0)
        rows.append(
            {
                "id": time.id.replace("/time/", "/"),
                **{name: getattr(time, name) for name in _CELL},
                "time": time.value,
                "frequency": frequency.value,
                "time_error": error,
                "least_energy_error": least,
                "energy_possible": error >= least,
                "largest_rms": np.sqrt(error / least),
            }
        )
    return pd.DataFrame(rows)


def torque_bounds(published: Published | None = None) -> pd.DataFrame:
    """Compute the largest mean-square torque of each motion and joint of Table 10, in (N m)^2.

    The bound of `pair_bounds` applies to the actual torque, which is the same for both methods, so the smaller bound
    counts. `published_method` is the method whose pair gives it. The time error is assumed to be mean((x-y)^2) in N m.
    """
    bounds = pair_bounds(published)
    bounds = bounds[bounds["place"] == "Table 10"]
    smallest = bounds.loc[bounds.groupby(["case", "joint"], sort=False)["largest_rms"].idxmin()]
    table = smallest[["case", "joint"]].assign(
        largest_mean_square=smallest["largest_rms"] ** 2, published_method=smallest["method"]
    )
    return table.reset_index(drop=True)


def least_squares_torque(published: Published | None = None) -> pd.DataFrame:
    """Estimate the mean-square torque of the identification run from the pairs of least squares, in (N m)^2.

    The bound of `pair_bounds` is reached by a rebuilt torque with the best scale. Least squares minimises the squared
    error on this run, but over both joints with common parameters, so that the scale of a single joint need not be the
    best. `low` and `high` are the limits from the rounding of both printed numbers. An estimate is `possible` if it is
    below the bound of Algorithm 1, whose torque is the same; otherwise it is an upper bound only.
    """
    numbers = load_published() if published is None else published
    bounds = pair_bounds(numbers).set_index("id")["largest_rms"] ** 2
    rows = []
    for joint in (1, 2):
        time, frequency = (numbers[f"table10/ID/least-squares/{factor}/joint{joint}"] for factor in _FACTORS)
        low, estimate, high = (_time_error(time, -s) / _least_energy_error(frequency, s) for s in (-1.0, 0.0, 1.0))
        possible = bool(low <= bounds[f"table10/ID/algorithm1/joint{joint}"])
        rows.append({"joint": joint, "mean_square": estimate, "low": low, "high": high, "possible": possible})
    return pd.DataFrame(rows)
