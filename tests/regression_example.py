"""Logs of a known arm with content up to any frequency, and regressions made without a log."""

import log_example
import numpy as np
from log_example import BETA
from scipy.signal import lfilter

from repro.identification.least_squares import METHODS
from repro.identification.regression import Regression
from repro.logs.log import Log
from repro.model.dynamics import inverse_dynamics, regressor

#: Time between samples and cut-off: a period of the cut-off is ten samples.
H, CUTOFF = 0.02, 5.0


def broadband(t, top=12.0, lines=60):
    """Position, velocity and acceleration with sines up to `top` Hz, their amplitudes falling as 1/f^2."""
    rng = np.random.default_rng(11)
    frequency = np.linspace(0.15, top, lines) + rng.uniform(-0.05, 0.05, (2, lines))
    amplitude = 0.4 / (1.0 + (frequency / 0.5) ** 2)
    omega = 2 * np.pi * frequency[..., np.newaxis]
    phase = omega * t + rng.uniform(0, 2 * np.pi, (2, lines, 1))
    amplitude = amplitude[..., np.newaxis]
    q = (amplitude * np.sin(phase)).sum(1)
    dq = (amplitude * omega * np.cos(phase)).sum(1)
    ddq = (-amplitude * omega**2 * np.sin(phase)).sum(1)
    return q, dq, ddq


def log_from(motion, rate=200.0, seconds=12.0, beta=BETA, steepness=20.0, delay=0.0):
    """What a perfect recorder writes if the torque acts `delay` later than it is recorded."""
    t = np.arange(round(seconds * rate)) / rate
    tau = inverse_dynamics(*motion(t + delay), beta, steepness)
    return Log(name="log.csv", t=t, q=motion(t)[0], tau=tau)


def resting(joint, at, rate=200.0, seconds=12.0, noise=0.02, seed=0):
    """The known motion with one joint fixed at an angle, a little noise in the torque."""
    t = np.arange(round(seconds * rate)) / rate
    q, dq, ddq = log_example.motion(t)
    q[joint], dq[joint], ddq[joint] = at, 0.0, 0.0
    tau = inverse_dynamics(q, dq, ddq, BETA) + noise * np.random.default_rng(seed).normal(size=q.shape)
    return Log(name="log.csv", t=t, q=q, tau=tau)


def regression_of(y, tau, h=H, even_odd=None):
    """A regression of any regressor (2, n, 9) and torque (2, n); its motion is zero, and every row counts."""
    n = y.shape[1]
    halves = np.stack([y, y]) if even_odd is None else even_odd
    q, dq, ddq = np.zeros((3, 2, n))
    return Regression(h * np.arange(n), y, tau, q, dq, ddq, np.ones((2, n), dtype=bool), h, halves)


def exact(moved, beta=BETA, noise=0.0):
    """The regression of a motion (q, dq, ddq) and of the torque it needs, with noise added to that."""
    y = regressor(*moved)
    return regression_of(y, y @ beta + noise)


def exciting(n, h=H):
    """The regression of the motion that excites all nine parameters."""
    return exact(log_example.motion(h * np.arange(n)))


def random_regressor(rng, n=60):
    """Regressor of Eq. 1 at random states: it excites all nine parameters."""
    return regressor(*(size * rng.normal(size=(2, n)) for size in (1.0, 2.0, 5.0)))


def noisy_problem(seed, n=100, noise=0.1, beta=BETA):
    """Random states of an arm, with normal errors of the torque; `noise` broadcasts to (2, n)."""
    rng = np.random.default_rng(seed)
    y = random_regressor(rng, n)
    return regression_of(y, y @ beta + noise * rng.normal(size=(2, n)))


def hostile(seed, n=40):
    """A regression whose best parameters are often not physical: signs of the truth are drawn."""
    rng = np.random.default_rng(seed)
    y = random_regressor(rng, n)
    noise = rng.choice([0.01, 0.1, 1.0]) * rng.normal(size=(2, n))
    return regression_of(y, y @ (BETA * rng.choice([-1.0, 1.0, 1.0], 9)) + noise)


def beta_of(name, regression):
    """Parameters that a method finds."""
    return METHODS[name].estimate(regression).beta


def slope(regression, beta):
    """Half the gradient of the cost, with columns of unit length and over the length of the torque."""
    gradient = np.einsum("jnp,jn->p", regression.y, regression.y @ beta - regression.tau)
    return gradient / np.linalg.norm(regression.y, axis=(0, 1)) / np.linalg.norm(regression.tau)


def other_motion(t):
    """Two sinusoids a joint, faster and around another place than those of `log_example.motion`."""
    frequency = 2 * np.pi * np.array([[0.4, 0.9], [0.3, 1.0]])[..., np.newaxis]
    amplitude = np.array([[0.5, -0.25], [0.6, 0.3]])[..., np.newaxis]
    phase = frequency * t + np.array([[0.1, 2.0], [1.4, 0.6]])[..., np.newaxis]
    q = np.array([[0.3], [-0.4]]) + (amplitude * np.sin(phase)).sum(1)
    return q, (amplitude * frequency * np.cos(phase)).sum(1), (-amplitude * frequency**2 * np.sin(phase)).sum(1)


def autoregressive(rho, n, rng, size=1.0):
    """Both joints' noise e[k] = rho e[k-1] + white, of standard deviation `size` from the first sample on."""
    white = np.sqrt(1.0 - rho**2) * rng.normal(size=(2, n))
    white[:, 0] /= np.sqrt(1.0 - rho**2)
    return size * lfilter([1.0], [1.0, -rho], white, axis=-1)
