"""Algorithm 1, lines 1 to 12: from a position and a torque to the signals that the search works on."""

from dataclasses import dataclass, replace

import numpy as np

from repro.identification.regression import Regression
from repro.model.dynamics import LAMBDA, check_motion, regressor
from repro.model.parameters import Array
from repro.signals.dct import dct2dev, dct2low, dct2sub
from repro.signals.sampling import SignalSettings, image_regressor


@dataclass(frozen=True)
class Prepared:
    """Signals after line 12.

    Attributes
    ----------
    regression : Regression
        The cut signals in canonical time, in which the trajectory lasts as long as in training; the torque as it is
        before line 6. Lines 30 and 31 compare on it.
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
    pace : float
        Canonical time over recorded time.
    """

    regression: Regression
    c_p: float
    largest: float
    alpha: Array
    model: Array
    y_sub: Array
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


def derivatives(q: Array, settings: SignalSettings) -> tuple[Array, Array, Array]:
    """Position with its velocity and acceleration (lines 1 and 2), each of shape (2, N)."""
    dq = dct2dev(q, settings.h, settings.c_f, settings.reading)
    return q, dq, dct2dev(dq, settings.h, settings.c_f, settings.reading)


def regression_of(motion: tuple[Array, Array, Array], tau: Array, settings: SignalSettings) -> Regression:
    """A motion and its torque, filtered already, as what methods solve.

    Parameters
    ----------
    motion : tuple of three arrays of shape (2, N)
        Position (rad), velocity (rad/s), acceleration (rad/s^2).
    tau : array of shape (2, N)
        Torque, N m.
    settings : SignalSettings
        Sampling period and filter.

    Returns
    -------
    Regression
        Every sample counts.
    """
    t: Array = settings.h * np.arange(tau.shape[-1], dtype=np.float64)
    moving = np.ones(tau.shape, dtype=np.bool_)
    return Regression(t, regressor(*motion), tau, *motion, moving, settings.h)


def filtered(q: Array, tau: Array, settings: SignalSettings, n1: int = 0, n2: int | None = None) -> Regression:
    """Lines 1 to 4 of Algorithm 1: derivatives and filtered torque, then **cut**.

    Parameters
    ----------
    q : array of shape (2, N)
        Measured position, rad.
    tau : array of shape (2, N)
        Measured torque, N m.
    settings : SignalSettings
        Sampling period and filter.
    n1, n2 : int
        First sample kept and the one after the last; all by default.

    Returns
    -------
    Regression
        In recorded time.

    Raises
    ------
    ValueError
        If shapes differ, values are not finite, or the cut is empty.
    """
    q, tau = check_motion(q, tau)
    n2 = q.shape[-1] if n2 is None else n2
    if not 0 <= n1 < n2 - settings.samples <= q.shape[-1] - settings.samples:
        raise ValueError(f"n1, n2: {n1} to {n2} must lie in 0 to {q.shape[-1]} and hold over {settings.samples}.")
    tau = dct2low(tau, settings.h, settings.c_f, settings.reading)  # line 3
    position, velocity, acceleration = (x[:, n1:n2] for x in derivatives(q, settings))
    return regression_of((position, velocity, acceleration), tau[:, n1:n2], settings)  # line 4


def prepare(
    recorded: Regression,
    tau_mean: Array,
    settings: SignalSettings,
    pace: float = 1.0,
    shown: tuple[Array, Array, Array] | None = None,
) -> Prepared:
    """Lines 5 to 12 of Algorithm 1.

    Parameters
    ----------
    recorded : Regression
        Cut and filtered signals in recorded time.
    tau_mean : array of shape (2, N)
        Mean torque of the training data at the same samples.
    settings : SignalSettings
        Length of the subsampled signals.
    pace : float
        Canonical time over recorded time, for a trajectory that was run slower or faster than in training.
    shown : tuple of three arrays of shape (2, N), optional
        Motion in recorded time that f of the image is taken on, an extension of ours; the measured one by default.

    Returns
    -------
    Prepared
        Signals for the search.

    Raises
    ------
    ValueError
        If shapes differ, `pace` is not positive, or the torque is zero throughout.
    """
    if not 0 < pace < np.inf:
        raise ValueError(f"pace: must be positive and finite, got {pace}.")
    steepness = LAMBDA * pace  # tanh(lambda dq/dt) = tanh(lambda pace dq/dt')
    c_p = fit2trt(recorded.tau, tau_mean)  # line 5
    # Line 6 multiplies tau by c_p. Line 12 divides by the largest torque, so c_p reaches the result in line 32
    # alone, where it cancels; it is left out of the signals here and carried as a number.
    r = recorded
    motion = (r.q, r.dq / pace, r.ddq / pace**2)
    seen = motion if shown is None else (shown[0], shown[1] / pace, shown[2] / pace**2)
    q_s, dq_s, ddq_s, tau_s = (dct2sub(x, settings.samples) for x in (*motion, r.tau))  # line 7
    largest = float(np.abs(tau_s).max())  # line 12, bmax: one maximum for both torques
    return Prepared(
        replace(r, q=motion[0], dq=motion[1], ddq=motion[2], y=regressor(*motion, steepness)),
        c_p,
        largest,
        tau_s / largest,
        model=image_regressor(*seen, settings, steepness),
        y_sub=regressor(q_s, dq_s, ddq_s, steepness),
        pace=pace,
    )
