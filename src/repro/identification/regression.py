"""The linear regression tau = Y beta along a motion, its rows that count, its residuals, and its least squares.

At rest static friction carries any torque up to its limit, so a standing sample of one joint is no information about
that joint's row of Eq. 1, and is masked; the other row still counts.

A Gaussian prior adds rows (generalised least squares): beta_k = m_k with the standard deviation s_k of the prior, or a
linear relation of the parameters with that of its value. The rows of a log are correlated: n are worth n / c
independent ones, with c the integrated autocorrelation time of the residual over the sampling period. Rows of the prior
are therefore multiplied by sigma sqrt(c) / s_k, with sigma the residual of the log alone. A parameter with s_k = 0 is
known: its torque is subtracted, its column set to zero.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from repro.model.parameters import Array

STANDSTILL_SPEED = 0.02  # speed below which a joint stands still, rad/s
#: Fraction of time that a joint must move for its standstill to be masked: of one that hardly moves too little remains.
MIN_MOVING_FRACTION = 0.2
IDLE_FRACTION = 0.01  # fraction of time below which a joint does not move at all
SIGNALS = ("y", "tau", "q", "dq", "ddq", "mask")  # fields of a regression with a sample on their second axis


@dataclass(frozen=True, eq=False)
class Relation:
    """A linear relation that the parameters satisfy: coefficients @ beta = value."""

    coefficients: Array  # (9,)
    sd: float  # standard deviation of the value
    value: float = 0.0


@dataclass(frozen=True, eq=False)
class Prior:
    """Means and standard deviations of the nine parameters, and relations between them."""

    mean: Array = field(default_factory=lambda: np.zeros(9))  # SI; 0 where nothing is known
    #: Infinity where nothing is known, 0 where the value is known.
    sd: Array = field(default_factory=lambda: np.full(9, np.inf))
    variance: float = 1.0  # of the torque errors of the log next to it, N^2 m^2
    correlated: float = 1.0  # rows of that log that are worth one independent row
    inflation: float | Array = 1.0  # whole over sampling variance of what each row states, by the log alone (m,)
    relations: tuple[Relation, ...] = ()

    @property
    def known(self) -> NDArray[np.bool_]:
        """Whether each parameter (9,) is known."""
        return np.asarray(self.sd == 0.0)

    @property
    def informative(self) -> list[int]:
        """Parameters with a standard deviation that is neither 0 nor infinite, by number."""
        return [int(k) for k in np.flatnonzero(np.isfinite(self.sd) & ~self.known)]

    @property
    def coefficients(self) -> Array:
        """What each row states: coefficients (m, 9) of the informative parameters, then of the relations."""
        return np.vstack([np.eye(9)[self.informative], *(r.coefficients * ~self.known for r in self.relations)])

    def rows(self) -> tuple[Array, Array]:
        """Give coefficients (m, 9) and values (m,) in units in which they count as rows of variance 1."""
        known = np.where(self.known, self.mean, 0.0)
        of_relations = [relation.value - relation.coefficients @ known for relation in self.relations]
        values = np.array([*self.mean[self.informative], *of_relations])
        sd = np.array([*self.sd[self.informative], *(relation.sd for relation in self.relations)])
        weight = np.sqrt(self.correlated * np.broadcast_to(self.inflation, sd.shape)) / sd
        return weight[:, np.newaxis] * self.coefficients, weight * values

    def shifted(self) -> "Iterator[Prior]":
        """Move what each row states by its standard deviation, one row at a time."""
        for k in self.informative:
            yield replace(self, mean=self.mean + np.where(np.arange(9) == k, self.sd, 0.0))
        for moved in self.relations:
            others = tuple(r if r is not moved else replace(r, value=r.value + r.sd) for r in self.relations)
            yield replace(self, relations=others)


@dataclass(frozen=True, eq=False)  # identity hash, so that results can be cached per instance
class Regression:
    """A recording prepared for a method, with torque and motion through the same filters."""

    t: Array  # time of each sample (n,), s
    y: Array  # filtered regressor (2, n, 9)
    tau: Array  # filtered torque (2, n), N m
    q: Array  # smoothed motion, each (2, n)
    dq: Array
    ddq: Array
    mask: NDArray[np.bool_]  # rows that count (2, n); the others are zero on both sides
    h: float  # time between samples, s
    even_odd: Array | None = None  # the regressor (2, 2, n, 9) from every other sample: with independent noise
    prior: Prior | None = None  # of the parameters
    count: Array | None = None  # samples of each joint (2, 1) that rows of `condense` represent

    @property
    def known(self) -> Array:
        """The parameters (9,) that the prior knows, 0 for the others."""
        return np.zeros(9) if self.prior is None else np.where(self.prior.known, self.prior.mean, 0.0)

    def change(self, function: Callable[[Array], Array], **changes: Any) -> "Regression":  # noqa: ANN401
        """Apply a function to the regressor (2, n, 9) and to those of odd and even samples; replace other fields."""
        halves = None if self.even_odd is None else np.stack([function(half) for half in self.even_odd])
        return replace(self, y=function(self.y), even_odd=halves, **changes)

    def take(self, rows: NDArray[np.intp]) -> "Regression":
        """Select samples by number, in their order; one may come more than once."""
        even_odd = None if self.even_odd is None else np.take(self.even_odd, rows, axis=2)
        # `np.take` copies nine numbers at a time, an index one. The last bits of sums over tau depend on its layout.
        signals: dict[str, Any] = {name: np.take(getattr(self, name), rows, axis=1) for name in SIGNALS}
        return replace(self, t=self.t[rows], even_odd=even_odd, **signals | {"tau": self.tau[:, rows]})


def joined(parts: Sequence[Regression], weights: Sequence[float] | None = None) -> Regression:
    """Join regressions of several logs of one arm; `weights` multiply the rows of each on both sides."""
    if len(parts) == 1:
        return parts[0]
    factors = weights or [1.0] * len(parts)
    begins = np.cumsum([0.0, *(part.t[-1] - part.t[0] + part.h for part in parts[:-1])])
    scaled = [p.change(partial(np.multiply, f), tau=p.tau * f) for p, f in zip(parts, factors, strict=True)]
    halves = [part.even_odd for part in scaled if part.even_odd is not None]
    signals: dict[str, Any] = {name: np.concatenate([getattr(p, name) for p in scaled], axis=1) for name in SIGNALS}
    return replace(
        parts[0],
        t=np.concatenate([part.t - part.t[0] + begin for part, begin in zip(parts, begins, strict=True)]),
        even_odd=np.concatenate(halves, axis=2) if len(halves) == len(parts) else None,
        **signals,
    )


def condense(regression: Regression, times: NDArray[np.intp] | None = None) -> Regression:
    """Replace all samples, each counted `times` (n,), by ten a joint with the same Y'Y, Y'tau and tau'tau.

    A method that needs no more than these sums can then be repeated hundreds of times.
    """
    y, tau = regression.y, regression.tau[..., np.newaxis]
    factor = 1.0 if times is None else times[:, np.newaxis].astype(np.float64)
    counted, product = y * factor, y.mT @ (tau * factor)
    gram = np.block([[counted.mT @ y, product], [product.mT, tau.mT @ (tau * factor)]])
    length = np.sqrt(np.einsum("jpp->jp", gram))
    unit = np.where(length > 0.0, length, 1.0)
    values, vectors = np.linalg.eigh(gram / unit[:, :, np.newaxis] / unit[:, np.newaxis])
    root = np.sqrt(np.maximum(values, 0.0))[..., np.newaxis] * vectors.mT * length[:, np.newaxis]
    count = (regression.mask if times is None else regression.mask * times).sum(-1, keepdims=True)
    empty = np.zeros(root.shape[:2])
    mask = np.broadcast_to(count > 0, empty.shape)
    signals = {"t": empty[0], "q": empty, "dq": empty, "ddq": empty, "mask": mask}
    return replace(regression, y=root[..., :-1], tau=root[..., -1], count=count, even_odd=None, **signals)


def masked(regression: Regression, mask: NDArray[np.bool_]) -> Regression:
    """Set further rows outside of the mask to zero."""
    mask = mask & regression.mask
    return regression.change(lambda y: y * mask[..., np.newaxis], tau=regression.tau * mask, mask=mask)


def without_known(regression: Regression) -> Regression:
    """Subtract the torque of the parameters that the prior knows, and set their columns to zero."""
    prior = regression.prior
    if prior is None or not prior.known.any():
        return regression
    return regression.change(lambda y: y * ~prior.known, tau=regression.tau - regression.y @ regression.known)


def drop_idle_joints(regression: Regression) -> Regression:
    """Mask the rows of joints that never move: the torque that holds them is unknown in every sample."""
    moves = moving_fraction(regression) >= IDLE_FRACTION
    return masked(regression, np.broadcast_to(moves, regression.dq.shape))


def moving_fraction(regression: Regression) -> Array:
    """Fraction of the samples (2, 1) in which each joint moves."""
    return np.asarray((np.abs(regression.dq) >= STANDSTILL_SPEED).mean(-1, keepdims=True))


def drop_standstill(regression: Regression, fraction: Array | None = None) -> Regression:
    """Mask the rows of joints that stand still, as they would be with this fraction of moving samples (2, 1)."""
    moving = np.abs(regression.dq) >= STANDSTILL_SPEED
    fraction = moving_fraction(regression) if fraction is None else fraction
    return masked(regression, np.where(fraction < IDLE_FRACTION, False, moving | (fraction < MIN_MOVING_FRACTION)))


def joint_variance(regression: Regression, beta: Array) -> Array:
    """Mean squared torque error of each joint where it moves, shape (2, 1), N^2 m^2, never zero."""
    error = regression.tau - regression.y @ beta
    present = regression.mask.sum(-1, keepdims=True) if regression.count is None else regression.count
    count = np.maximum(present, 1)
    floor = np.finfo(np.float64).eps * np.einsum("jn,jn->j", regression.tau, regression.tau)[:, np.newaxis] / count
    floor = np.where(floor > 0.0, floor, 1.0)
    return np.asarray(np.maximum(np.sum(error**2 * regression.mask, axis=-1, keepdims=True) / count, floor))


def mean_variance(regression: Regression, beta: Array) -> float:
    """Mean squared torque error of the joints that have rows, N^2 m^2; 1 if neither has."""
    present = regression.mask.any(-1, keepdims=True)
    return float(np.mean(joint_variance(regression, beta), where=present)) if present.any() else 1.0


def correlation_time(error: Array, h: float) -> float:
    """Sum the autocorrelation of residuals (2, n), `h` apart, up to its first zero, s; the longer of both joints."""
    n = error.shape[-1]
    centred = error - error.mean(-1, keepdims=True)
    power = np.abs(np.fft.rfft(centred, 2 * n, axis=-1)) ** 2
    correlation = [joint for joint in np.fft.irfft(power, axis=-1)[:, :n] if joint[0] > 0.0]
    ends = [int(np.argmax(joint <= 0.0)) or n for joint in correlation]
    return max((float(x[:end].sum() / x[0]) * h for x, end in zip(correlation, ends, strict=True)), default=h)


def residual_autocorrelation(regression: Regression, beta: Array, cutoff: float) -> tuple[float, float]:
    """Autocorrelation of each joint's residual one period of the cut-off (Hz) apart, which filtering does not cause."""
    error = regression.tau - regression.y @ beta
    error = error - error.mean(-1, keepdims=True)
    lag = max(round(1.0 / (cutoff * regression.h)), 1)
    if lag >= error.shape[-1]:
        return 0.0, 0.0
    energy, product = np.sum(error**2, axis=-1), np.sum(error[:, lag:] * error[:, :-lag], axis=-1)
    first, second = np.divide(product, energy, out=np.zeros(2), where=energy > 0.0).tolist()
    return first, second


