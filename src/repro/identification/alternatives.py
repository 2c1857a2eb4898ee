"""Alternative regressions of a log: the shift of an estimate between them is an uncertainty of type B [1]_.

Filters and delay could have been chosen slightly differently. Zero positions, torque offsets, load-dependent friction,
Stribeck friction and torque that depends on the position are effects beyond Eq. 1. Each adds columns to the regressor.
With these projected out of torque and regressor, any method gives the parameters that it would give with the columns
in its model (Frisch, Waugh and Lovell). The squared shift is multiplied by the positive-part shrinkage factor
1 - c / F [2]_, with F of the F-test of the columns and c its 5 % critical value: columns that explain no more than
chance add nothing. Errors of the motion are simulated a second time (SIMEX [3]_).

.. [1] JCGM 100:2008, "Evaluation of Measurement Data: Guide to the Expression of Uncertainty in Measurement" (GUM).
.. [2] A. J. Baranchik, "A Family of Minimax Estimators of the Mean of a Multivariate Normal Distribution", Annals of
   Mathematical Statistics 41, 642-645, 1970. doi:10.1214/aoms/1177697104
.. [3] J. R. Cook and L. A. Stefanski, "Simulation-Extrapolation Estimation in Parametric Measurement Error Models",
   Journal of the American Statistical Association 89, 1314-1328, 1994. doi:10.1080/01621459.1994.10476871
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.linalg import hadamard
from scipy.stats import f as fisher

from repro.identification.filtering import FilterSettings, kept, motion, narrow, prepare
from repro.identification.regression import Regression, correlation_time, drop_standstill
from repro.identification.solve import solve
from repro.logs.log import Log, period
from repro.model.dynamics import regressor
from repro.model.parameters import Array

#: Factors on cut-off and width of the filters.
FILTERS = ((0.8, 0.7), (0.8, 1.4), (1.25, 0.7), (1.25, 1.4))
#: Speeds at which Stribeck friction may have fallen to 1/e of its value at rest, rad/s.
STRIBECK_SPEEDS = (0.1, 0.2, 0.5)
#: Inertia and gravity: the first so many parameters.
TERMS = 5
#: Difference of the position that columns of a zero position are made with, rad.
SMALL = 1e-4

#: Name of `smeared` in words.
SMEARED = "errors of the motion"

#: Level of the F-test of further columns.
CHANCE = 0.05


@dataclass(frozen=True)
class Alternative:
    """One choice made differently.

    Attributes
    ----------
    regressions : tuple of Regression
        Each way to make it.
    weight : float
        Factor on the squared shift of an estimate, 0 to 1.
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


def stribeck(
    moved: Moved,
    beta: Array,  # noqa: ARG001
    steepness: float,
    speed: float = STRIBECK_SPEEDS[-1],
    power: int = 2,
) -> Array:
    """Friction that is larger near rest, shape (2, N, 2): powers of 1 and 2 are both in use."""
    return _one_joint(np.tanh(steepness * moved[1]) * np.exp(-((np.abs(moved[1]) / speed) ** power)))


def once_a_turn(moved: Moved, beta: Array, steepness: float) -> Array:  # noqa: ARG001
    """Torque of period one turn of a joint (eccentric gear), shape (2, N, 3).

    sin q1 at joint 1 is left out: no log can distinguish it from g1.
    """
    return np.concatenate([_one_joint(np.cos(moved[0])), _one_joint(np.sin(moved[0]))[..., 1:]], axis=-1)


def twice_a_turn(moved: Moved, beta: Array, steepness: float) -> Array:  # noqa: ARG001
    """Torque of period half a turn of a joint (cable, gear that is out of round), shape (2, N, 4)."""
    return np.concatenate([_one_joint(wave(2.0 * moved[0])) for wave in (np.cos, np.sin)], axis=-1)


#: Effects beyond Eq. 1 by name. Of several forms, the one that explains the residual best counts.
BEYOND: dict[str, tuple[Columns, ...]] = {
    "zero positions": (zero_position,),
    "torque offsets": (bias,),
    "load-dependent friction": (load_friction,),
    "Stribeck friction": tuple(partial(stribeck, speed=speed, power=1) for speed in STRIBECK_SPEEDS),
    "torque of period one turn": (once_a_turn,),
    "torque of period half a turn": (twice_a_turn,),
}


