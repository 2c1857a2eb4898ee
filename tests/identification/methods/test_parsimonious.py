"""Parsimonious least squares: what it shrinks, what it keeps, and how strongly it chooses to."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from log_example import BETA
from regression_example import problem, random_regressor
from strategies import seeds

from repro.identification.methods import parsimonious
from repro.identification.methods.consistent import consistent
from repro.identification.methods.every import METHODS
from repro.identification.methods.interface import Estimate
from repro.identification.solve import nine_rows
from repro.model.dynamics import regressor
from repro.model.parameters import is_positive_definite


def beta_of(name, regression):
    return METHODS[name].estimate(regression).beta


def hostile(seed, n=40):
    """A regression whose best parameters are often not physical: signs of the truth are drawn."""
    rng = np.random.default_rng(seed)
    y = random_regressor(rng, n)
    noise = rng.choice([0.01, 0.1, 1.0]) * rng.normal(size=(2, n))
    return problem(y, y @ (BETA * rng.choice([-1.0, 1.0, 1.0], 9)) + noise)


# Parsimonious.


def sines(seed, pace, viscous, noise, n=400):
    """Sines of 0.1 to 0.5 Hz played at a pace, an arm with this viscous friction."""
    rng = np.random.default_rng(seed)
    t = 0.05 * np.arange(n)
    omega = 2 * np.pi * pace * rng.uniform(0.1, 0.5, (2, 3, 1))
    amplitude, phase = rng.uniform(0.2, 0.5, (2, 3, 1)), omega * t + rng.uniform(0, 2 * np.pi, (2, 3, 1))
    q = (amplitude * np.sin(phase)).sum(1)
    dq, ddq = (amplitude * omega * np.cos(phase)).sum(1), (-amplitude * omega**2 * np.sin(phase)).sum(1)
    y, beta = regressor(q, dq, ddq), BETA.copy()
    beta[5:7] = viscous
    return problem(y, y @ beta + noise * rng.normal(size=(2, n)))


@pytest.mark.slow
@given(seeds)
@settings(max_examples=30)
def test_without_penalty_it_is_consistent(seed):
    regression = hostile(seed)
    size = np.linalg.norm(regression.y, axis=(0, 1))
    found, expected = parsimonious.refit(regression, 0.0), beta_of("consistent", regression)
    np.testing.assert_allclose(size * found, size * expected, rtol=0, atol=1e-6 * np.linalg.norm(regression.tau))


@pytest.mark.parametrize("seed", range(4))
def test_a_penalty_adds_the_energy_of_the_viscous_torque(seed):
    """Where no condition holds, b minimises |Y beta - tau|^2 + rho (|y_b1 b1|^2 + |y_b2 b2|^2)."""
    regression, flat = sines(seed, 2.5, 0.2, 0.02), np.zeros((2, 9))
    rows = regression.y.reshape(-1, 9)
    for penalty in (0.03, 0.3, 3.0):
        flat[0, 5], flat[1, 6] = np.sqrt(penalty) * np.linalg.norm(rows[:, 5:7], axis=0)
        right = np.concatenate([regression.tau.reshape(-1), np.zeros(2)])
        expected, *_ = np.linalg.lstsq(np.vstack([rows, flat]), right)
        assert is_positive_definite(expected)
        found = parsimonious.METHOD.repeat(regression, Estimate(BETA, (), penalty))
        np.testing.assert_allclose(found, expected, rtol=1e-6)


@pytest.mark.parametrize("seed", range(5))
def test_a_stronger_penalty_leaves_less_viscous_torque(seed):
    regression = sines(seed, 1.0, (0.1, 0.05), 0.02)
    size = np.linalg.norm(regression.y[..., 5:7], axis=(0, 1))
    left = [np.linalg.norm(size * parsimonious.refit(regression, penalty)[5:7]) for penalty in parsimonious.PENALTIES]
    assert all(more > less for more, less in pairwise(left))


@pytest.mark.parametrize("seed", range(5))
def test_viscous_friction_that_shows_is_kept(seed):
    found = beta_of("parsimonious", sines(seed, 2.5, (0.3, 0.2), 0.05))
    np.testing.assert_allclose(found[5:7], (0.3, 0.2), rtol=0.1)


@pytest.mark.slow
def test_viscous_friction_that_a_slow_motion_cannot_show_is_dropped():
    """Truth has none; Coulomb friction of 0.2 and 0.15 N m explains it all."""
    dropped, unshrunk = [], []
    for seed in range(6):
        regression = sines(seed, 0.4, 0.0, 0.02)
        dropped.append(beta_of("parsimonious", regression)[5:7])
        unshrunk.append(beta_of("consistent", regression)[5:7])
        assert is_positive_definite(beta_of("parsimonious", regression))
    assert np.mean(dropped) < 0.3 * np.mean(unshrunk)
    assert np.median(dropped) < 1e-3


@pytest.mark.parametrize(
    ("errors", "row"),
    [
        # Equal in every block: the strongest.
        ([[1.0, 2.0, 3.0]] * 4, 3),
        # Worse by the same in every block: no standard error forgives it.
        ([[1.0, 2.0, 3.0], [1.1, 2.1, 3.1]], 0),
        # Better by the same in every block.
        ([[1.1, 2.1, 3.1], [1.0, 2.0, 3.0]], 1),
        # Worse by 0.1 on average, differences -0.2, 0.1, 0.4: standard error 0.3 / sqrt(3) = 0.173 allows it.
        ([[1.0, 1.0, 1.0], [0.8, 1.1, 1.4]], 1),
        # Worse by 0.2 on average, differences 0.1, 0.2, 0.3: standard error 0.0577 does not.
        ([[1.0, 1.0, 1.0], [1.1, 1.2, 1.3]], 0),
        # Mean 0.2 within the standard deviation of the differences, 0.25, but not within its error, 0.144.
        ([[1.0, 1.0, 1.0], [0.95, 1.2, 1.45]], 0),
        # Mean 0.13 within 0.144, which takes the deviation of a sample: of the whole it would be 0.118.
        ([[1.0, 1.0, 1.0], [0.88, 1.13, 1.38]], 1),
        # Differences count, not the spread of the blocks themselves, which is large.
        ([[1.0, 10.0, 100.0], [1.1, 10.2, 100.3]], 0),
        # The strongest that is allowed, though one weaker is not.
        ([[1.0, 1.0, 1.0], [1.1, 1.2, 1.3], [0.8, 1.1, 1.4]], 2),
        # The best lies between; a stronger one is too bad, a weaker one is not taken.
        ([[1.2, 1.3, 1.4], [1.0, 1.0, 1.0], [2.0, 2.1, 2.2]], 1),
    ],
)
def test_the_strongest_penalty_within_one_standard_error_is_chosen(errors, row):
    assert parsimonious.choose_penalty(np.array(errors)) == row


def test_the_choice_is_told_and_is_one_of_those_tried():
    found = METHODS["parsimonious"].estimate(sines(0, 1.0, (0.07, 0.04), 0.05))
    assert found.choice in parsimonious.PENALTIES
    assert f"penalty of {found.choice:g}," in found.notes[0]


@given(seeds)
@settings(max_examples=20)
def test_more_rows_can_be_added_to_nine(seed):
    """A row that asks for I1 = 1 with great weight is obeyed."""
    regression = hostile(seed)
    r, c, scale = nine_rows(regression.y, regression.tau)
    row = np.zeros((1, 9))
    row[0, 0] = 1e4
    beta, _ = consistent(np.vstack([r, row]), np.append(c, 1e4 * scale[0]), scale)
    assert beta[0] == pytest.approx(1.0, rel=1e-3)
