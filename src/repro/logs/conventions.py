"""Conventions of a log (joint order, signs, units, coarse zeros): does another one explain its torque far better?

Small errors of zero, offset and scale are estimated in `repro.identification`.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Final

import numpy as np
from scipy.fft import dst, idst

from repro.identification.armfile import Arm
from repro.identification.log import Log, period, uniform
from repro.model.dynamics import LAMBDA, regressor
from repro.model.parameters import Array

#: Low-pass, Hz, most samples fitted, and time left out at each end, s: enough to distinguish conventions.
_CUTOFF_HZ, _MAX_SAMPLES, _EDGE_S = 6.0, 2000, 0.3
#: Another convention is reported if it leaves less than this fraction of the product of both joints' squared errors,
_MAX_ERROR_RATIO = 0.4
#: and explains a joint up to this fraction of its squared torque,
_MAX_GOOD_ERROR = 0.1
#: or if it leaves the same, and only this one has a term of the wrong sign with this fraction of the torque.
_MAX_SAME_RATIO, _MIN_NOTICEABLE_SHARE = 1.0 + 1e-6, 0.15
_MAX_EQUAL_RATIO = 1.1  # ratio of such products up to which two conventions fit equally well
_MAX_RESIDUAL = 0.6  # residual above which a fit explains nothing
#: Two changes are tried where one leaves more than this residual, or a term of an impossible sign; they must leave less
#: than the second fraction of the product of both joints' squared errors, as there are hundreds of pairs.
_MAX_RESIDUAL_OF_ONE, _MAX_PAIR_RATIO = 0.25, 0.1
_PAIR_STEP = 4  # a pair is fitted to every fourth sample
_MAX_UNEXPLAINED = 0.5  # fraction of a joint's squared torque that a fit may leave and still explain the joint
#: Fits, each with the joints weighted by the errors of the one before: the last has nearly the smallest product.
_FITS = 4
_MIN_SQUARED_ERROR = 1e-8  # over squared torque; it counts as none: a log without noise is explained to rounding
#: Singular values of the normal equations below this fraction of the largest count as zero, for unit columns.
_MIN_SINGULAR_RATIO = 1e-11
_MAX_RESIDUAL_RATIO = 0.5  # a shift in time is reported if it leaves less than this fraction of the residual
_MIN_DELAY_S, _MAX_DELAY_S = 0.03, 0.3  # delays examined, s; `repro identify` estimates smaller ones by itself
READS_BETTER = "the log reads better with"  # beginning of the warning of another convention


@dataclass(frozen=True)
class Convention:
    """Another meaning of the columns: ``q' = position @ q + offset`` and ``tau' = torque @ tau``."""

    name: str
    remedy: str  # what to write in the arm file; for an offset `_zero` does
    position: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 1.0)  # a matrix (2, 2) by rows, of recorded angles
    torque: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)  # of the angles of Eq. 1, rad
    parts: tuple["Convention", ...] = ()  # the two changes that it combines


_SWAP: Final = (0.0, 1.0, 1.0, 0.0)
_DEGREE: Final = np.pi / 180.0
_RIGHT: Final = np.pi / 2.0
_WHOLE: Final = 2.0 * np.pi

#: Of conventions that fit equally well the first is reported.
CONVENTIONS: Final = (
    Convention("joints 1 and 2 swapped", "columns: {q1: q2, q2: q1, tau1: tau2, tau2: tau1}", _SWAP, _SWAP),
    Convention("the torques of joints 1 and 2 swapped", "columns: {tau1: tau2, tau2: tau1}", torque=_SWAP),
    Convention("the torques of the other sign", "torque_sign: [-1, -1]", torque=(-1.0, 0.0, 0.0, -1.0)),
    Convention("the torque of joint 1 of the other sign", "torque_sign: [-1, 1]", torque=(-1.0, 0.0, 0.0, 1.0)),
    Convention("the torque of joint 2 of the other sign", "torque_sign: [1, -1]", torque=(1.0, 0.0, 0.0, -1.0)),
    Convention(
        "the drive of joint 2 in the base, as with a belt or a parallel linkage",
        "add the torque of joint 2 to that of joint 1 in the log",
        torque=(1.0, 1.0, 0.0, 1.0),
    ),
    Convention("joint 2 of the other sign", "sign: [1, -1]", (1.0, 0.0, 0.0, -1.0), (1.0, 0.0, 0.0, -1.0)),
    Convention("q1 alone of the other sign", "sign: [-1, 1] and torque_sign: [-1, 1]", (-1.0, 0.0, 0.0, 1.0)),
    Convention("q2 alone of the other sign", "sign: [1, -1] and torque_sign: [1, -1]", (1.0, 0.0, 0.0, -1.0)),
    Convention("q2 measured from the vertical", "second_joint_absolute: true", (1.0, 0.0, -1.0, 1.0)),
    Convention("q2 relative to link 1", "second_joint_absolute: false", (1.0, 0.0, 1.0, 1.0)),
    Convention("positions in degrees", "units: {position: deg}", (_DEGREE, 0.0, 0.0, _DEGREE)),
    Convention("positions in turns", "units: {position: turns}", (_WHOLE, 0.0, 0.0, _WHOLE)),
    Convention("q1 = 0 upright", "zero", offset=(np.pi, 0.0)),
    Convention("q1 = 0 horizontal", "zero", offset=(_RIGHT, 0.0)),
    Convention("q1 = 0 horizontal", "zero", offset=(-_RIGHT, 0.0)),
    Convention("q2 = 0 folded back", "zero", offset=(0.0, np.pi)),
    Convention("q1 = 0 upright and q2 = 0 folded back", "zero", offset=(np.pi, np.pi)),
    Convention("q2 = 0 at a right angle", "zero", offset=(0.0, _RIGHT)),
    Convention("q2 = 0 at a right angle", "zero", offset=(0.0, -_RIGHT)),
    *(
        Convention(f"{which} {1.0 / factor:g} times the true one", remedy, (x, 0.0, 0.0, y))
        for factor in (0.5, 2.0, 0.25, 4.0)
        for which, x, y in (("both positions", factor, factor), ("q1", factor, 1.0), ("q2", 1.0, factor))
        for remedy in (f"multiply counts_per_turn in the arm file by [{1.0 / x:g}, {1.0 / y:g}]",)
    ),
)


def _stage(convention: Convention) -> int:
    """Order in which two changes of a log apply, as in the arm file: units and columns, zeros, then signs."""
    magnitudes = np.abs(convention.position)
    return (
        1
        if any(convention.offset)
        else 0
        if convention.position == _SWAP or not np.isin(magnitudes, (0, 1)).all()
        else 2
    )


def _both(first: Convention, second: Convention) -> Convention:
    """Combine two conventions, the second of what the first gives."""
    position, torque = (
        tuple((np.reshape(b, (2, 2)) @ np.reshape(a, (2, 2))).ravel().tolist())
        for a, b in ((first.position, second.position), (first.torque, second.torque))
    )
    offset = np.reshape(second.position, (2, 2)) @ first.offset + second.offset
    return Convention(f"{first.name} and {second.name}", "", position, torque, tuple(offset.tolist()), (first, second))


def _pairs(conventions: Sequence[Convention]) -> Iterator[Convention]:
    """Combine two changes of different columns or kinds; what undoes itself is left out."""
    for pair in combinations(conventions, 2):
        combined = _both(*sorted(pair, key=_stage))
        single = [(c.position, c.torque, c.offset) for c in (_AS_GIVEN, *conventions)]
        if (combined.position, combined.torque, combined.offset) not in single and not all(any(c.offset) for c in pair):
            yield combined


@dataclass(frozen=True)
class _Fit:
    """Least squares of Eq. 1 with the columns read by a convention."""

    error: Array  # squared error of each joint over its squared torque (2,), in the order of the convention
    residual: float  # torque error of both joints over their torque, RMS
    n_impossible: int  # noticeable terms of an impossible sign

    def ratio(self, other: "_Fit") -> float:
        """Product of both joints' squared errors over that of another fit: noise of one joint does not change it."""
        return float(np.prod(self.error / other.error))


