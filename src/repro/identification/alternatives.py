"""Regressions of a log that would have been as good a choice: by what an estimate moves between them it may be off.

The filters and the delay could have been chosen a little differently. Zero positions, an offset of the torque, Coulomb
friction that grows with the load and friction that falls with speed (Stribeck) are no part of Eq. 1; each adds columns
to the regressor, and with these projected out of torque and regressor any method gives the parameters that it would
give if it knew of them (Frisch, Waugh and Lovell). They count as far as the log asks for them: where the columns take
no more of the residual than chance would, nothing.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import hadamard

from repro.identification.parallel import FilterSettings, kept, motion, narrow, prepare
from repro.identification.regression import Regression
from repro.identification.residuals import correlation_time
from repro.identification.solve import solve
from repro.identification.standstill import without_standstill
from repro.logs.log import Log, period
from repro.model.dynamics import regressor
from repro.model.parameters import Array

#: Factors on cut-off and width of the filters.
FILTERS = ((0.8, 0.7), (0.8, 1.4), (1.25, 0.7), (1.25, 1.4))
#: Speed at which friction has fallen to 1/e of what Stribeck adds at rest, rad/s.
STRIBECK = 0.5
#: Inertia and gravity: the first so many parameters.
TERMS = 5
#: Difference of the position that columns of a zero position are made with, rad.
SMALL = 1e-4

#: Name of `smeared` in words.
SMEARED = "errors of the motion"

#: F that columns reach by chance in one log of twenty.
CHANCE = 3.0


@dataclass(frozen=True)
class Alternative:
    """One thing chosen otherwise.

    Attributes
    ----------
    regressions : tuple of Regression
        Ways to choose it.
    weight : float
        From 0 to 1, how far the log asks for it.
    """

    regressions: tuple[Regression, ...]
    weight: float = 1.0


Moved = tuple[Array, Array, Array]
Columns = Callable[[Moved, Array, float], Array]


def _one_joint(values: Array) -> Array:
    """A column for each joint that is zero in the other, (2, N) -> (2, N, 2)."""
    columns: Array = values[..., np.newaxis] * np.eye(2)[:, np.newaxis]
    return columns


def bias(moved: Moved, beta: Array, steepness: float) -> Array:  # noqa: ARG001
    """A torque that is always there, of each joint: shape (2, N, 2)."""
    return _one_joint(np.ones_like(moved[0]))


def zero_position(moved: Moved, beta: Array, steepness: float) -> Array:
    """What the torque of each joint changes by with the zero position of either, shape (2, N, 2)."""
    q, dq, ddq = moved
    plain = regressor(q, dq, ddq, steepness) @ beta
    turned = [regressor(q + SMALL * unit[:, np.newaxis], dq, ddq, steepness) @ beta for unit in np.eye(2)]
    return np.stack([(there - plain) / SMALL for there in turned], axis=-1)


def load_friction(moved: Moved, beta: Array, steepness: float) -> Array:
    """Coulomb friction in proportion to the torque that the gear carries, shape (2, N, 2)."""
    load = regressor(*moved, steepness)[..., :5] @ beta[:5]
    return _one_joint(np.abs(load) * np.tanh(steepness * moved[1]))


def stribeck(moved: Moved, beta: Array, steepness: float) -> Array:  # noqa: ARG001
    """Friction that is larger near rest, shape (2, N, 2)."""
    return _one_joint(np.tanh(steepness * moved[1]) * np.exp(-((moved[1] / STRIBECK) ** 2)))


#: What is no part of Eq. 1, by its name in words.
BEYOND: dict[str, Columns] = {
    "zero positions": zero_position,
    "torque offsets": bias,
    "load-dependent friction": load_friction,
    "Stribeck friction": stribeck,
}


def smeared(regression: Regression) -> Regression:
    """The regression with each inertial and gravity term a little wrong, by as much as would explain the residual.

    Errors of the motion shrink what least squares finds, most where large terms add up to a small torque. So much as
    the same errors once more move it, it is off (Cook and Stefanski's simulation extrapolation). Their signs change
    from sample to sample and are orthogonal from term to term, so that none of them looks like motion.
    """
    beta = solve(regression.y, regression.tau)
    left = (regression.tau - regression.y @ beta) * regression.moving
    terms = regression.y[..., :TERMS] * beta[:TERMS] * regression.moving[..., np.newaxis]
    whole = np.linalg.norm(terms, axis=(1, 2))
    share = np.linalg.norm(left, axis=-1) / np.where(whole > 0.0, whole, np.inf)  # of each joint
    n = regression.t.size
    signs = np.resize(hadamard(16)[:, 1 : 2 * TERMS : 2], (n, TERMS))
    factors = np.ones((2, n, regression.y.shape[-1]))
    factors[..., :TERMS] += share[:, np.newaxis, np.newaxis] * signs
    halves = regression.interleaved
    return replace(regression, y=regression.y * factors, interleaved=None if halves is None else halves * factors)


def columns_of(make: Columns, log: Log, settings: FilterSettings, beta: Array) -> Array:
    """Columns of the kept samples through the filters of the regressor, shape (2, n, k)."""
    columns = []
    for piece in log.pieces:
        h, (n, keep) = period(piece), kept(piece, settings)
        made = make(motion(piece.q[:, :n], h, settings), beta, settings.friction_steepness)
        columns.append(narrow(made, h, settings)[:, keep])
    return np.concatenate(columns, axis=1)


def without(regression: Regression, columns: Array) -> Regression:
    """The regression with what columns of shape (2, n, k) can explain taken out of torque and regressor.

    Least squares of it gives the parameters that least squares gives beside those columns.
    """
    x = (columns * regression.moving[..., np.newaxis]).reshape(-1, columns.shape[-1])
    size = np.linalg.norm(x, axis=0)
    basis, _ = np.linalg.qr(x[:, size > 0.0] / size[size > 0.0])

    def rest(part: Array) -> Array:
        flat = part.reshape(basis.shape[0], -1)
        left: Array = (flat - basis @ (basis.T @ flat)).reshape(part.shape)
        return left

    halves = regression.interleaved
    return replace(
        regression,
        y=rest(regression.y),
        tau=rest(regression.tau),
        interleaved=None if halves is None else np.stack([rest(half) for half in halves]),
    )


def asked_for(plain: Regression, other: Regression, columns: int) -> float:
    """How far a log asks for further columns: 0 for what chance explains, near 1 for what it does not.

    Parameters
    ----------
    plain, other : Regression
        Without the columns, and with them taken out.
    columns : int
        How many.

    Returns
    -------
    float
        1 - `CHANCE` / F, at least 0: F is that of the F-test with as many samples as there are correlation times.
    """
    errors = [r.tau - r.y @ solve(r.y, r.tau) for r in (plain, other)]
    weight = 1.0 / np.maximum(np.sum(errors[0] ** 2, axis=-1, keepdims=True), np.finfo(np.float64).tiny)
    before, after = (float(np.sum(weight * error**2)) for error in errors)
    independent = errors[0].size * plain.h / correlation_time(errors[0], plain.h)
    if after <= 0.0:
        return 0.0
    f = (before - after) / after * independent / columns
    return max(0.0, 1.0 - CHANCE / f) if f > 0.0 else 0.0


def alternatives(log: Log, settings: FilterSettings, late: float = 0.0) -> dict[str, Alternative]:
    """Other regressions of a log, by what is different.

    Parameters
    ----------
    log : Log
        Uniformly sampled.
    settings : FilterSettings
        What was chosen.
    late : float
        Standard error of the delay, s; 0 where it is known.

    Returns
    -------
    dict of Alternative
        Without standstill, by what is different.
    """
    s = settings

    def made(changed: FilterSettings) -> Regression:
        return without_standstill(prepare(log, changed))

    filters = tuple(made(replace(s, cutoff=s.cutoff * cut, width=s.width * width / cut)) for cut, width in FILTERS)
    plain = made(s)
    beta = solve(plain.y, plain.tau)
    found = {"filters": Alternative(filters)}
    if late > 0.0:
        found["delay"] = Alternative(tuple(made(replace(s, delay=s.delay + by)) for by in (-late, late)))
    for name, make in BEYOND.items():
        columns = columns_of(make, log, s, beta)
        other = without(plain, columns)
        found[name] = Alternative((other,), asked_for(plain, other, columns.shape[-1]))
    found[SMEARED] = Alternative((smeared(plain),))
    return found
