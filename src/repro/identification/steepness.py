"""Steepness lambda of the Coulomb friction's tanh chosen from the log: the one that Eq. 1 fits best with."""

from dataclasses import replace

import numpy as np

from repro.identification.parallel import FilterSettings, prepare
from repro.identification.solve import solve
from repro.logs.log import Log

#: Values tried, s/rad: from friction that sets in over 0.2 rad/s to one that is a step for any encoder.
TRIED = (5.0, 10.0, 20.0, 50.0, 100.0, 200.0)


def choose_steepness(log: Log, settings: FilterSettings) -> float:
    """Lambda of Eq. 1 with the smallest sum of squared errors, each joint over its torque's energy.

    Parameters
    ----------
    log : Log
        Evenly sampled.
    settings : FilterSettings
        Filter; its own lambda is not used.

    Returns
    -------
    float
        One of `TRIED`, s/rad.
    """
    errors = []
    for steepness in TRIED:
        r = prepare(log, replace(settings, friction_steepness=steepness))
        weight = 1.0 / np.mean(r.tau**2, axis=-1, keepdims=True)
        errors.append(float(np.sum(weight * (r.tau - r.y @ solve(r.y, r.tau, weight)) ** 2)))
    return TRIED[int(np.argmin(errors))]