@dataclass(frozen=True)
class Smoothed:
    """Low-passed motion and torque (2, N), and the samples to fit."""

    q: Array
    dq: Array
    ddq: Array
    tau: Array
    h: float
    chosen: np.ndarray[tuple[int], np.dtype[np.intp]]
    noise: Array  # the part of the torque above the cutoff

    def noisy_joints(self) -> list[int]:
        """List joints of whose torque most is above the cutoff, and Eq. 1 explains little of the rest.

        A controller that switches its torque drives a motion by what remains below the cutoff.
        """
        below, above = (np.linalg.norm(x[:, self.chosen], axis=1) for x in (self.tau, self.noise))
        if (below > above).all():
            return []
        return (np.flatnonzero((below <= above) & (_fit(self, _AS_GIVEN).error > _MAX_UNEXPLAINED)) + 1).tolist()


_AS_GIVEN: Final = Convention("", "")


def better_convention(log: Log, s: Smoothed, arm: Arm) -> Iterator[str]:
    """Report a convention that explains the torque far better, or equally well with possible signs only.

    Least squares takes any sign: a wrong sign of the torque or a wrong zero comes out as negative inertia, gravity or
    friction.
    """
    if np.linalg.norm(s.tau[:, s.chosen], axis=1).min() < 1e-6 * np.linalg.norm(log.tau):  # driven at the ends only
        return
    noisy = s.noisy_joints()
    if len(noisy) == 2:
        yield "the torque is little more than noise: this log can only test the motion that parameters predict"
        return
    if noisy:
        remedy = f"if it has no drive, write into the arm file: passive_joint: {noisy[0]}; else it was not recorded"
        yield f"the torque of joint {noisy[0]} is little more than noise: {remedy}"
    given = _fit(s, _AS_GIVEN)
    in_force = f"second_joint_absolute: {str(arm.second_joint_absolute).lower()}"
    others = [convention for convention in CONVENTIONS if convention.remedy != in_force]
    fits = [(_fit(s, convention, arm.second_joint_absolute), convention) for convention in others]
    least = min((fit for fit, _ in fits), key=lambda fit: fit.ratio(given))
    better = None
    if least.ratio(given) < _MAX_ERROR_RATIO and least.error.min() < _MAX_GOOD_ERROR:
        equal = [pair for pair in fits if pair[0].ratio(least) < _MAX_EQUAL_RATIO]
        better = min(equal, key=lambda pair: pair[0].n_impossible)
    elif not noisy and given.n_impossible and given.residual <= _MAX_RESIDUAL:
        same = [(fit, c) for fit, c in fits if 1.0 / _MAX_SAME_RATIO < fit.ratio(given) < _MAX_SAME_RATIO]
        better = next((pair for pair in same if pair[0].n_impossible == 0), None)
    if not noisy:
        better = _best_pair(s, others, given if better is None else better[0], arm) or better
    if better is not None:
        best, convention = better
        reason = f"torque residual {100.0 * best.residual:.2g} % instead of {100.0 * given.residual:.2g} %"
        if best.ratio(given) > _MAX_ERROR_RATIO:
            reason = "as given, inertia, gravity or friction come out negative"
        yield _advice(convention, reason, log, arm)
    elif not noisy and given.residual > _MAX_RESIDUAL:
        found = f"Eq. 1 explains little of the torque (residual {100.0 * given.residual:.0f} %)"
        remedy = "check units, signs, zeros and which column is which"
        yield f"{found}, even if up to two conventions are changed: {remedy}"


