"""The identification trajectory (Eq. 10, Fig. 6) and the random validation trajectory (Fig. 16)."""

from dataclasses import dataclass

import numpy as np

from repro.model.parameters import Array
from repro.signals.dct import FrequencyReading, dct2dev, dct2low


@dataclass(frozen=True)
class Harmonic:
    """One sinusoid of Eq. 10."""

    amplitude: float  # rad
    frequency: float  # rad/s
    phase: float  # rad


#: Second harmonics of Eq. 10: a cosine for joint 1, a sine for joint 2.
SECOND_HARMONIC = (Harmonic(0.1, 2.5, 3.0), Harmonic(-0.1, 2.5, 3.0))
#: Range of the random numbers of Section V-B, rad.
RANDOM_RANGE = (0.0, 1.0)


@dataclass(frozen=True)
class Motion:
    """A sampled motion of both joints.

    Attributes
    ----------
    time : array of shape (N,)
        s.
    q, dq, ddq : arrays of shape (2, N)
        Position (rad), velocity (rad/s), acceleration (rad/s^2).
    """

    time: Array
    q: Array
    dq: Array
    ddq: Array


def sample_times(duration: float, h: float) -> Array:
    """Sampling instants 0, h, 2h, ... covering `duration`.

    Parameters
    ----------
    duration : float
        s.
    h : float
        Sampling period, s.

    Returns
    -------
    array of shape (N,)
        N = duration / h, rounded to the nearest integer (3770 for 3 pi s at 2.5 ms).

    Raises
    ------
    ValueError
        If an argument is not positive and finite, or fewer than two samples fit.
    """
    if not 0 < h < np.inf:
        raise ValueError(f"h: the sampling period must be positive and finite, got {h}.")
    if not np.isfinite(duration):
        raise ValueError(f"duration: must be finite, got {duration}.")
    n = round(duration / h)
    if n < 2:
        raise ValueError(f"duration: {duration} s holds fewer than two samples of {h} s.")
    return np.arange(n, dtype=np.float64) * h


def identification_trajectory(duration: float = 3.0 * np.pi, h: float = 2.5e-3, margin: int = 0) -> Motion:
    """Trajectory of Eq. 10 with its exact derivatives.

    Played slower or faster it keeps its shape: over `duration` the phase runs from 0 to 3 pi.

    Parameters
    ----------
    duration : float
        s; 3 pi as published.
    h : float
        Sampling period, s.
    margin : int
        Samples added before the start and after the end, which **cut** of Algorithm 1 removes again
        together with the filter's edges.

    Returns
    -------
    Motion
        N = duration / h + 2 margin samples; time is 0 where the trajectory proper starts.

    Raises
    ------
    ValueError
        If `margin` is negative or fewer than two samples fit.
    """
    if margin < 0:
        raise ValueError(f"margin: must not be negative, got {margin}.")
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


def random_trajectory(
    rng: np.random.Generator,
    duration: float,
    h: float,
    c_f: float,
    reading: FrequencyReading,
    low: float = RANDOM_RANGE[0],
    high: float = RANDOM_RANGE[1],
) -> Motion:
    """Uniform random positions filtered with Eq. 14 (Section V-B).

    Derivatives are taken by Eq. 6 without further filtering: the position is band-limited already.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of the random vector.
    duration, h : float
        Length and sampling period, s.
    c_f : float
        Coefficient of Eq. 14.
    reading : {"rad_per_s", "hertz", "index"}
        Unit of omega in Eq. 14.
    low, high : float
        Range of the random numbers, rad.

    Returns
    -------
    Motion
        N = duration / h samples.

    Raises
    ------
    ValueError
        If a range, a length or a filter setting is not valid.
    """
    if not -np.inf < low < high < np.inf:
        raise ValueError(f"high: must be finite and above the finite low, got {low} to {high}.")
    t = sample_times(duration, h)
    q = dct2low(rng.uniform(low, high, (2, t.size)), h, c_f, reading)
    dq = dct2dev(q, h, 0.0)
    return Motion(t, q, dq, dct2dev(dq, h, 0.0))
