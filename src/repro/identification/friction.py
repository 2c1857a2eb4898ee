"""Friction beyond Eq. 1: in proportion to the load, and larger near rest (Stribeck), of each joint.

Each is a column beside the nine (`repro.identification.more_columns`), and is taken if it is at least `SURE` standard
errors above none. Coulomb friction that differs between the two directions is not among them: while a
joint moves it is an offset of its torque, and that is looked for as a fault.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from repro.identification.alternatives import columns_of, load_friction, stribeck
from repro.identification.filtering import FilterSettings, motion, prepare
from repro.identification.more_columns import SURE, beside, best_set, fitted_with_errors, rows, unseen
from repro.identification.regression import drop_standstill
from repro.identification.solve import solve
from repro.logs.log import Log, period
from repro.model.parameters import NAMES, Array

#: In the order of the columns.
TERMS = ("load1", "load2", "stribeck1", "stribeck2")
#: Share of the squared error of parts not fitted beyond which a term that is left out is told.
HELPS = 0.05


@dataclass(frozen=True)
class Term:
    """Friction that Eq. 1 does not hold.

    Attributes
    ----------
    name : str
        Of `TERMS`.
    value, error : float
        Size and its standard error: friction over load, or N m at rest on top of k.
    gain : float
        Share of the squared error of parts not fitted that it takes, beside the other terms that are taken.
    taken : bool
        Whether it is taken out of the torque.
    """

    name: str
    value: float
    error: float
    gain: float
    taken: bool


def _made(moved: tuple[Array, Array, Array], beta: Array, steepness: float) -> Array:
    return np.concatenate([make(moved, beta, steepness) for make in (load_friction, stribeck)], axis=-1)


def columns_of_terms(log: Log, settings: FilterSettings, beta: Array, terms: Sequence[Term]) -> Array:
    """Columns of terms through the filters of the regressor, shape (2, n, k)."""
    return columns_of([_made], log, settings, beta)[0][..., [TERMS.index(term.name) for term in terms]]


def find_terms(log: Log, settings: FilterSettings, take: bool) -> tuple[Term, ...]:
    """Friction terms that a log asks for, and those that would help.

    Parameters
    ----------
    log : Log
        Uniformly sampled, its set-up put right.
    settings : FilterSettings
        Filter, delay and lambda.
    take : bool
        Whether terms may be taken at all.

    Returns
    -------
    tuple of Term
        Those taken, and those that would take `HELPS`, in the order of `TERMS`; the load is that of least squares.
    """
    r = drop_standstill(prepare(log, settings))
    a, b = rows(r, columns_of([_made], log, settings, solve(r.y, r.tau))[0])
    able = [k for k in range(len(TERMS)) if np.any(a[..., len(NAMES) + k])]

    def judged(k: int, taken: Sequence[int]) -> Term:
        chosen = [k, *(other for other in taken if other != k)]
        part = beside(a, chosen)
        gain = 1.0 - unseen(part, b) / max(unseen(beside(a, chosen[1:]), b), np.finfo(np.float64).tiny)
        value, error = (float(x[len(NAMES)]) for x in fitted_with_errors(part, b, r.h))
        return Term(TERMS[k], value, error, gain, k in taken)

    taken = best_set(a, b, able) if take else []
    while True:
        terms = [judged(k, taken) for k in able]
        sure = [term.value > SURE * term.error for term in terms]
        wrong = [TERMS.index(term.name) for term, yes in zip(terms, sure, strict=True) if term.taken and not yes]
        if not wrong:
            return tuple(t for t, yes in zip(terms, sure, strict=True) if yes and (t.taken or t.gain > HELPS))
        taken = [k for k in taken if k != wrong[0]]


def eased(log: Log, settings: FilterSettings, beta: Array, terms: Sequence[Term]) -> Log:
    """The log with the friction of these terms taken out of its torque; `beta` gives the load."""
    made = _made(motion(log.q, period(log), settings), beta, settings.friction_steepness)
    friction = made[..., [TERMS.index(term.name) for term in terms]] @ np.array([term.value for term in terms])
    acting = np.clip(log.t + settings.delay, log.t[0], log.t[-1])
    return replace(log, tau=log.tau - CubicSpline(log.t, friction, axis=1)(acting))
