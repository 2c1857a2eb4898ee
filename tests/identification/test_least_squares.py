"""Each method of least squares against an independent solver, its conditions of optimality, or Monte Carlo."""

import numpy as np
import pytest
from hypothesis import given, settings
from log_example import BETA
from regression_example import beta_of, exact, hostile, noisy_problem, random_regressor, regression_of, sinusoids
from scipy.optimize import least_squares
from strategies import seeds

from repro.identification.least_squares import METHODS, choose_penalty, solve_consistent, solve_inequality
from repro.identification.method import Estimate
from repro.identification.regression import reduced_problem, solve
from repro.model.dynamics import mass_matrix
from repro.model.parameters import is_positive_definite

pytestmark = pytest.mark.slow


@given(seeds)
@settings(max_examples=30)
def test_robust_minimises_huber_s_loss(seed):
    """SciPy's minimiser of the same loss, at the scales that the estimate leaves: medians of the errors' sizes."""
    rng = np.random.default_rng(seed)
    y = random_regressor(rng, int(rng.integers(30, 200)))
    noise = np.array([[0.1], [0.3]]) * rng.choice([0.1, 1.0, 10.0]) * rng.standard_t(3, size=y.shape[:2])
    tau = y @ BETA + noise
    beta = beta_of("robust", regression_of(y, tau))
    scale = np.median(np.abs(tau - y @ beta), axis=1, keepdims=True) / 0.6744897501960817
    rows = -(y / scale[..., np.newaxis]).reshape(-1, 9)
    found = least_squares(
        lambda b: ((tau - y @ b) / scale).reshape(-1), solve(y, tau), jac=lambda _: rows, loss="huber", f_scale=1.345,
        xtol=1e-14, ftol=1e-14, gtol=1e-12, x_scale="jac",
    )  # fmt: skip
    standard_error = np.sqrt(np.diag(np.linalg.inv(rows.T @ rows)))
    assert (np.abs(found.x - beta) / standard_error).max() < 0.01


def test_noise_in_the_regressor_attenuates_ordinary_and_not_instrumental():
    """Two regressors with noise of their own, 0.7 of each column's size; truth counts alike in every column."""
    ordinary, instrumental = [], []
    for seed in range(200):
        rng = np.random.default_rng(seed)
        y = random_regressor(rng, 200)
        size = np.sqrt(np.mean(y**2, axis=(0, 1)))
        halves = y + 0.7 * size * rng.normal(size=(2, *y.shape)) * (y != 0.0)
        regression = regression_of(halves.mean(0), y @ (1.0 / size) + 0.02 * rng.normal(size=(2, 200)), even_odd=halves)
        ordinary.append(beta_of("ordinary", regression) * size - 1.0)
        instrumental.append(beta_of("instrumental", regression) * size - 1.0)
    biased, fair = np.mean(ordinary, 0), np.mean(instrumental, 0)
    assert (biased < -0.03).all()
    assert biased.mean() < -0.08
    assert np.abs(fair).max() < 0.03
    assert (np.abs(fair) < 4.0 * np.std(instrumental, 0) / np.sqrt(200)).all()


def test_weighted_is_generalised_least_squares_of_known_variances():
    weighted, known, ordinary = [], [], []
    size = np.array([[1.0], [0.02]])
    for seed in range(100):
        regression = noisy_problem(seed, 150, size)
        rows, whitened = (regression.y / size[..., np.newaxis]).reshape(-1, 9), (regression.tau / size).reshape(-1)
        known.append(np.linalg.lstsq(rows, whitened)[0] - BETA)
        weighted.append(beta_of("weighted", regression) - BETA)
        ordinary.append(beta_of("ordinary", regression) - BETA)
    spread = np.std(known, 0)
    assert (np.std(np.array(weighted) - known, 0) < 0.02 * spread).all()
    assert (np.abs(np.mean(weighted, 0)) < 4.0 * spread / np.sqrt(100)).all()
    # Parameters that the accurate joint shows gain; those of joint 1 alone cannot.
    gain = np.std(ordinary, 0) / np.std(weighted, 0)
    assert (gain[[1, 2, 4, 6, 8]] > 2.0).all()
    assert (gain > 0.9).all()


def pseudo_inertia(beta):
    """[[I1 - I3, I2/2], [I2/2, I3]]: positive definite exactly if M(q) is in every pose."""
    return np.array([[beta[0] - beta[2], 0.5 * beta[1]], [0.5 * beta[1], beta[2]]])


