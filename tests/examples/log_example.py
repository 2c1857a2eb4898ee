"""A recording of a known arm, and ways to write it to a file."""

from dataclasses import dataclass

import numpy as np

from repro.identification.log import Log
from repro.model.dynamics import inverse_dynamics

#: Parameters of the arm, about those of a small geared one: I1, I2, I3, g1, g2, b1, b2, k1, k2.
BETA = np.array([0.125, 0.068, 0.025, 3.3, 1.1, 0.07, 0.04, 0.2, 0.15])
RATE, SECONDS = 200.0, 12.0


@dataclass(frozen=True)
class Recording:
    t: np.ndarray
    q: np.ndarray
    dq: np.ndarray
    tau: np.ndarray


def motion(t):
    """Position, velocity and acceleration of both joints: three sinusoids each, at rest at neither end."""
    frequency = 2 * np.pi * np.array([[0.25, 0.6, 1.1], [0.35, 0.75, 1.3]])[..., np.newaxis]
    amplitude = np.array([[0.7, 0.35, 0.12], [0.8, -0.4, 0.15]])[..., np.newaxis]
    phase = frequency * t + np.array([[0.3, 1.1, 2.0], [0.9, 0.2, 1.5]])[..., np.newaxis]
    q = (amplitude * np.sin(phase)).sum(1)
    dq = (amplitude * frequency * np.cos(phase)).sum(1)
    ddq = (-amplitude * frequency**2 * np.sin(phase)).sum(1)
    return q, dq, ddq


def recording(t=None, beta=BETA):
    t = np.arange(round(SECONDS * RATE)) / RATE if t is None else t
    q, dq, ddq = motion(t)
    return Recording(t, q, dq, inverse_dynamics(q, dq, ddq, beta))


def columns(r):
    names = ("time", "q1", "q2", "dq1", "dq2", "tau1", "tau2")
    return dict(zip(names, (r.t, *r.q, *r.dq, *r.tau), strict=True))


def text(table, digits=9):
    """CSV text of a mapping from header to numbers or cells."""
    cells = [[x if isinstance(x, str) else f"{x:.{digits}g}" for x in values] for values in table.values()]
    return "\n".join([",".join(table), *map(",".join, zip(*cells, strict=True))]) + "\n"


def write(folder, content):
    """A log file of a table, text or bytes."""
    path, content = folder / "log.csv", text(content) if isinstance(content, dict) else content
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def log_of(r, **changes):
    return Log(name="log.csv", t=r.t, q=r.q, tau=r.tau, dq=r.dq, **changes)


def assert_same(log, r, q=1e-12, tau=1e-12, dq=1e-12):
    """A log holds these signals, within these tolerances."""
    np.testing.assert_allclose(log.t, r.t - r.t[0], atol=1e-9)
    np.testing.assert_allclose(log.q, r.q, atol=q)
    np.testing.assert_allclose(log.tau, r.tau, atol=tau)
    if log.dq is not None:
        np.testing.assert_allclose(log.dq, r.dq, atol=dq)
