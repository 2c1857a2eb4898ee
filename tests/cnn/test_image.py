"""The signal image of Eq. 9 against outer products written out, and its colours (Eq. 16)."""

from typing import get_args

import literal
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import seeds

from repro.cnn.image import ImageSettings, Scale, assemble, colours, image_factors, images
from repro.model.dynamics import inverse_dynamics

SCALES = get_args(Scale)


def signals(seed):
    """A torque and a psi of different levels in the two channels, positive and negative."""
    first, second = np.random.default_rng(seed).normal(size=(2, 2, 17))
    alpha, psi = first * [[1.0], [0.3]] + [[0.2], [-0.1]], second * [[0.5], [2.0]] + [[-0.4], [0.3]]
    return alpha / np.abs(alpha).max(), psi


def build(alpha, psi, scale):
    return assemble(*image_factors(alpha, psi, ImageSettings(scale)))


@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float64, 1e-12), (np.float32, 1e-5)])
@given(seeds, st.sampled_from(SCALES), st.floats(0.1, 10.0))
def test_factors_assemble_to_equation_9_in_the_precision_of_the_signals(dtype, tolerance, seed, scale, constant):
    alpha, psi = signals(seed)
    u, v = image_factors(alpha.astype(dtype), psi.astype(dtype), ImageSettings(scale, constant))
    assert u.dtype == v.dtype == dtype
    np.testing.assert_allclose(assemble(u, v), literal.image(alpha, psi, scale, constant), rtol=0, atol=tolerance)


def test_images_of_a_motion_are_those_of_its_torque_over_the_largest_magnitude():
    q, dq, ddq, torque = np.random.default_rng(5).normal(size=(4, 2, 17))
    tau, guess = np.where(torque > 0.0, torque, 3.0 * torque), np.linspace(0.1, 0.9, 9)
    alpha = tau / np.abs(tau).max()
    expected = literal.image(alpha, 2.0 * alpha - inverse_dynamics(q, dq, ddq, guess), "shared-max", 4.0)
    np.testing.assert_allclose(images(q, dq, ddq, tau, guess), expected, atol=1e-12)


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("level", [0.0, -0.7, 1e-300, 3.0])
@pytest.mark.parametrize(("in_alpha", "in_psi"), [([0, 1], []), ([], [0, 1]), ([0, 1], [0, 1]), ([1], [1])])
def test_constant_signals_give_a_finite_image(scale, level, in_alpha, in_psi):
    alpha, psi = signals(1)
    alpha[in_alpha] = psi[in_psi] = level
    found = build(alpha, psi, scale)
    assert found.shape == (2, 17, 17)
    assert np.isfinite(found).all()


def test_colours_worked_by_hand():
    z1 = np.array([[0.3, 1.0], [-0.3, 0.0]])
    z2 = np.array([[0.6, 1.0], [0.6, -1.0]])
    red = [[0.2 + 0.14, 0.9], [0.0, 0.0]]  # -0.2 + 0.14 and -0.7 / 3 are below the range
    green = [[0.2, 2 / 3], [0.0, 0.0]]
    blue = [[0.8, 1.0], [0.4, 0.0]]  # 2 / 3 + 1 is above it
    found = colours(np.stack([np.stack([z1, z2])] * 3))
    np.testing.assert_allclose(found, [np.stack([red, green, blue], -1)] * 3, atol=1e-15, strict=True)
