"""The identification trajectory (Eq. 10, Fig. 6), random trajectories (Fig. 16) and quintic moves."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from repro.model.parameters import Array
from repro.signals.dct import FrequencyUnit, dct2dev, dct2low


class Harmonic(NamedTuple):
    """One sinusoid of Eq. 10."""

    amplitude: float  # rad
    frequency: float  # rad/s
    phase: float  # rad


#: Second harmonics of Eq. 10: a cosine for joint 1, a sine for joint 2.
SECOND_HARMONIC = (Harmonic(0.1, 2.5, 3.0), Harmonic(-0.1, 2.5, 3.0))
RANDOM_RANGE = (0.0, 1.0)  # range of the random numbers of Section V-B, rad


@dataclass(frozen=True)
class Motion:
    """A sampled motion of both joints."""

    time: Array  # (N,), s
    q: Array  # position (2, N), rad
    dq: Array  # velocity (2, N), rad/s
    ddq: Array  # acceleration (2, N), rad/s^2


def sample_times(duration: float, h: float) -> Array:
    """Compute the sampling instants (N,) 0, h, 2h, ..., with N = duration / h to the nearest integer; all in s."""
    return np.arange(round(duration / h), dtype=np.float64) * h


def identification_trajectory(duration: float = 3.0 * np.pi, h: float = 2.5e-3, margin: int = 0) -> Motion:
    """Compute the trajectory of Eq. 10 with its exact derivatives: duration / h + 2 margin samples.

    Over `duration` (s) the phase runs from 0 to 3 pi. **cut** of Algorithm 1 removes the margins again.
    """
    n = sample_times(duration, h).size
    t = h * np.arange(-margin, n + margin, dtype=np.float64)
    rate = 3.0 * np.pi / duration  # phase per second
    p = rate * t
    (a, b), (v, w) = SECOND_HARMONIC, (s.amplitude * s.frequency for s in SECOND_HARMONIC)
    x, y = (s.frequency * p + s.phase for s in SECOND_HARMONIC)
    q = np.stack([np.sin(p) + a.amplitude * np.cos(x), -np.cos(p) + b.amplitude * np.sin(y)])
    dq = np.stack([np.cos(p) - v * np.sin(x), np.sin(p) + w * np.cos(y)])
    ddq = np.stack([-np.sin(p) - v * a.frequency * np.cos(x), np.cos(p) - w * b.frequency * np.sin(y)])
    return Motion(t, q, rate * dq, rate**2 * ddq)


def sampled_motion(q: Array, h: float) -> Motion:
    """Add times and derivatives, by Eq. 6 unfiltered, to positions (2, N), rad, every `h` seconds."""
    dq = dct2dev(q, h, 0.0)
    return Motion(h * np.arange(q.shape[1], dtype=np.float64), q, dq, dct2dev(dq, h, 0.0))


def random_trajectory(rng: np.random.Generator, duration: float, h: float, c_f: float, unit: FrequencyUnit) -> Motion:
    """Filter uniform random positions with Eq. 14 (Section V-B)."""
    n = sample_times(duration, h).size
    return sampled_motion(dct2low(rng.uniform(*RANDOM_RANGE, (2, n)), h, c_f, unit), h)


def _upper_coefficients(missing: Array) -> Array:
    """Solve ``a c = missing`` (3, J) by elimination: the last bits of a library's solver depend on the processor."""
    # Rows: second and first derivative, and value, of s^3, s^4, s^5 at s = 1. In this order nothing needs pivoting.
    a, c = np.array([[6.0, 12.0, 20.0], [3.0, 4.0, 5.0], [1.0, 1.0, 1.0]]), missing.copy()
    for k in range(3):
        factor = a[k + 1 :, k, None] / a[k, k]
        a[k + 1 :] -= factor * a[k]
        c[k + 1 :] -= factor * c[k]
    for k in (2, 1, 0):
        c[k] *= 1.0 / a[k, k]
        c[:k] -= a[:k, k, None] * c[k]
    return c


def quintic(t: Array, duration: float, start: Array, end: Array) -> Array:
    """Evaluate the quintic (J, N) from a state (3, J) at time 0 to one at `duration`: rad, rad/s, rad/s^2."""
    # In s = t / duration a velocity is scaled by the duration, an acceleration by its square.
    (p0, v0, a0), goal = np.stack([start, end]) * (duration ** np.arange(3))[:, None]
    low = np.stack([p0, v0, 0.5 * a0])
    at_end = np.stack([a0, v0 + a0, low.sum(0)])
    coefficients = np.concatenate([low, _upper_coefficients(goal[::-1] - at_end)])  # (6, J), ascending
    return np.asarray(np.polynomial.polynomial.polyval(np.asarray(t) / duration, coefficients))
