"""Logs of a known arm with content up to any frequency, and regressions made without a log."""

from dataclasses import replace

import log_example
import numpy as np
from log_example import BETA
from scipy.signal import lfilter

from repro.identification.least_squares import METHODS
from repro.identification.log import Log
from repro.identification.regression import Regression
from repro.model.dynamics import inverse_dynamics, regressor

#: Time between samples, s.
H = 0.02


def sinusoids(t, amplitude, frequency, phase):
    """Position, velocity and acceleration of a sum of sines for each joint, arguments (2, lines), frequency in Hz."""
    omega, size = 2 * np.pi * frequency[..., np.newaxis], amplitude[..., np.newaxis]
    turn = omega * t + phase[..., np.newaxis]
    sine = size * np.sin(turn)
    return sine.sum(1), (size * omega * np.cos(turn)).sum(1), (-(omega**2) * sine).sum(1)


def broadband(t, top=12.0, lines=60):
    """Sines up to `top` Hz, their amplitudes falling as 1/f^2."""
    rng = np.random.default_rng(11)
    frequency = np.linspace(0.15, top, lines) + rng.uniform(-0.05, 0.05, (2, lines))
    amplitude = 0.4 / (1.0 + (frequency / 0.5) ** 2)
    return sinusoids(t, amplitude, frequency, rng.uniform(0, 2 * np.pi, (2, lines)))


def log_from(motion, rate=200.0, seconds=12.0, beta=BETA, steepness=20.0, delay=0.0):
    """What a perfect recorder writes if the torque acts `delay` later than it is recorded."""
    t = np.arange(round(seconds * rate)) / rate
    tau = inverse_dynamics(*motion(t + delay), beta, steepness)
    return Log(name="log.csv", t=t, q=motion(t)[0], tau=tau)


def with_joint_fixed(moved, joint, at):
    """A motion with one joint fixed at an angle, or with none."""
    q, dq, ddq = moved
    if joint is not None:
        q[joint], dq[joint], ddq[joint] = at, 0.0, 0.0
    return q, dq, ddq


def with_noise(log, size, seed):
    """The log with white noise of this standard deviation in its torque."""
    return replace(log, tau=log.tau + size * np.random.default_rng(seed).normal(size=log.tau.shape))


def resting(joint, at):
    """A log of the known motion with one joint fixed at an angle, a little noise in the torque."""
    return with_noise(log_from(lambda t: with_joint_fixed(log_example.motion(t), joint, at)), 0.02, 0)


def regression_of(y, tau, even_odd=None):
    """A regression of any regressor (2, n, 9) and torque (2, n); its motion is zero, and every row counts."""
    halves = np.stack([y, y]) if even_odd is None else even_odd
    motion, every_row = np.zeros((3, *tau.shape)), np.ones(tau.shape, dtype=bool)
    return Regression(H * np.arange(tau.shape[1]), y, tau, *motion, every_row, H, halves)


def exact(moved, beta=BETA, noise=0.0):
    """The regression of a motion (q, dq, ddq) and of the torque it needs, with noise added to that."""
    y = regressor(*moved)
    return regression_of(y, y @ beta + noise)


def exciting(n):
    """The regression of the motion that excites all nine parameters."""
    return exact(log_example.motion(H * np.arange(n)))


def random_regressor(rng, n=60, joint=None, at=0.0):
    """Regressor of Eq. 1 at random states, which excite all nine parameters unless a joint is fixed."""
    return regressor(*with_joint_fixed([size * rng.normal(size=(2, n)) for size in (1.0, 2.0, 5.0)], joint, at))


def noisy_problem(seed, n, noise):
    """Random states of an arm, with normal errors of the torque; `noise` broadcasts to (2, n)."""
    rng = np.random.default_rng(seed)
    y = random_regressor(rng, n)
    return regression_of(y, y @ BETA + noise * rng.normal(size=(2, n)))


def hostile(seed, n=40, joint=None, at=0.0):
    """A regression whose best parameters are often not physical: signs of the truth are drawn."""
    rng = np.random.default_rng(seed)
    y = random_regressor(rng, n, joint, at)
    noise = rng.choice([0.01, 0.1, 1.0]) * rng.normal(size=(2, n))
    return regression_of(y, y @ (BETA * rng.choice([-1.0, 1.0, 1.0], 9)) + noise)


def beta_of(name, regression):
    """Parameters that a method finds."""
    return METHODS[name].estimate(regression).beta


def rows_of(regression):
    """The rows (2 n, 9) of the regressor."""
    return regression.y.reshape(-1, 9)


def other_motion(t):
    """Two sinusoids a joint, faster and around another place than those of `log_example.motion`."""
    frequency, amplitude = np.array([[0.4, 0.9], [0.3, 1.0]]), np.array([[0.5, -0.25], [0.6, 0.3]])
    q, dq, ddq = sinusoids(t, amplitude, frequency, np.array([[0.1, 2.0], [1.4, 0.6]]))
    return q + np.array([[0.3], [-0.4]]), dq, ddq


def autoregressive(rho, n, rng, size=1.0):
    """Both joints' noise e[k] = rho e[k-1] + white, of standard deviation `size` from the first sample on."""
    white = np.sqrt(1.0 - rho**2) * rng.normal(size=(2, n))
    white[:, 0] /= np.sqrt(1.0 - rho**2)
    return size * lfilter([1.0], [1.0, -rho], white, axis=-1)
