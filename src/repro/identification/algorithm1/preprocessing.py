"""Algorithm 1, lines 1 to 12: from a position and a torque to the signals that the search works on."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from repro.identification.regression import Regression
from repro.model.dynamics import LAMBDA, check_motion, regressor
from repro.model.parameters import Array
from repro.signals.dct import SignalSettings, dct2dev, dct2low, dct2sub, image_regressor


@dataclass(frozen=True)
class PreparedSignals:
    """Signals after line 12."""

    regression: Regression  # the cut signals in canonical time, in which training is; the torque before line 6
    c_p: float  # factor of **fit2trt** (Eq. 15)
    torque_scale: float  # largest magnitude of the subsampled torque, N m, before line 6: unit of the parameters
    alpha: Array  # subsampled torque over `torque_scale` (tau_n), (2, M)
    model: Array  # regressor f uses in the image (line 18), (2, M, 9)
    y_sub: Array  # regressor of the subsampled motion (line 26), (2, M, 9)
    time_scale: float = 1.0  # canonical time over recorded time

    def to_recorded_time(self, beta: Array) -> Array:
        """Convert parameters (..., 9) from canonical to recorded time: with t' = p t, Eq. 1 keeps its form."""
        p = self.time_scale
        return np.asarray(beta / np.array([p**2, p**2, p**2, 1.0, 1.0, p, p, 1.0, 1.0]))


def fit2trt(tau: Array, tau_mean: Array) -> float:
    """Compute the mean of |tau_mean| / |tau|, norms over the joints (2, N), where tau is not zero (Eq. 15, Fig. 9)."""
    if tau.shape != tau_mean.shape:
        raise ValueError(f"tau, tau_mean: shapes {tau.shape} and {tau_mean.shape} differ.")
    norm = np.linalg.norm(tau, axis=0)
    level = norm > 1e-9 * norm.max()
    if not level.any():
        raise ValueError("tau: the torque is zero throughout.")
    return float(np.mean(np.linalg.norm(tau_mean, axis=0)[level] / norm[level]))


def derivatives(q: Array, settings: SignalSettings) -> tuple[Array, Array, Array]:
    """Differentiate a position (2, N) twice (lines 1 and 2)."""
    dq = dct2dev(q, settings.sampling_period_s, settings.filter_coefficient, settings.frequency_reading)
    return q, dq, dct2dev(dq, settings.sampling_period_s, settings.filter_coefficient, settings.frequency_reading)


def filtered(
    q: ArrayLike, tau: ArrayLike, settings: SignalSettings, begin: int = 0, end: int | None = None
) -> Regression:
    """Apply lines 1 to 4 of Algorithm 1 to measured q and tau (2, N); **cut** keeps the samples begin to end - 1."""
    q, tau = check_motion(q, tau)
    n, m = q.shape[-1], settings.image_samples
    end = n if end is None else end
    if not 0 <= begin < end - m <= n - m:
        raise ValueError(f"begin, end: {begin} to {end} must lie in 0 to {n} and hold over {m} samples.")
    tau = dct2low(tau, settings.sampling_period_s, settings.filter_coefficient, settings.frequency_reading)  # line 3
    q, dq, ddq, tau = (x[:, begin:end] for x in (*derivatives(q, settings), tau))  # line 4
    time: Array = settings.sampling_period_s * np.arange(end - begin, dtype=np.float64)
    return Regression(
        time, regressor(q, dq, ddq), tau, q, dq, ddq, np.ones(tau.shape, dtype=np.bool_), settings.sampling_period_s
    )


def prepare(
    recorded: Regression,
    tau_mean: Array,
    settings: SignalSettings,
    time_scale: float = 1.0,
    image_motion: tuple[Array, Array, Array] | None = None,
) -> PreparedSignals:
    """Apply lines 5 to 12 of Algorithm 1 to cut and filtered signals in recorded time.

    `tau_mean` (2, N) is the mean torque of the training data at the same samples. f of the image is evaluated on
    `image_motion` (an extension of ours), by default the measured motion.
    """
    r, steepness = recorded, LAMBDA * time_scale  # tanh(lambda dq/dt) = tanh(lambda p dq/dt') with t' = p t
    # Line 6 multiplies tau by c_p of line 5. Line 12 divides by the largest torque, so c_p reaches the result in line
    # 32 alone, where it cancels; it is left out of the signals here and carried as a number.
    c_p = fit2trt(recorded.tau, tau_mean)
    motion, shown = (
        (q, dq / time_scale, ddq / time_scale**2)
        for q, dq, ddq in ((r.q, r.dq, r.ddq), image_motion or (r.q, r.dq, r.ddq))
    )
    q_s, dq_s, ddq_s, tau_s = (dct2sub(x, settings.image_samples) for x in (*motion, r.tau))  # line 7
    torque_scale = float(np.abs(tau_s).max())  # line 12, bmax: one maximum for both torques
    return PreparedSignals(
        replace(r, q=motion[0], dq=motion[1], ddq=motion[2], y=regressor(*motion, steepness)),
        c_p,
        torque_scale,
        tau_s / torque_scale,
        model=image_regressor(*shown, settings, steepness),
        y_sub=regressor(q_s, dq_s, ddq_s, steepness),
        time_scale=time_scale,
    )
