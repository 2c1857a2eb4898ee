"""Algorithm 1, lines 1 to 12: from a position and a torque to the signals that the search works on."""

from dataclasses import dataclass

import numpy as np

from repro.cnn.dataset import SignalSettings, image_regressor
from repro.model.dynamics import LAMBDA, check_motion, regressor
from repro.model.parameters import Array
from repro.signals.dct import dct2dev, dct2low, dct2sub


@dataclass(frozen=True)
class Prepared:
    """Signals after line 12.

    Attributes
    ----------
    q, dq, ddq : arrays of shape (2, N)
        Cut position (rad), velocity (rad/s), acceleration (rad/s^2).
    tau : array of shape (2, N)
        Filtered and cut torque, N m, before line 6.
    c_p : float
        Factor of **fit2trt** (Eq. 15).
    largest : float
        Largest magnitude of the subsampled torque, N m, before line 6: the unit of the parameters in the search.
    alpha : array of shape (2, M)
        Subsampled torque over `largest` (tau_n).
    model : array of shape (2, M, 9)
        Regressor f uses in the image (line 18).
    y_sub : array of shape (2, M, 9)
        Regressor of the subsampled motion (line 26).
    y : array of shape (2, N, 9)
        Regressor of the cut motion (lines 30 and 31).
    pace : float
        Canonical time over recorded time. Motions and regressors above are in canonical time, in which the
        trajectory lasts as long as in training.
    """

    q: Array
    dq: Array
    ddq: Array
    tau: Array
    c_p: float
    largest: float
    alpha: Array
    model: Array
    y_sub: Array
    y: Array
    pace: float = 1.0

    def recorded(self, beta: Array) -> Array:
        """Parameters in recorded time from those in canonical time.

        With t' = pace t, Eq. 1 keeps its form when inertias are multiplied by pace^2 and viscous friction by
        pace; gravity and Coulomb friction stay.

        Parameters
        ----------
        beta : array of shape (..., 9)
            Canonical.

        Returns
        -------
        array of shape (..., 9)
            As the arm has them.
        """
        p = self.pace
        recorded: Array = beta / np.array([p**2, p**2, p**2, 1.0, 1.0, p, p, 1.0, 1.0])
        return recorded


def fit2trt(tau: Array, tau_mean: Array) -> float:
    """Factor that brings a torque to the level of the training torques (Eq. 15).

    Parameters
    ----------
    tau : array of shape (2, N)
        Torque.
    tau_mean : array of shape (2, N)
        Mean torque of the training data (Fig. 9).

    Returns
    -------
    float
        Mean over the samples of |tau_mean| / |tau|, the norms taken over the joints. Samples where the
        torque is zero to rounding carry no level and are left out.

    Raises
    ------
    ValueError
        If shapes differ or the torque is zero throughout.
    """
    if tau.shape != tau_mean.shape:
        raise ValueError(f"tau, tau_mean: shapes {tau.shape} and {tau_mean.shape} differ.")
    norm = np.linalg.norm(tau, axis=0)
    level = norm > 1e-9 * norm.max()
    if not level.any():
        raise ValueError("tau: the torque is zero throughout.")
    return float(np.mean(np.linalg.norm(tau_mean, axis=0)[level] / norm[level]))


def _cut_motion(q: Array, settings: SignalSettings, proper: slice, pace: float) -> tuple[Array, Array, Array]:
    """Lines 1, 2 and 4 for a position: the cut motion in canonical time."""
    dq = dct2dev(q, settings.h, settings.c_f, settings.reading)
    ddq = dct2dev(dq, settings.h, settings.c_f, settings.reading)
    return q[:, proper], dq[:, proper] / pace, ddq[:, proper] / pace**2


def prepare(
    q: Array,
    tau: Array,
    tau_mean: Array,
    settings: SignalSettings,
    n1: int = 0,
    n2: int | None = None,
    pace: float = 1.0,
    desired: Array | None = None,
) -> Prepared:
    """Lines 1 to 12 of Algorithm 1.

    Parameters
    ----------
    q : array of shape (2, N)
        Measured position, rad.
    tau : array of shape (2, N)
        Measured torque, N m.
    tau_mean : array of shape (2, n2 - n1)
        Mean torque of the training data at the cut samples.
    settings : SignalSettings
        Sampling period, filter and length of the subsampled signals.
    n1, n2 : int
        First sample kept and the one after the last; all by default.
    pace : float
        Canonical time over recorded time, for a trajectory that was run slower or faster than in training.
    desired : array of shape (2, N), optional
        Position as it was sent, rad: f of the image is taken on it instead of on `q`, an extension of ours.

    Returns
    -------
    Prepared
        Signals for the search.

    Raises
    ------
    ValueError
        If shapes differ, values are not finite, the cut is empty, `pace` is not positive, or the torque is
        zero throughout.
    """
    if not 0 < pace < np.inf:
        raise ValueError(f"pace: must be positive and finite, got {pace}.")
    q, tau = check_motion(q, tau)
    h, c_f, reading = settings.h, settings.c_f, settings.reading
    tau = dct2low(tau, h, c_f, reading)  # line 3
    n2 = q.shape[-1] if n2 is None else n2
    if not 0 <= n1 < n2 - settings.samples <= q.shape[-1] - settings.samples:
        raise ValueError(f"n1, n2: {n1} to {n2} must lie in 0 to {q.shape[-1]} and hold over {settings.samples}.")
    q, dq, ddq = _cut_motion(q, settings, slice(n1, n2), pace)
    tau = tau[:, n1:n2]  # line 4
    shown = (q, dq, ddq) if desired is None else _cut_motion(desired, settings, slice(n1, n2), pace)
    return assemble((q, dq, ddq), tau, tau_mean, settings, pace, shown)


def assemble(
    motion: tuple[Array, Array, Array],
    tau: Array,
    tau_mean: Array,
    settings: SignalSettings,
    pace: float = 1.0,
    shown: tuple[Array, Array, Array] | None = None,
) -> Prepared:
    """Lines 5 to 12 of Algorithm 1.

    Parameters
    ----------
    motion : tuple of three arrays of shape (2, N)
        Cut position, velocity and acceleration in canonical time.
    tau : array of shape (2, N)
        Filtered and cut torque, N m.
    tau_mean : array of shape (2, N)
        Mean torque of the training data.
    settings : SignalSettings
        Length of the subsampled signals.
    pace : float
        Canonical time over recorded time.
    shown : tuple of three arrays of shape (2, N), optional
        Motion that f of the image is taken on; `motion` by default.

    Returns
    -------
    Prepared
        Signals for the search.
    """
    steepness = LAMBDA * pace  # tanh(lambda dq/dt) = tanh(lambda pace dq/dt')
    c_p = fit2trt(tau, tau_mean)  # line 5
    # Line 6 multiplies tau by c_p. Line 12 divides by the largest torque, so c_p reaches the result in line 32
    # alone, where it cancels; it is left out of the signals here and carried as a number.
    q_s, dq_s, ddq_s, tau_s = (dct2sub(x, settings.samples) for x in (*motion, tau))  # line 7
    largest = float(np.abs(tau_s).max())  # line 12, bmax: one maximum for both torques
    return Prepared(
        *motion, tau, c_p, largest, tau_s / largest,
        model=image_regressor(*(motion if shown is None else shown), settings, steepness),
        y_sub=regressor(q_s, dq_s, ddq_s, steepness),
        y=regressor(*motion, steepness),
        pace=pace,
    )  # fmt: skip