# Least squares of a regression that may not excite every parameter, by its normal equations. Columns of unit length
# leave the equations a condition number of the square of some tens, and a method can be repeated hundreds of times.

RANK_TOLERANCE = 1e-6  # singular values below this fraction of the largest count as zero, for columns of unit length
#: Columns shorter than this fraction of the longest are rounding of a joint that does not move, and count as zero.
MIN_COLUMN_RATIO = 1e-9
#: Weights of the rows that pull to zero, for columns of unit length: undetermined directions, and all parameters.
UNDETERMINED_WEIGHT, REGULARISATION_WEIGHT = 1e-3, 1e-7


def unit_columns(y: Array) -> tuple[Array, Array]:
    """Scale a regressor (2, n, 9) to rows (2 n, 9) with columns of unit length, or zero; beta = z / scale (9,)."""
    a = y.reshape(-1, y.shape[-1])
    length = np.sqrt(np.einsum("np,np->p", a, a))
    moved = length > MIN_COLUMN_RATIO * length.max(initial=0.0)
    scale = np.where(moved, length, 1.0)
    return a * np.where(moved, 1.0 / scale, 0.0), scale


def pseudo_solve(gram: Array, right: Array) -> Array:
    """Compute the shortest solution of a symmetric system whose small eigenvalues count as zero."""
    values, vectors = np.linalg.eigh(gram)
    nonzero = np.abs(values) > RANK_TOLERANCE**2 * np.abs(values).max()
    inverse = np.divide(1.0, values, out=np.zeros_like(values), where=nonzero)
    return np.asarray(vectors @ (inverse * (vectors.T @ right)))


