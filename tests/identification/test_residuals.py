"""Whiteness of residuals."""

from dataclasses import replace

import numpy as np
import pytest
from log_example import BETA
from ownarm_log import CUTOFF, H, exciting, regression_of

from repro.identification.residuals import lag_one


def test_whiteness_of_a_residual_made_by_hand():
    # Centred -1.5, -0.5, 0.5, 1.5: 0.75 - 0.25 + 0.75 over 5 at a lag of one; at two -0.75 - 0.75.
    tau = np.array([[1.0, 2.0, 3.0, 4.0], [1.0, -1.0, 1.0, -1.0]])
    zero = np.zeros((2, 4, 9))
    assert lag_one(regression_of(zero, tau, H), BETA, 1 / H) == pytest.approx((0.25, -0.75))
    assert lag_one(regression_of(zero, tau, H), BETA, 0.5 / H) == pytest.approx((-0.3, 0.5))
    # A lag beyond the log, a residual that is constant, and one that is zero.
    assert lag_one(regression_of(zero, tau, H), BETA, 0.1 / H) == (0.0, 0.0)
    assert lag_one(regression_of(zero, np.array([[2.0] * 4, [0.0] * 4]), H), BETA, 1 / H) == (0.0, 0.0)


def test_white_residuals_are_near_zero_and_drifting_ones_near_one():
    rng = np.random.default_rng(12)
    clean = exciting(20_000)
    noise = np.stack([rng.normal(size=20_000), np.sin(0.05 * H * np.arange(20_000))])
    white, drift = lag_one(replace(clean, tau=clean.tau + noise), BETA, CUTOFF)
    assert white == pytest.approx(0.0, abs=0.03)
    assert drift == pytest.approx(1.0, abs=0.01)


def test_the_lag_is_a_period_of_the_cutoff():
    n = 5000
    t = H * np.arange(n)
    at_cutoff, at_half = np.sin(2 * np.pi * CUTOFF * t), np.sin(np.pi * CUTOFF * t)
    found = lag_one(regression_of(np.zeros((2, n, 9)), np.stack([at_cutoff, at_half])), BETA, CUTOFF)
    assert found == pytest.approx((1.0, -1.0), abs=0.01)
