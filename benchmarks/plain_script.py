"""Least squares of a log as a plain script does it, without code of the package: ``python plain_script.py LOG``.

It reads the table with pandas, filters with Butterworth's filter, differentiates, and solves by `numpy.linalg.lstsq`.
"""

import sys

import numpy as np
import pandas as pd
from scipy.signal import butter, filtfilt

CUTOFF_HZ, STEEPNESS = 5.0, 20.0


def main(path: str) -> None:
    """Print the nine parameters."""
    log = pd.read_csv(path)
    t = log["time"].to_numpy()
    h = (t[-1] - t[0]) / (t.size - 1)
    b, a = butter(4, 2.0 * CUTOFF_HZ * h)
    (q1, q2), tau = (filtfilt(b, a, log[[f"{name}1", f"{name}2"]].to_numpy().T) for name in ("q", "tau"))
    dq1, dq2 = np.gradient(q1, h), np.gradient(q2, h)
    ddq1, ddq2 = np.gradient(dq1, h), np.gradient(dq2, h)
    c2, s2, s1, s12, no = np.cos(q2), np.sin(q2), np.sin(q1), np.sin(q1 + q2), np.zeros_like(t)
    i2 = c2 * (ddq1 + 0.5 * ddq2) - s2 * dq2 * (dq1 + 0.5 * dq2), 0.5 * (c2 * ddq1 + s2 * dq1**2)
    friction = np.tanh(STEEPNESS * dq1), np.tanh(STEEPNESS * dq2)
    first = np.stack([ddq1, i2[0], ddq2, s1, s12, dq1, no, friction[0], no], axis=1)
    second = np.stack([no, i2[1], ddq1 + ddq2, no, s12, no, dq2, no, friction[1]], axis=1)
    print(np.linalg.lstsq(np.concatenate([first, second]), tau.reshape(-1))[0])


if __name__ == "__main__":
    main(sys.argv[1])