def is_consistent(beta):
    """Friction is not negative, the inertia matrix positive definite in every pose, I2 g1 g2 >= 0."""
    poses = np.stack([np.zeros(91), np.linspace(0.0, np.pi, 91)], axis=-1)
    return (
        (beta[5:] >= 0.0).all()
        and beta[1] * beta[3] * beta[4] >= 0.0
        and np.linalg.eigvalsh(mass_matrix(poses, beta)).min() > 0.0
    )


@pytest.mark.parametrize("seed", range(8))
def test_parsimonious_is_consistent_whatever_its_penalty(seed):
    assert is_consistent(METHODS["parsimonious"].repeat(hostile(seed), Estimate(BETA, (), 0.3)))


@given(seeds)
@settings(max_examples=50)
def test_consistent_is_so_and_meets_the_conditions_of_optimality(seed):
    """Multipliers of a convex programme: a positive semidefinite matrix S for the inertia, numbers for friction."""
    regression = hostile(seed)
    beta = beta_of("consistent", regression)
    assert is_consistent(beta)
    length, size = np.linalg.norm(regression.y, axis=(0, 1)), np.linalg.norm(regression.tau)
    gradient = np.einsum("jnp,jn->p", regression.y, regression.y @ beta - regression.tau)
    unit = gradient / length / size
    assert (np.abs(unit[3:5][beta[3:5] != 0.0]) < 1e-5).all()
    assert (unit[5:] > -1e-5).all()
    assert (np.abs(gradient[5:] * beta[5:]) < 1e-5 * size**2).all()
    if beta[1] == 0.0:
        return  # at the edge of both signs: see below
    # d cost = S11 d(I1 - I3) + S12 d(I2) + S22 d(I3).
    s = np.array([[gradient[0], gradient[1]], [gradient[1], gradient[0] + gradient[2]]])
    x = pseudo_inertia(beta)
    assert np.linalg.eigvalsh(s).min() > -1e-5 * size * length[:3].max()
    margin = np.linalg.eigvalsh(x).min()
    assert margin > 1e-6 * np.trace(x)
    assert abs(np.sum(s * (x - margin * np.eye(2)))) < 1e-5 * size**2


@pytest.mark.parametrize("low", [0, 1])
def test_an_eigenvalue_of_half_the_margin_is_lifted_to_it(low):
    """Inertia [[I1 - I3, 0], [0, I3]], one of them 0.7 kg m^2; the margin is a thousandth of I1 + I3."""
    values = np.where([low == 0, low == 1], 3.5e-4, 0.7)
    beta = np.array([values.sum(), 0.0, values[1], 1.0, 2.0, 0.1, 0.1, 0.1, 0.1])
    found, binding = solve_consistent(np.eye(9), beta, np.ones(9), np.zeros(9))
    assert binding
    assert 0.999 < np.linalg.eigvalsh(pseudo_inertia(found)).min() / (1e-3 * (beta[0] + beta[2])) < 1.2


def from_factor(x, margin):
    """Parameters with inertia L L' + margin, which cannot leave the set."""
    low = np.array([[x[0], 0.0], [x[1], x[2]]])
    inertia = low @ low.T + margin * np.eye(2)
    return np.array([np.trace(inertia), 2.0 * inertia[0, 1], inertia[1, 1], *x[3:]])


def minimum(r, c, scale, margin, low, high):
    """SciPy's minimum over factors: bounds on them are enough."""
    start = np.clip([0.3, 0.0, 0.3, 0.0, 0.0, 0.1, 0.1, 0.1, 0.1], low, high)
    return least_squares(
        lambda x: r @ (scale * from_factor(x, margin)) - c, start, bounds=(low, high),
        xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=300,
    )  # fmt: skip


@pytest.mark.parametrize("seed", [2, 3, 8, 19, 26, 48])
def test_of_the_possible_signs_those_with_the_smallest_error_are_taken(seed):
    """The sign of I2 is that of L's second row where its first is positive."""
    regression = hostile(seed)
    r, c, scale = reduced_problem(regression)
    beta = beta_of("consistent", regression)
    margin = min(1e-4, 0.999 * np.linalg.eigvalsh(pseudo_inertia(beta)).min())
    low, high = np.array([0.0] + [-np.inf] * 4 + [0.0] * 4), np.full(9, np.inf)
    best = np.inf
    for negative in ((), (1, 3), (1, 4), (3, 4)):
        own = low.copy(), high.copy()
        for k in (1, 3, 4):
            own[k in negative][k] = 0.0
        best = min(best, minimum(r, c, scale, margin, *own).cost)
    assert np.linalg.norm(r @ (scale * beta) - c) ** 2 == pytest.approx(2.0 * best, rel=1e-3, abs=1e-5 * (c @ c))