def _best_pair(s: Smoothed, others: Sequence[Convention], one: _Fit, arm: Arm) -> tuple[_Fit, Convention] | None:
    """Find two changes that explain both joints, far better than one change or without its impossible signs."""
    if one.residual <= _MAX_RESIDUAL_OF_ONE and not one.n_impossible:
        return None
    coarse = replace(s, chosen=s.chosen[::_PAIR_STEP])
    pairs = [(_fit(coarse, pair, arm.second_joint_absolute), pair) for pair in _pairs(others)]
    least = min((fit for fit, _ in pairs), key=lambda fit: fit.ratio(one))
    _, pair = min((p for p in pairs if p[0].ratio(least) < _MAX_EQUAL_RATIO), key=lambda p: p[0].n_impossible)
    fit = _fit(s, pair, arm.second_joint_absolute)
    possible = one.n_impossible > 0 == fit.n_impossible and fit.ratio(one) < _MAX_EQUAL_RATIO
    better = possible or fit.ratio(one) < _MAX_PAIR_RATIO
    return (fit, pair) if better and fit.error.max() < _MAX_GOOD_ERROR else None


def late_torque(s: Smoothed, delay: float) -> Iterator[str]:
    """Report a torque that fits the motion far better with another delay than this one (s), that of the arm file."""
    reach = round(_MAX_DELAY_S / s.h)
    inner = s.chosen[(s.chosen >= reach) & (s.chosen < s.q.shape[1] - reach)]
    if inner.size < 20 or s.noisy_joints():
        return
    y = regressor(s.q[:, inner], s.dq[:, inner], s.ddq[:, inner]).reshape(-1, 9)
    basis = np.linalg.qr(y).Q
    shifts = np.arange(-reach, reach + 1, max(1, round(0.005 / s.h)))
    residuals = np.array([_residual(basis, s.tau[:, inner - shift].ravel()) for shift in shifts])
    known = int(np.clip(round(delay / s.h), -reach, reach))
    given = _residual(basis, s.tau[:, inner - known].ravel())
    best = int(np.argmin(residuals))
    better = float(shifts[best]) * s.h
    if abs(better - known * s.h) >= _MIN_DELAY_S and residuals[best] <= _MAX_RESIDUAL_RATIO * given:
        when = f"{abs(better):.3f} s {'later' if better > 0 else 'earlier'} than recorded"
        reason = f"residual {100 * residuals[best]:.0f} % instead of {100 * given:.0f} %"
        remedy = f"check the time stamps, or write into the arm file: delay: {better:.3g}"
        yield f"the torque fits the motion best {when} ({reason}): {remedy}"