def solve_normal(gram: Array, right: Array, length: Array) -> Array:
    """Solve normal equations whose columns have these lengths; a column that is nothing but rounding counts as 0."""
    moved = length > MIN_COLUMN_RATIO * length.max(initial=0.0)
    inverse = np.divide(1.0, length, out=np.zeros_like(length), where=moved)
    return pseudo_solve(gram * inverse * inverse[:, None], right * inverse) * inverse


def solve(y: Array, tau: Array, weight: Array | None = None, prior: Prior | None = None) -> Array:
    """Compute the parameters (9,) with the smallest sum of squared torque errors, from y (2, n, 9) and tau (2, n).

    `weight` of each squared error broadcasts to (2, n); next to a prior, weighted rows have a variance of 1. Of
    parameters that are not unique, the shortest in units of the columns' length are the solution.
    """
    if weight is None and prior is None:
        a, scale = unit_columns(y)
        gram = a.T @ a
        return pseudo_solve(gram, a.T @ tau.reshape(-1)) * (gram.diagonal() > 0.0) / scale
    flat = y.reshape(-1, y.shape[-1])
    weighted = (y * np.asarray(1.0 if weight is None else weight)[..., np.newaxis]).reshape(flat.shape)
    gram, right = weighted.T @ flat, weighted.T @ tau.reshape(-1)
    if prior is not None:
        rows, values = prior.rows()
        factor = prior.variance if weight is None else 1.0
        gram, right = gram + factor * rows.T @ rows, right + factor * rows.T @ values
    return solve_normal(gram, right, np.sqrt(gram.diagonal()))