@pytest.mark.parametrize("seed", [1, 4, 11])
def test_weighted_consistent_is_consistent_least_squares_of_weighted_rows(seed):
    regression = hostile(seed)
    y, tau = regression.y, regression.tau
    size = np.ones((2, 1))
    for _ in range(30):
        rows, right = (y / size[..., None]).reshape(-1, 9), (tau / size).reshape(-1)
        size = np.sqrt(np.mean((tau - y @ np.linalg.lstsq(rows, right, rcond=None)[0]) ** 2, axis=1, keepdims=True))
    expected = beta_of("consistent", regression_of(y / size[..., None], tau / size))
    found = beta_of("weighted-consistent", regression)
    assert is_consistent(found) and not is_consistent(beta_of("weighted", regression))
    np.testing.assert_allclose(found, expected, rtol=0.02, atol=2e-3 * np.abs(expected).max())


@pytest.mark.parametrize("seed", [0, 3, 10, 15, 37, 39])
def test_consistent_is_the_minimum_over_factors_of_the_inertia(seed):
    regression = hostile(seed)
    r, c, scale = reduced_problem(regression)
    margin = 1e-4

    least = minimum(r, c, scale, margin, np.array([-np.inf] * 5 + [0.0] * 4), np.full(9, np.inf))
    expected, found = from_factor(least.x, margin), solve_inequality(r, c, scale, margin, np.zeros(9))
    assert np.linalg.eigvalsh(pseudo_inertia(found)).min() > 0.99 * margin
    assert np.linalg.norm(r @ (scale * found) - c) ** 2 < 2.0 * least.cost + 1e-7 * (c @ c)
    np.testing.assert_allclose(scale * found, scale * expected, rtol=0, atol=1e-4 * np.linalg.norm(c))


def sines(seed, pace, viscous, noise):
    """Sines of 0.1 to 0.5 Hz played at a pace, an arm with this viscous friction."""
    rng = np.random.default_rng(seed)
    frequency, amplitude = pace * rng.uniform(0.1, 0.5, (2, 3)), rng.uniform(0.2, 0.5, (2, 3))
    moved = sinusoids(0.05 * np.arange(400), amplitude, frequency, rng.uniform(0, 2 * np.pi, (2, 3)))
    return exact(moved, np.r_[BETA[:5], viscous, viscous, BETA[7:]], noise * rng.normal(size=(2, 400)))


@pytest.mark.parametrize("seed", range(4))
def test_a_penalty_adds_the_energy_of_the_viscous_torque(seed):
    """Where no condition holds, b minimises |Y beta - tau|^2 + rho (|y_b1 b1|^2 + |y_b2 b2|^2) of weighted rows."""
    regression, flat = sines(seed, 2.5, 0.2, 0.02), np.zeros((2, 9))
    error = regression.tau - regression.y @ beta_of("weighted", regression)
    weight = 1.0 / np.sqrt(np.mean(error**2, axis=1, keepdims=True))
    rows, torque = (regression.y * weight[..., None]).reshape(-1, 9), (regression.tau * weight).reshape(-1)
    for penalty in (0.03, 0.3, 3.0):
        flat[0, 5], flat[1, 6] = np.sqrt(penalty) * np.linalg.norm(rows[:, 5:7], axis=0)
        expected, *_ = np.linalg.lstsq(np.vstack([rows, flat]), np.concatenate([torque, np.zeros(2)]))
        assert is_positive_definite(expected)
        found = METHODS["parsimonious"].repeat(regression, Estimate(BETA, (), penalty))
        np.testing.assert_allclose(found, expected, rtol=1e-6)


def test_viscous_friction_that_a_slow_motion_cannot_show_is_dropped():
    """Truth has none; Coulomb friction of 0.2 and 0.15 N m explains it all."""
    dropped, unshrunk = [], []
    for seed in range(6):
        regression = sines(seed, 0.4, 0.0, 0.02)
        dropped.append(beta_of("parsimonious", regression)[5:7])
        unshrunk.append(beta_of("consistent", regression)[5:7])
    assert np.mean(dropped) < 0.3 * np.mean(unshrunk)
    assert np.median(dropped) < 1e-3


@pytest.mark.parametrize(
    ("errors", "row"),
    [
        # Equal in every block: the strongest.
        ([[1.0, 2.0, 3.0]] * 4, 3),
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
        # Mean 0.07 within 0.12 / sqrt(2), the number of blocks, and not within 0.12 / sqrt(4), that of penalties.
        ([[1.0, 1.0], [0.985, 1.155], [3.0, 3.0], [3.0, 3.0]], 1),
    ],
)
def test_the_strongest_penalty_within_one_standard_error_is_chosen(errors, row):
    assert choose_penalty(np.array(errors)) == row