def _advice(convention: Convention, reason: str, log: Log, arm: Arm) -> str:
    steps = "; ".join(_step(part, log, arm) for part in convention.parts or (convention,))
    return f"{READS_BETTER} {convention.name} ({reason}): if so, first of all {steps}"


def _step(convention: Convention, log: Log, arm: Arm) -> str:
    """Write what to do about one change of how the log is read."""
    remedy = convention.remedy
    if remedy.startswith("add"):
        return remedy
    if remedy.startswith("multiply"):
        if arm.counts_per_turn is None:
            first, *_, second = convention.position
            remedy = f"check the unit and the gear ratio, or multiply the columns q1, q2 by {first:g}, {second:g}"
    elif remedy.startswith("columns"):
        if convention.position == _SWAP and log.dq is not None:
            remedy = remedy.replace("tau1:", "dq1: dq2, dq2: dq1, tau1:", 1)
        remedy += " (with the headers of this log)"
    elif remedy.startswith(("sign", "torque_sign", "zero")):
        remedy = f"{_zero(convention, arm) if remedy == 'zero' else remedy} (on top of what is there)"
    step = "" if convention.remedy.startswith("multiply") else "write into the arm file: "
    return f"{step}{remedy}"


def _zero(convention: Convention, arm: Arm) -> str:
    """Write the change of the zeros in the arm file that has the offset of a convention; half a turn has two signs."""
    first, second = convention.offset
    change = -np.array(arm.sign) * (first, second + first * arm.second_joint_absolute)
    pairs = (np.abs(change), -np.abs(change)) if np.abs(change).max() > _RIGHT else (change,)
    return "zero: " + " or ".join("[{:.5g}, {:.5g}]".format(*(pair + 0.0)) for pair in pairs)  # no negative zero


def low_pass(signals: Array, h: float) -> Array:
    """Low-pass signals (..., N) with the gain of a Butterworth filter of order 2 run forwards and backwards."""
    # A signal less the line between its ends is a sum of sines.
    n = signals.shape[-1]
    line = np.linspace(signals[..., 0], signals[..., -1], n, axis=-1)
    angle = 0.5 * np.pi * np.arange(1, n - 1) / (n - 1)
    gain = 1.0 / (1.0 + (np.tan(angle) / np.tan(np.pi * min(_CUTOFF_HZ * h, 0.4))) ** 4)
    line[..., 1:-1] += idst(gain * dst((signals - line)[..., 1:-1], type=1), type=1)
    return line