def smeared(regression: Regression) -> Regression:
    """Add an error to each inertial and gravity term, as large as would explain the residual.

    Errors of the regressor attenuate least squares, most where large terms add up to a small torque. SIMEX: the shift
    that a second error of the same size causes estimates the bias (linear extrapolant). Errors are not drawn: their
    signs are columns of a Hadamard matrix, which are orthogonal from term to term.
    """
    beta = solve(regression.y, regression.tau)
    left = (regression.tau - regression.y @ beta) * regression.mask
    terms = regression.y[..., :TERMS] * beta[:TERMS] * regression.mask[..., np.newaxis]
    whole = np.linalg.norm(terms, axis=(1, 2))
    share = np.linalg.norm(left, axis=-1) / np.where(whole > 0.0, whole, np.inf)  # of each joint
    n = regression.t.size
    signs = np.resize(hadamard(16)[:, 1 : 2 * TERMS : 2], (n, TERMS))
    factors = np.ones((2, n, regression.y.shape[-1]))
    factors[..., :TERMS] += share[:, np.newaxis, np.newaxis] * signs
    halves = regression.even_odd
    return replace(regression, y=regression.y * factors, even_odd=None if halves is None else halves * factors)


def columns_of(makes: Sequence[Columns], log: Log, settings: FilterSettings, beta: Array) -> list[Array]:
    """Columns of the kept samples through the filters of the regressor, each of shape (2, n, k)."""
    pieces = []
    for piece in log.pieces:
        h, (n, keep) = period(piece), kept(piece, settings)
        moved = motion(piece.q[:, :n], h, settings)
        made = (make(moved, beta, settings.friction_steepness) for make in makes)
        pieces.append([narrow(columns, h, settings)[:, keep] for columns in made])
    return [np.concatenate(parts, axis=1) for parts in zip(*pieces, strict=True)]


def without(regression: Regression, columns: Array) -> Regression:
    """The regression with what columns of shape (2, n, k) can explain taken out of torque and regressor.

    Least squares of it gives the parameters that least squares gives beside those columns.
    """
    x = (columns * regression.mask[..., np.newaxis]).reshape(-1, columns.shape[-1])
    size = np.linalg.norm(x, axis=0)
    basis, _ = np.linalg.qr(x[:, size > 0.0] / size[size > 0.0])

    def rest(part: Array) -> Array:
        flat = part.reshape(basis.shape[0], -1)
        left: Array = (flat - basis @ (basis.T @ flat)).reshape(part.shape)
        return left

    halves = regression.even_odd
    return replace(
        regression,
        y=rest(regression.y),
        tau=rest(regression.tau),
        even_odd=None if halves is None else np.stack([rest(half) for half in halves]),
    )


def shrinkage(plain: Regression, other: Regression, columns: int) -> float:
    """Positive-part shrinkage factor of the shift that further columns cause.

    Parameters
    ----------
    plain, other : Regression
        Without the columns, and with them projected out.
    columns : int
        Number of columns.

    Returns
    -------
    float
        max(0, 1 - c / F). F is that of the F-test, with the length of the log in correlation times as number of
        samples of a joint; c is its critical value at the level `CHANCE`.
    """
    errors = [r.tau - r.y @ solve(r.y, r.tau) for r in (plain, other)]
    weight = 1.0 / np.maximum(np.sum(errors[0] ** 2, axis=-1, keepdims=True), np.finfo(np.float64).tiny)
    before, after = (float(np.sum(weight * error**2)) for error in errors)
    freedom: float = errors[0].size * plain.h / correlation_time(errors[0], plain.h) - plain.y.shape[-1] - columns
    if not 0.0 < after < before or freedom <= 0.0:
        return 0.0
    ratio = (before - after) / after * freedom / columns
    return max(0.0, 1.0 - float(fisher.isf(CHANCE, columns, freedom)) / ratio)


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
        return drop_standstill(prepare(log, changed))

    filters = tuple(made(replace(s, cutoff=s.cutoff * cut, width=s.width * width / cut)) for cut, width in FILTERS)
    plain = made(s)
    beta = solve(plain.y, plain.tau)
    found = {"filters": Alternative(filters)}
    if late > 0.0:
        found["delay"] = Alternative(tuple(made(replace(s, delay=s.delay + by)) for by in (-late, late)))
    every = iter(columns_of([make for forms in BEYOND.values() for make in forms], log, s, beta))
    for name, forms in BEYOND.items():
        columns = [next(every) for _ in forms]
        others = [without(plain, one) for one in columns]
        weights = [shrinkage(plain, other, one.shape[-1]) for other, one in zip(others, columns, strict=True)]
        best = int(np.argmax(weights))
        found[name] = Alternative((others[best],), weights[best])
    found[SMEARED] = Alternative((smeared(plain),))
    return found
