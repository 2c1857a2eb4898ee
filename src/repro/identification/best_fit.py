"""Steepness of the Coulomb friction's tanh and delay of the torque: those that Eq. 1 fits the log best with.

A board that holds its torque over a sampling period acts half a period late; drives and buses add to it. The sum of
squared errors of ordinary least squares is close to a parabola about the true delay.
"""

from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from repro.identification.filtering import FilterSettings, prepare
from repro.identification.regression import correlation_time
from repro.identification.solve import solve
from repro.logs.log import Log
from repro.model.parameters import Array

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


#: Delays looked at, s.
REACH = 0.02
POINTS = 11


def estimate_delay(log: Log, settings: FilterSettings) -> tuple[float, float]:
    """Delay of the torque.

    Parameters
    ----------
    log : Log
        Uniformly sampled.
    settings : FilterSettings
        Filter; its own delay is not used.

    Returns
    -------
    tuple of 2 floats
        Delay, at most `REACH` to either side, and its standard error, s.
    """
    late = np.linspace(-REACH, REACH, POINTS)
    pieces = [_delayed(piece, settings, late) for piece in log.pieces]
    y, tau, h = np.concatenate([y for y, _, _ in pieces], 1), np.concatenate([x for _, x, _ in pieces], 2), pieces[0][2]
    left = np.stack([x - y @ solve(y, x) for x in tau])
    error = np.sum(left**2, axis=(1, 2))
    best = int(np.clip(error.argmin(), 1, POINTS - 2))
    curve, slope, _ = np.polyfit(late[best - 1 : best + 2] - late[best], error[best - 1 : best + 2], 2)
    if curve <= 0.0:
        return float(late[error.argmin()]), REACH
    found = float(np.clip(late[best] - slope / (2.0 * curve), -REACH, REACH))
    if abs(found) >= REACH:  # the best delay lies beyond: nothing is known of it
        return found, REACH
    # The sum of squares grows by its mean over independent samples within a standard error of the minimum.
    independent = left[best].size * h / correlation_time(left[best], h)
    spread = float(np.sqrt(error.min() / independent / curve))
    return found, min(spread, REACH)


def _delayed(log: Log, settings: FilterSettings, late: Array) -> tuple[Array, Array, float]:
    """Regressor of a piece of a log, its torque with each delay, shape (len(late), 2, n), and time between samples."""
    plain = prepare(log, replace(settings, delay=0.0))
    t = plain.t
    inside = slice(*np.searchsorted(t, [t[0] + REACH, t[-1] - REACH]))
    fine = prepare(log, replace(settings, delay=0.0, samples_per_cycle=np.inf))
    curve_of = CubicSpline(fine.t, fine.tau, axis=-1)
    return plain.y[:, inside], np.stack([curve_of(t[inside] - d) for d in late]), plain.h