def reduced_problem(regression: Regression, size: Array | None = None) -> tuple[Array, Array, Array]:
    """Reduce |Y beta - tau|^2, but for a constant, to |R z - c|^2 with R (k, 9), c (k,) and beta = z / scale (9,).

    `size` (2, 1) of each joint's torque errors, N m, is the unit of its rows. Further rows are those of the prior,
    and rows that pull undetermined directions, and more weakly all of z, to zero.
    """
    y, tau = regression.y, regression.tau
    if size is not None:
        y, tau = y / size[..., np.newaxis], tau / size
    a, scale = unit_columns(y)
    gram, product = a.T @ a, a.T @ tau.reshape(-1)
    if (prior := regression.prior) is not None:
        rows, values = prior.rows()
        factor = prior.variance if size is None else 1.0
        rows = rows / scale
        gram, product = gram + factor * rows.T @ rows, product + factor * rows.T @ values
        length = np.sqrt(np.where(gram.diagonal() > 0.0, gram.diagonal(), 1.0))
        gram, product, scale = gram / length / length[:, None], product / length, scale * length
    moved = np.flatnonzero(gram.diagonal() > 0.0)
    values, vectors = np.linalg.eigh(gram[np.ix_(moved, moved)])
    nonzero = values > RANK_TOLERANCE**2 * values.max(initial=0.0)
    directions = np.zeros((moved.size, len(scale)))
    directions[:, moved] = vectors.T
    root = np.sqrt(values[nonzero])
    undetermined, weak = UNDETERMINED_WEIGHT * directions[~nonzero], REGULARISATION_WEIGHT * np.eye(len(scale))
    rows = np.vstack([root[:, None] * directions[nonzero], undetermined, weak])
    right = np.zeros(len(rows))
    right[: root.size] = directions[nonzero] @ product / root
    return rows, right, scale


def determined(r: Array, c: Array) -> NDArray[np.bool_]:
    """Find the parameters that rows R z = c determine; the others share no row with them and are exactly 0."""
    alone = np.count_nonzero(r.T @ r, axis=0) == 1
    return np.asarray(~(alone & (r.T @ c == 0.0)))


def clip_to_bound(z: Array, ratio: float) -> Array:
    """Set numbers smaller than a fraction of the largest to zero: what a solver leaves of a bound that holds."""
    return np.where(np.abs(z) > ratio * np.abs(z).max(initial=0.0), z, 0.0)