def smoothed(log: Log) -> Smoothed:
    """Low-pass without phase shift, differentiate, and select samples away from the ends."""
    even = uniform(log).longest
    h = period(even)
    q, tau = low_pass(even.q, h), low_pass(even.tau, h)
    dq = np.gradient(q, h, axis=1)
    edge, n = round(_EDGE_S / h), q.shape[1]
    chosen = np.arange(edge, n - edge, -(-n // _MAX_SAMPLES))
    return Smoothed(q, dq, np.gradient(dq, h, axis=1), tau, h, chosen, even.tau - tau)


def fit_joints(y: Array, tau: Array) -> tuple[Array, Array]:
    """Fit Eq. 1 with each joint weighted by its own error: parameters (9,), and squared errors of the joints (2,)."""
    gram, right = np.swapaxes(y, 1, 2) @ y, np.einsum("jnp,jn->jp", y, tau)  # of each joint
    size = np.sum(tau**2, axis=1)
    error, beta = size, np.zeros(y.shape[-1])
    for _ in range(_FITS):
        weight = 1.0 / np.where(error > 0.0, error, 1.0)
        normal = np.tensordot(weight, gram, 1)
        length = np.sqrt(np.where(normal.diagonal() > 0.0, normal.diagonal(), 1.0))
        scaled = normal / length / length[:, np.newaxis]
        beta = np.linalg.lstsq(scaled, weight @ right / length, _MIN_SINGULAR_RATIO)[0] / length
        error = np.maximum(np.sum((y @ beta - tau) ** 2, axis=1), _MIN_SQUARED_ERROR * size)
    return beta, error


def _fit(smoothed: Smoothed, convention: Convention, absolute: bool = False) -> _Fit:
    """Fit Eq. 1 with a convention, each joint weighted by its own error; recorded angles of joint 2 may be absolute."""
    k, relative = smoothed.chosen, np.array([[1.0, 0.0], [-float(absolute), 1.0]])
    recorded, torque = (np.reshape(matrix, (2, 2)) for matrix in (convention.position, convention.torque))
    matrices = recorded, recorded / np.abs(recorded).max(axis=1, keepdims=True)
    position, sense = (relative @ matrix @ np.linalg.inv(relative) for matrix in matrices)
    q = position @ smoothed.q[:, k] + np.array(convention.offset)[:, np.newaxis]
    dq, tau = position @ smoothed.dq[:, k], torque @ smoothed.tau[:, k]
    y = regressor(q, dq, position @ smoothed.ddq[:, k])
    # The speed at which friction sets in is unknown: a factor on the positions must not choose another one.
    y[..., 7:] = np.tanh(LAMBDA * sense @ smoothed.dq[:, k])[..., np.newaxis] * np.eye(2)[:, np.newaxis]
    (beta, left), size = fit_joints(y, tau), np.sum(tau**2, axis=1)
    error = left / np.where(size > 0.0, size, size.sum())  # of a joint without a drive over the torque of the other
    recorded_size = np.sum(smoothed.tau[:, k] ** 2, axis=1)
    if (size > 0.0).all() and (recorded_size > 0.0).all():  # a sum of torques is not better for being larger
        error = error * np.sqrt(np.prod(size / recorded_size))
    terms = y * beta  # (2, n, 9): torque of each parameter
    share = np.sqrt(np.sum(terms**2, axis=1) / np.where(size > 0.0, size, size.sum())[:, np.newaxis]).max(axis=0)
    negative = (beta[:5] < 0.0) & (share[:5] > _MIN_NOTICEABLE_SHARE)
    friction = terms[..., 5:].sum(-1)
    noticeable = np.linalg.norm(friction, axis=1) > _MIN_NOTICEABLE_SHARE * np.linalg.norm(tau, axis=1)
    drives = noticeable & (np.sum(friction * dq, axis=1) < 0.0)
    return _Fit(error, float(np.sqrt(error @ size / size.sum())), int(negative.sum() + drives.sum()))


def _residual(basis: Array, torque: Array) -> float:
    """Fraction of a torque outside the span of an orthonormal basis."""
    size = float(np.linalg.norm(torque))
    return float(np.linalg.norm(torque - basis @ (basis.T @ torque))) / size if size > 0.0 else 1.0
