"""Other ways to read a log, and whether one of them explains its torque far better than the way it was read."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.signal import butter, sosfiltfilt

from repro.logs.log import Log, period
from repro.logs.uniform import uniform
from repro.model.dynamics import regressor
from repro.model.parameters import Array

#: Low-pass, Hz, samples fitted at most and length left out at each end, s: coarse, to tell readings apart.
_CUTOFF, _MOST_SAMPLES, _CUT = 6.0, 2000, 0.3
#: Another reading is told if it leaves less than this share of the residual of a bad fit,
_FAR_BETTER, _BAD = 0.5, 0.1
#: or leaves the same, as its mirror image, while this one has a term of the wrong sign with this share of the torque.
_SAME, _NOTICEABLE = 1.0 + 1e-6, 0.15
#: Readings whose residuals differ by less are alike.
_ALIKE = 1.05
#: A fit of this residual explains nothing.
_HOPELESS = 0.6
#: Noise of a torque over the torque above which other readings of the log are not told from this one.
_CLEAR = 1.0 / 3.0
#: Delays looked at, s: those that `repro identify` finds by itself are not worth a warning.
_SMALL_DELAY, _LARGE_DELAY = 0.03, 0.3


@dataclass(frozen=True)
class Reading:
    """Another meaning of the columns: ``q' = position @ q + offset`` and ``tau' = torque @ tau``."""

    words: str  # what would be different
    remedy: str  # what to write in the arm file
    # Matrices of shape (2, 2), one row after the other
    position: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 1.0)
    torque: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)  # rad


_SWAP: Final = (0.0, 1.0, 1.0, 0.0)
_DEGREE: Final = np.pi / 180.0
_RIGHT: Final = np.pi / 2.0

#: Simple ones first: of readings that fit alike the first is told.
READINGS: Final = (
    Reading("joints 1 and 2 swapped", "swap columns q1, q2 and tau1, tau2", _SWAP, _SWAP),
    Reading("the torques of joints 1 and 2 swapped", "swap columns tau1 and tau2", torque=_SWAP),
    Reading("the torques of the other sign", "torque_sign: [-1, -1]", torque=(-1.0, 0.0, 0.0, -1.0)),
    Reading("the torque of joint 1 of the other sign", "torque_sign: [-1, 1]", torque=(-1.0, 0.0, 0.0, 1.0)),
    Reading("the torque of joint 2 of the other sign", "torque_sign: [1, -1]", torque=(1.0, 0.0, 0.0, -1.0)),
    Reading("joint 2 of the other sign", "sign: [1, -1]", (1.0, 0.0, 0.0, -1.0), (1.0, 0.0, 0.0, -1.0)),
    Reading("q2 measured from the vertical", "second_joint_absolute: true", (1.0, 0.0, -1.0, 1.0)),
    Reading("q2 relative to link 1", "second_joint_absolute: false", (1.0, 0.0, 1.0, 1.0)),
    Reading("positions in degrees", "units: {position: deg}", (_DEGREE, 0.0, 0.0, _DEGREE)),
    Reading("q1 = 0 upright", "zero: [3.1416, 0] or [-3.1416, 0]", offset=(np.pi, 0.0)),
    Reading("q1 = 0 horizontal", "zero: [-1.5708, 0]", offset=(_RIGHT, 0.0)),
    Reading("q1 = 0 horizontal", "zero: [1.5708, 0]", offset=(-_RIGHT, 0.0)),
    Reading("q2 = 0 folded back", "zero: [0, 3.1416] or [0, -3.1416]", offset=(0.0, np.pi)),
    Reading("q2 = 0 at a right angle", "zero: [0, -1.5708]", offset=(0.0, _RIGHT)),
    Reading("q2 = 0 at a right angle", "zero: [0, 1.5708]", offset=(0.0, -_RIGHT)),
)


@dataclass(frozen=True)
class _Smooth:
    """Low-passed motion and torque and what the low-pass took of it, all of shape (2, N), and the samples to fit."""

    q: Array
    dq: Array
    ddq: Array
    tau: Array
    h: float
    chosen: np.ndarray[tuple[int], np.dtype[np.intp]]
    noise: Array

    def quiet(self, share: float = 1.0) -> list[int]:
        """Joints whose torque is not above its noise, or this share of it: nothing can be told by it."""
        size = share * np.linalg.norm(self.tau[:, self.chosen], axis=1)
        return [joint + 1 for joint in (0, 1) if size[joint] <= np.linalg.norm(self.noise[joint, self.chosen])]


@dataclass(frozen=True)
class _Fit:
    """Residual over torque, RMS, and noticeable terms of a sign that no arm has."""

    residual: float
    impossible: int


def _told_of_quiet(joints: list[int]) -> str | None:
    """What to say of joints whose torque is not above its noise."""
    if len(joints) == 2:
        return "the torque is little more than noise: this log can only judge the motion that parameters foretell"
    if joints:
        return (
            f"the torque of joint {joints[0]} is little more than noise: the log hardly tells what it carries; "
            "if the joint was driven, its torque was not recorded"
        )
    return None


def quiet_joints(log: Log) -> list[int]:
    """Joints whose torque is not above its noise."""
    return _smooth(log).quiet()


def other_reading(log: Log) -> str | None:
    """Another reading that explains the torque far better, or as well with signs that are possible.

    Ordinary least squares of Eq. 1 on coarsely low-passed signals. Least squares itself takes any sign: a wrong
    sign of the torque or a wrong zero comes out as negative inertia, gravity or friction.
    """
    smooth = _smooth(log)
    size = np.linalg.norm(smooth.tau[:, smooth.chosen], axis=1)
    if size.min() < 1e-6 * np.linalg.norm(log.tau):  # driven at the ends only
        return None
    if smooth.quiet(_CLEAR):
        return _told_of_quiet(smooth.quiet())
    given = _fit(smooth, Reading("", ""))
    fits = [(_fit(smooth, reading), reading) for reading in READINGS]
    bound = given.residual * (_FAR_BETTER if given.residual > _BAD else 0.0)
    least = min(fit.residual for fit, _ in fits)
    if least < bound:
        alike = [(fit, reading) for fit, reading in fits if fit.residual < _ALIKE * least]
        best, reading = min(alike, key=lambda pair: pair[0].impossible)
        return _told(reading, f"torque residual {_percent(best)} instead of {_percent(given)}")
    if given.residual > _HOPELESS:
        return (
            f"Eq. 1 explains little of the torque (residual {_percent(given)}) however the log is read: "
            "check units, signs, zeros and which column is which"
        )
    possible = [
        reading
        for fit, reading in fits
        if fit.residual < _SAME * given.residual and fit.impossible == 0 < given.impossible
    ]
    if possible:
        return _told(possible[0], "as given, inertia, gravity or friction come out negative")
    return None


def late_torque(log: Log) -> str | None:
    """Torque that fits the motion far better when it is shifted in time."""
    smooth = _smooth(log)
    reach = round(_LARGE_DELAY / smooth.h)
    inner = smooth.chosen[(smooth.chosen >= reach) & (smooth.chosen < smooth.q.shape[1] - reach)]
    if inner.size < 20 or smooth.quiet():
        return None
    y = regressor(smooth.q[:, inner], smooth.dq[:, inner], smooth.ddq[:, inner]).reshape(-1, 9)
    basis = np.linalg.qr(y).Q
    shifts = np.arange(-reach, reach + 1, max(1, round(0.005 / smooth.h)))
    residuals = np.array([_left(basis, smooth.tau[:, inner - shift].ravel()) for shift in shifts])
    given = _left(basis, smooth.tau[:, inner].ravel())
    best = int(np.argmin(residuals))
    delay = float(shifts[best]) * smooth.h
    if abs(delay) < _SMALL_DELAY or residuals[best] > _FAR_BETTER * given:
        return None
    side = "later" if delay > 0 else "earlier"
    return (
        f"the torque fits the motion best {abs(delay):.3f} s {side} than recorded (residual "
        f"{100 * residuals[best]:.0f} % instead of {100 * given:.0f} %): check the time stamps, or give delay in the "
        "arm file"
    )


def _told(reading: Reading, why: str) -> str:
    more = "" if reading.remedy.startswith(("swap", "second", "units")) else ", on top of what is there"
    return f"the log reads better with {reading.words} ({why}): if so, {reading.remedy} in the arm file{more}"


def _percent(fit: _Fit) -> str:
    return f"{100.0 * fit.residual:.0f} %"


def _smooth(log: Log) -> _Smooth:
    """Zero-phase low-pass, differences, and every so many samples without the ends."""
    even = uniform(log).longest
    h = period(even)
    sections = butter(2, min(_CUTOFF * 2.0 * h, 0.8), output="sos")
    q, tau = (sosfiltfilt(sections, signal, axis=1) for signal in (even.q, even.tau))
    dq = np.gradient(q, h, axis=1)
    cut, n = round(_CUT / h), q.shape[1]
    chosen = np.arange(cut, n - cut, -(-n // _MOST_SAMPLES))
    return _Smooth(q, dq, np.gradient(dq, h, axis=1), tau, h, chosen, even.tau - tau)


def _fit(smooth: _Smooth, reading: Reading) -> _Fit:
    """Least squares of Eq. 1 for a reading."""
    k = smooth.chosen
    position, torque = (np.reshape(matrix, (2, 2)) for matrix in (reading.position, reading.torque))
    q = position @ smooth.q[:, k] + np.array(reading.offset)[:, np.newaxis]
    tau = torque @ smooth.tau[:, k]
    dq = position @ smooth.dq[:, k]
    y = regressor(q, dq, position @ smooth.ddq[:, k])
    beta = np.linalg.lstsq(y.reshape(-1, 9), tau.ravel(), rcond=None)[0]
    terms = y * beta  # (2, n, 9): torque of each parameter
    residual = float(np.linalg.norm(terms.sum(-1) - tau) / np.linalg.norm(tau))
    size = np.sqrt(np.mean(terms**2, axis=1) / np.mean(tau**2, axis=1, keepdims=True)).max(axis=0)
    negative = (beta[:5] < 0.0) & (size[:5] > _NOTICEABLE)
    rubbing = terms[..., 5:].sum(-1)
    drives = (np.sum(rubbing * dq, axis=1) < 0.0) & (
        np.linalg.norm(rubbing, axis=1) > _NOTICEABLE * np.linalg.norm(tau, axis=1)
    )
    return _Fit(residual, int(negative.sum()) + int(drives.sum()))


def _left(basis: Array, torque: Array) -> float:
    """Share of a torque that an orthonormal basis leaves."""
    size = float(np.linalg.norm(torque))
    return float(np.linalg.norm(torque - basis @ (basis.T @ torque))) / size if size > 0.0 else 1.0
