"""Checks of the published similarities that need no random trajectory.

`composition` asks whether each Total is the product of the factors printed with it, `abstract_check` scores the
published pairs on Eq. 10 against the abstract's 97.38 %, and `pair_bounds` asks which Time values are possible
at all beside the Freq. values they are printed with.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from repro.model.dynamics import rebuild_torque, regressor
from repro.paper.published import NUMERIC_CASES, Published, PublishedValue, load_published
from repro.signals.metric import PUBLISHED_METRIC, MetricSettings, metr2ev
from repro.signals.trajectories import identification_trajectory

EXPONENT = PUBLISHED_METRIC.exponent


@dataclass(frozen=True)
class AbstractCheck:
    """The published pairs scored on the identification trajectory."""

    cells: pd.DataFrame  # ``case, joint, time, frequency, total``, fractions of 1, for N1 ... N4 and both joints
    mean: float  # of the eight totals
    minimum: float
    published: float  # what the abstract says the similarity exceeds


def _triples(numbers: Published) -> list[tuple[PublishedValue, PublishedValue, PublishedValue]]:
    """Time, Freq. and Total of each cell of Tables 7 and 10."""
    totals = (t for place in ("Table 7", "Table 10") for t in numbers.select(place=place, quantity="total"))
    return [
        (numbers[t.id.replace("/total/", "/time/")], numbers[t.id.replace("/total/", "/frequency/")], t) for t in totals
    ]


def composition(published: Published | None = None) -> pd.DataFrame:
    """Check the published Totals of Tables 7 and 10 against the factors printed with them.

    If the printed factors carry the power 0.4 already, Total = Time x Freq.; if it is put on the product afterwards,
    Total = (Time x Freq.)^0.4. A Total agrees if it lies within what the rounding of all three printed numbers allows.
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
                "place": total.place,
                "case": total.case,
                "method": total.method,
                "joint": total.joint,
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

    Table 6, which held these eight totals, is lost; the abstract says that they exceed the figure.
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


def pair_bounds(published: Published | None = None) -> pd.DataFrame:
    """What the printed Freq. values leave possible for the Time values beside them.

    Let the frequency error be d = |X/|X| - Y/|Y||. The DCT-II keeps inner products, so the signals have the cosine c =
    1 - d^2/2, and however y is scaled, |x - y|^2 >= |x|^2 (1 - c^2). So a time error of |x-y|^2 / |x|^2 is never below
    1 - c^2, whatever the torque was. A time error of mean((x-y)^2) is free of that, but bounds the torque: rms(x) <=
    sqrt(error / (1 - c^2)). With unsigned spectra |X| in the place of X the true c is smaller still, so both bounds
    stand.
    """
    numbers = load_published() if published is None else published
    rows = []
    for time, frequency, _ in _triples(numbers):
        error = 1.0 - ((time.value - time.half_step) / 100.0) ** (1.0 / EXPONENT)
        distance = 1.0 - ((frequency.value + frequency.half_step) / 100.0) ** (1.0 / EXPONENT)
        least = 1.0 - (1.0 - 0.5 * distance**2) ** 2
        rows.append(
            {
                "id": time.id.replace("/time/", "/"),
                "place": time.place,
                "case": time.case,
                "method": time.method,
                "joint": time.joint,
                "time": time.value,
                "frequency": frequency.value,
                "time_error": error,
                "least_energy_error": least,
                "energy_possible": error >= least,
                "largest_rms": np.sqrt(error / least),
            }
        )
    return pd.DataFrame(rows)
