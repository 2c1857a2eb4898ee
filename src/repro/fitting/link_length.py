"""The measured length of link 1 in the fit: I2 = 2 l1 g2 / g, one row next to those of the logs.

I2 = 2 m2 l1 lc2 and g2 = m2 g lc2 share all but the length. The standard deviation of the row is that of the length
times 2 g2 / g. A log that contradicts the length is fitted without it: times in another unit, for instance, change
inertia and not gravity.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from repro.identification.armfile import Arm
from repro.identification.regression import Regression, Relation, solve
from repro.identification.uncertainty import Perturbation, combination_variances
from repro.model.parameters import NAMES

#: Standard deviations between the measured length and the one that the logs imply, beyond which they contradict it.
MAX_LENGTH_DEVIATION = 4.0
_I2, _G2 = NAMES.index("I2"), NAMES.index("g2")


@dataclass(frozen=True)
class LinkLength:
    """The length of link 1 that the arm file states, against the one that the logs imply."""

    given: float  # m
    implied: float  # by a fit without it, m
    relation: Relation | None  # for the fit; None where the logs contradict the length


def link_length(arm: Arm, regression: Regression, perturbations: Mapping[str, Perturbation]) -> LinkLength | None:
    """Compare the length of link 1 with a regression; None if none is given or gravity does not act on link 2."""
    if arm.link_lengths is None or arm.plane == "horizontal":
        return None
    given, beta = arm.link_lengths[0], solve(regression.y, regression.tau)
    coefficients = np.zeros(len(NAMES))
    coefficients[[_I2, _G2]] = 1.0, -2.0 * given / arm.gravity
    per_metre = 2.0 * abs(float(beta[_G2])) / arm.gravity
    if per_metre == 0.0:
        return None
    relation = Relation(coefficients, arm.link_length_sd * per_metre)
    variances = combination_variances(coefficients[np.newaxis], regression, perturbations)
    deviation, sd = abs(float(coefficients @ beta)), np.sqrt(relation.sd**2 + sum(v[0] for v in variances))
    implied = float(beta[_I2] * arm.gravity / (2.0 * beta[_G2]))
    return LinkLength(given, implied, relation if deviation <= MAX_LENGTH_DEVIATION * sd else None)
