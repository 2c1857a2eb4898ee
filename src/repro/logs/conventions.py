"""Conventions of a log (joint order, signs, units, coarse zeros): does another one explain its torque far better?

Small errors of zero, offset and scale are estimated in `repro.identification`.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.signal import butter, sosfiltfilt

from repro.logs.log import Log, period, uniform
from repro.model.dynamics import regressor
from repro.model.parameters import Array

#: Low-pass, Hz, most samples fitted, and time left out at each end, s: enough to distinguish conventions.
_CUTOFF, _MOST_SAMPLES, _EDGE = 6.0, 2000, 0.3
#: Another convention is reported if it leaves less than this fraction of the residual of a bad fit,
_RESIDUAL_RATIO, _BAD_RESIDUAL = 0.5, 0.1
#: or if it leaves the same, and only this one has a term of the wrong sign with this fraction of the torque.
_SAME_RATIO, _NOTICEABLE_TERM = 1.0 + 1e-6, 0.15
#: Ratio of residuals up to which two conventions fit equally well.
_EQUAL_RATIO = 1.05
#: Residual above which a fit explains nothing.
_USELESS_RESIDUAL = 0.6
#: Noise over torque above which conventions cannot be distinguished.
_MOST_NOISE = 1.0 / 3.0
#: Delays examined, s; `repro identify` estimates smaller ones by itself.
_SMALLEST_DELAY, _LARGEST_DELAY = 0.03, 0.3


@dataclass(frozen=True)
class Convention:
    """Another meaning of the columns: ``q' = position @ q + offset`` and ``tau' = torque @ tau``."""

    name: str
    remedy: str  # what to write in the arm file
    position: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 1.0)  # a matrix (2, 2) by rows
    torque: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)  # rad


_SWAP: Final = (0.0, 1.0, 1.0, 0.0)
_DEGREE: Final = np.pi / 180.0
_RIGHT: Final = np.pi / 2.0

#: Of conventions that fit equally well the first is reported.
CONVENTIONS: Final = (
    Convention("joints 1 and 2 swapped", "swap columns q1, q2 and tau1, tau2", _SWAP, _SWAP),
    Convention("the torques of joints 1 and 2 swapped", "swap columns tau1 and tau2", torque=_SWAP),
    Convention("the torques of the other sign", "torque_sign: [-1, -1]", torque=(-1.0, 0.0, 0.0, -1.0)),
    Convention("the torque of joint 1 of the other sign", "torque_sign: [-1, 1]", torque=(-1.0, 0.0, 0.0, 1.0)),
    Convention("the torque of joint 2 of the other sign", "torque_sign: [1, -1]", torque=(1.0, 0.0, 0.0, -1.0)),
    Convention("joint 2 of the other sign", "sign: [1, -1]", (1.0, 0.0, 0.0, -1.0), (1.0, 0.0, 0.0, -1.0)),
    Convention("q1 alone of the other sign", "sign: [-1, 1] and torque_sign: [-1, 1]", (-1.0, 0.0, 0.0, 1.0)),
    Convention("q2 alone of the other sign", "sign: [1, -1] and torque_sign: [1, -1]", (1.0, 0.0, 0.0, -1.0)),
    Convention("q2 measured from the vertical", "second_joint_absolute: true", (1.0, 0.0, -1.0, 1.0)),
    Convention("q2 relative to link 1", "second_joint_absolute: false", (1.0, 0.0, 1.0, 1.0)),
    Convention("positions in degrees", "units: {position: deg}", (_DEGREE, 0.0, 0.0, _DEGREE)),
    Convention("q1 = 0 upright", "zero: [3.1416, 0] or [-3.1416, 0]", offset=(np.pi, 0.0)),
    Convention("q1 = 0 horizontal", "zero: [-1.5708, 0]", offset=(_RIGHT, 0.0)),
    Convention("q1 = 0 horizontal", "zero: [1.5708, 0]", offset=(-_RIGHT, 0.0)),
    Convention("q2 = 0 folded back", "zero: [0, 3.1416] or [0, -3.1416]", offset=(0.0, np.pi)),
    Convention("q2 = 0 at a right angle", "zero: [0, -1.5708]", offset=(0.0, _RIGHT)),
    Convention("q2 = 0 at a right angle", "zero: [0, 1.5708]", offset=(0.0, -_RIGHT)),
)


@dataclass(frozen=True)
class _Smoothed:
    """Low-passed motion and torque (2, N), and the samples to fit."""

    q: Array
    dq: Array
    ddq: Array
    tau: Array
    h: float
    chosen: np.ndarray[tuple[int], np.dtype[np.intp]]
    noise: Array  # the part of the torque above the cutoff

    def noisy_joints(self, fraction: float = 1.0) -> list[int]:
        """List joints whose noise is at least this fraction of the torque."""
        size = fraction * np.linalg.norm(self.tau[:, self.chosen], axis=1)
        return [joint + 1 for joint in (0, 1) if size[joint] <= np.linalg.norm(self.noise[joint, self.chosen])]


def quiet_joints(log: Log) -> list[int]:
    """List joints whose torque does not exceed its noise."""
    return _smoothed(log).noisy_joints()


def better_convention(log: Log, second_joint_absolute: bool) -> Iterator[str]:
    """Report a convention that explains the torque far better, or equally well with possible signs only.

    Ordinary least squares of Eq. 1 on coarsely low-passed signals. Least squares itself takes any sign: a wrong
    sign of the torque or a wrong zero comes out as negative inertia, gravity or friction.
    """
    smoothed = _smoothed(log)
    size = np.linalg.norm(smoothed.tau[:, smoothed.chosen], axis=1)
    if size.min() < 1e-6 * np.linalg.norm(log.tau):  # driven at the ends only
        return
    if smoothed.noisy_joints(_MOST_NOISE):
        noisy = smoothed.noisy_joints()
        if len(noisy) == 2:
            yield "the torque is little more than noise: this log can only test the motion that parameters predict"
        elif noisy:
            yield (
                f"the torque of joint {noisy[0]} is little more than noise: the log hardly determines its load; "
                "if the joint was driven, its torque was not recorded"
            )
        return
    given, n_impossible = _fit(smoothed, Convention("", ""))
    in_force = f"second_joint_absolute: {str(second_joint_absolute).lower()}"
    others = [convention for convention in CONVENTIONS if convention.remedy != in_force]
    fits = [(*_fit(smoothed, convention), convention) for convention in others]
    least = min(residual for residual, _, _ in fits)
    if given > _BAD_RESIDUAL and least < _RESIDUAL_RATIO * given:
        equal = [fit for fit in fits if fit[0] < _EQUAL_RATIO * least]
        best, _, convention = min(equal, key=lambda fit: fit[1])
        yield _advice(convention, f"torque residual {100.0 * best:.0f} % instead of {100.0 * given:.0f} %")
    elif given > _USELESS_RESIDUAL:
        yield (
            f"Eq. 1 explains little of the torque (residual {100.0 * given:.0f} %) with any single change of "
            "how the log is read: check units, signs, zeros and which column is which"
        )
    elif n_impossible:
        possible = [convention for residual, n, convention in fits if residual < _SAME_RATIO * given and n == 0]
        for convention in possible[:1]:
            yield _advice(convention, "as given, inertia, gravity or friction come out negative")


def late_torque(log: Log) -> Iterator[str]:
    """Report a torque that fits the motion far better when it is shifted in time."""
    smoothed = _smoothed(log)
    reach = round(_LARGEST_DELAY / smoothed.h)
    inner = smoothed.chosen[(smoothed.chosen >= reach) & (smoothed.chosen < smoothed.q.shape[1] - reach)]
    if inner.size < 20 or smoothed.noisy_joints():
        return
    y = regressor(smoothed.q[:, inner], smoothed.dq[:, inner], smoothed.ddq[:, inner]).reshape(-1, 9)
    basis = np.linalg.qr(y).Q
    shifts = np.arange(-reach, reach + 1, max(1, round(0.005 / smoothed.h)))
    residuals = np.array([_residual(basis, smoothed.tau[:, inner - shift].ravel()) for shift in shifts])
    given = _residual(basis, smoothed.tau[:, inner].ravel())
    best = int(np.argmin(residuals))
    delay = float(shifts[best]) * smoothed.h
    if abs(delay) >= _SMALLEST_DELAY and residuals[best] <= _RESIDUAL_RATIO * given:
        side = "later" if delay > 0 else "earlier"
        yield (
            f"the torque fits the motion best {abs(delay):.3f} s {side} than recorded (residual "
            f"{100 * residuals[best]:.0f} % instead of {100 * given:.0f} %): check the time stamps, or give delay in "
            "the arm file"
        )


def _advice(convention: Convention, reason: str) -> str:
    added = "" if convention.remedy.startswith(("swap", "second", "units")) else ", on top of what is there"
    return f"the log reads better with {convention.name} ({reason}): if so, {convention.remedy} in the arm file{added}"


def _smoothed(log: Log) -> _Smoothed:
    """Low-pass without phase shift, differentiate, and select samples away from the ends."""
    even = uniform(log).longest
    h = period(even)
    sections = butter(2, min(_CUTOFF * 2.0 * h, 0.8), output="sos")
    q, tau = (sosfiltfilt(sections, signal, axis=1) for signal in (even.q, even.tau))
    dq = np.gradient(q, h, axis=1)
    edge, n = round(_EDGE / h), q.shape[1]
    chosen = np.arange(edge, n - edge, -(-n // _MOST_SAMPLES))
    return _Smoothed(q, dq, np.gradient(dq, h, axis=1), tau, h, chosen, even.tau - tau)


def _fit(smoothed: _Smoothed, convention: Convention) -> tuple[float, int]:
    """Fit Eq. 1 by least squares: residual over torque, RMS, and number of noticeable terms of an impossible sign."""
    k = smoothed.chosen
    position, torque = (np.reshape(matrix, (2, 2)) for matrix in (convention.position, convention.torque))
    q = position @ smoothed.q[:, k] + np.array(convention.offset)[:, np.newaxis]
    tau = torque @ smoothed.tau[:, k]
    dq = position @ smoothed.dq[:, k]
    y = regressor(q, dq, position @ smoothed.ddq[:, k])
    beta = np.linalg.lstsq(y.reshape(-1, 9), tau.ravel(), rcond=None)[0]
    terms = y * beta  # (2, n, 9): torque of each parameter
    residual = float(np.linalg.norm(terms.sum(-1) - tau) / np.linalg.norm(tau))
    size = np.sqrt(np.mean(terms**2, axis=1) / np.mean(tau**2, axis=1, keepdims=True)).max(axis=0)
    negative = (beta[:5] < 0.0) & (size[:5] > _NOTICEABLE_TERM)
    friction = terms[..., 5:].sum(-1)
    drives = (np.sum(friction * dq, axis=1) < 0.0) & (
        np.linalg.norm(friction, axis=1) > _NOTICEABLE_TERM * np.linalg.norm(tau, axis=1)
    )
    return residual, int(negative.sum() + drives.sum())


def _residual(basis: Array, torque: Array) -> float:
    """Fraction of a torque outside the span of an orthonormal basis."""
    size = float(np.linalg.norm(torque))
    return float(np.linalg.norm(torque - basis @ (basis.T @ torque))) / size if size > 0.0 else 1.0
