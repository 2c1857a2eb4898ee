"""Bounded and consistent least squares: SciPy's solvers, conditions of optimality, no better neighbour."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from log_example import BETA
from regression_example import problem, random_regressor
from scipy.optimize import least_squares, nnls
from strategies import feasible_betas, seeds

from repro.identification.methods.consistent import MARGIN, solve_consistent
from repro.identification.methods.every import METHODS
from repro.identification.solve import nine_rows
from repro.model.dynamics import mass_matrix, regressor
from repro.model.parameters import NAMES, is_positive_definite

pytestmark = pytest.mark.slow


def beta_of(name, regression):
    return METHODS[name].estimate(regression).beta


def hostile(seed, n=40):
    """A regression whose best parameters are often not physical: signs of the truth are drawn."""
    rng = np.random.default_rng(seed)
    y = random_regressor(rng, n)
    noise = rng.choice([0.01, 0.1, 1.0]) * rng.normal(size=(2, n))
    return problem(y, y @ (BETA * rng.choice([-1.0, 1.0, 1.0], 9)) + noise)


# Bounded.


@given(seeds)
def test_bounded_meets_the_conditions_of_optimality(seed):
    regression = hostile(seed)
    beta = beta_of("bounded", regression)
    slope = np.einsum("jnp,jn->p", regression.y, regression.y @ beta - regression.tau)
    size = np.linalg.norm(regression.y, axis=(0, 1)) * np.linalg.norm(regression.tau)
    # What rounding leaves of a parameter that is held at zero is not free.
    free = beta * np.linalg.norm(regression.y, axis=(0, 1)) > 1e-12 * np.linalg.norm(regression.tau)
    assert (beta >= 0.0).all()
    assert (np.abs(slope[free]) < 1e-8 * size[free]).all()
    assert (slope[~free] > -1e-8 * size[~free]).all()


@given(seeds)
def test_bounded_is_scipy_s_nonnegative_solution(seed):
    regression = hostile(seed)
    expected, _ = nnls(regression.y.reshape(-1, 9), regression.tau.reshape(-1))
    found = METHODS["bounded"].estimate(regression)
    np.testing.assert_allclose(found.beta, expected, rtol=1e-6, atol=1e-9)
    held = {name for name, value in zip(NAMES, expected, strict=True) if value == 0.0}
    told = {name for note in found.notes for name in note.removeprefix("held at zero: ").split(", ")}
    assert told <= held


@given(seeds, st.sampled_from([0, 1]), st.floats(0.1, 1.4), st.booleans())
def test_bounded_on_a_joint_at_rest_is_scipy_s_nonnegative_solution(seed, joint, at, hostile_signs):
    rng = np.random.default_rng(seed)
    q, dq, ddq = (size * rng.normal(size=(2, 60)) for size in (1.0, 2.0, 5.0))
    q[joint], dq[joint], ddq[joint] = at, 0.0, 0.0
    y = regressor(q, dq, ddq)
    truth = BETA * rng.choice([-1.0, 1.0, 1.0], 9) if hostile_signs else BETA
    regression = problem(y, y @ truth + 0.05 * rng.normal(size=(2, 60)))
    expected, _ = nnls(y.reshape(-1, 9), regression.tau.reshape(-1))
    found = beta_of("bounded", regression)
    assert cost(regression, found) <= (1.0 + 1e-9) * cost(regression, expected)
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-8)
    assert (found[~y.any(axis=(0, 1))] == 0.0).all()


@given(seeds)
def test_a_bound_that_holds_nothing_changes_nothing(seed):
    rng = np.random.default_rng(seed)
    y = random_regressor(rng)
    regression = problem(y, y @ BETA + 1e-3 * rng.normal(size=(2, 60)))
    ordinary = beta_of("ordinary", regression)
    assume((ordinary > 0.0).all())
    np.testing.assert_allclose(beta_of("bounded", regression), ordinary, rtol=1e-8)


# Consistent.


def pseudo_inertia(beta):
    """[[I1 - I3, I2/2], [I2/2, I3]]: positive definite exactly if M(q) is in every pose."""
    return np.array([[beta[0] - beta[2], 0.5 * beta[1]], [0.5 * beta[1], beta[2]]])


def cost(regression, beta):
    return np.sum((regression.y @ beta - regression.tau) ** 2)


@given(feasible_betas(), st.booleans())
def test_the_matrix_of_the_inequality_is_that_of_every_pose(beta, spoil):
    if spoil:
        beta[0] = 0.5 * beta[2]
    poses = np.stack([np.zeros(181), np.linspace(0.0, np.pi, 181)], axis=-1)
    definite = np.linalg.eigvalsh(mass_matrix(poses, beta)).min() > 0.0
    assert definite == (np.linalg.eigvalsh(pseudo_inertia(beta)).min() > 0.0)


@pytest.mark.parametrize(
    ("name", "seed"), [("consistent", seed) for seed in range(20)] + [("parsimonious", seed) for seed in range(4)]
)
def test_what_claims_to_be_consistent_is(name, seed):
    beta = beta_of(name, hostile(seed))
    assert is_positive_definite(beta)
    assert (beta[5:] >= 0.0).all()
    poses = np.stack([np.zeros(91), np.linspace(0.0, np.pi, 91)], axis=-1)
    assert np.linalg.eigvalsh(mass_matrix(poses, beta)).min() > 0.0


@given(seeds)
@settings(max_examples=50)
def test_consistent_meets_the_conditions_of_optimality(seed):
    """Multipliers of a convex programme: a positive semidefinite matrix S for the inertia, numbers for friction."""
    regression = hostile(seed)
    beta = beta_of("consistent", regression)
    unit = 1.0 / np.linalg.norm(regression.y, axis=(0, 1))
    size = np.linalg.norm(regression.tau)
    slope = np.einsum("jnp,jn->p", regression.y, regression.y @ beta - regression.tau)
    assert (np.abs(slope[3:5] * unit[3:5]) < 1e-5 * size).all()
    assert (slope[5:] * unit[5:] > -1e-5 * size).all()
    assert (np.abs(slope[5:] * beta[5:]) < 1e-5 * size**2).all()
    # d cost = S11 d(I1 - I3) + S12 d(I2) + S22 d(I3).
    s = np.array([[slope[0], slope[1]], [slope[1], slope[0] + slope[2]]])
    x = pseudo_inertia(beta)
    assert np.linalg.eigvalsh(s).min() > -1e-5 * size / unit[:3].min()
    beyond = x - np.linalg.eigvalsh(x).min() * np.eye(2)
    assert abs(np.sum(s * beyond)) < 1e-5 * size**2


@pytest.mark.parametrize("seed", [0, 3, 10, 15, 37, 39])
def test_consistent_is_the_minimum_over_factors_of_the_inertia(seed):
    """Independent: inertia = L L' + margin cannot leave the set, so SciPy needs bounds on friction alone."""
    regression = hostile(seed)
    r, c, scale = nine_rows(regression.y, regression.tau)
    margin = 1e-4

    def from_factor(x):
        low = np.array([[x[0], 0.0], [x[1], x[2]]])
        inertia = low @ low.T + margin * np.eye(2)
        return np.array([np.trace(inertia), 2.0 * inertia[0, 1], inertia[1, 1], *x[3:]])

    start = [0.3, 0.0, 0.3, 0.0, 0.0, 0.1, 0.1, 0.1, 0.1]
    least = least_squares(
        lambda x: r @ (scale * from_factor(x)) - c, start, bounds=([-np.inf] * 5 + [0.0] * 4, np.inf),
        xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=300,
    )  # fmt: skip
    expected, found = from_factor(least.x), solve_consistent(r, c, scale, margin)
    assert np.linalg.eigvalsh(pseudo_inertia(found)).min() > 0.99 * margin
    assert np.linalg.norm(r @ (scale * found) - c) ** 2 < 2.0 * least.cost + 1e-7 * (c @ c)
    np.testing.assert_allclose(scale * found, scale * expected, rtol=0, atol=1e-4 * np.linalg.norm(c))


@given(seeds)
@settings(max_examples=20)
def test_no_consistent_neighbour_fits_better(seed):
    regression = hostile(seed)
    rng, beta = np.random.default_rng(seed + 1), beta_of("consistent", regression)
    least, margin = cost(regression, beta), np.linalg.eigvalsh(pseudo_inertia(beta)).min()
    for size in 10.0 ** rng.uniform(-4, 0, 200):
        other = beta + size * rng.normal(size=9) * np.maximum(np.abs(beta), 0.01)
        other[5:] = np.maximum(other[5:], 0.0)
        if np.linalg.eigvalsh(pseudo_inertia(other)).min() >= margin:
            assert cost(regression, other) > least * (1.0 - 1e-6)


@given(seeds)
def test_consistent_is_ordinary_where_that_is_consistent(seed):
    rng = np.random.default_rng(seed)
    y = random_regressor(rng)
    regression = problem(y, y @ BETA + 5e-3 * rng.normal(size=(2, 60)))
    ordinary, found = beta_of("ordinary", regression), METHODS["consistent"].estimate(regression)
    assume(is_positive_definite(ordinary - MARGIN * np.array([1.0, 0, 0.5, 0, 0, 0, 0, 0, 0])))
    np.testing.assert_allclose(found.beta, ordinary, rtol=1e-7)
    assert found.notes == ("consistent without being held",)


@given(seeds)
@settings(max_examples=20)
def test_consistent_says_when_it_is_held(seed):
    regression = hostile(seed)
    found, ordinary = METHODS["consistent"].estimate(regression), beta_of("ordinary", regression)
    held = not np.allclose(found.beta, ordinary, rtol=1e-5, atol=1e-8)
    assert found.notes == (
        "the conditions of physical consistency hold it" if held else "consistent without being held",
    )
    if not is_positive_definite(ordinary):
        assert held
        assert cost(regression, found.beta) > cost(regression, ordinary)


@pytest.mark.parametrize("factor", [1e-4, 3000.0])
@pytest.mark.parametrize("name", ["consistent", "parsimonious"])
def test_what_is_held_does_not_depend_on_the_size_of_the_torque(name, factor):
    """The solver's tolerances are for numbers about 1, torques are not; and it warns of nothing."""
    held = 0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for seed in range(20 if name == "consistent" else 2):
            one = hostile(seed)
            other = replace(one, tau=factor * one.tau)
            weak, strong = beta_of(name, one), beta_of(name, other)
            size = np.linalg.norm(one.y, axis=(0, 1))
            atol = 1e-4 * np.linalg.norm(one.tau)
            np.testing.assert_allclose(size * strong / factor, size * weak, rtol=0, atol=atol)
            assert cost(other, strong) == pytest.approx(factor**2 * cost(one, weak), rel=1e-5)
            np.testing.assert_array_equal(strong[5:] == 0.0, weak[5:] == 0.0)
            assert is_positive_definite(strong)
            held += np.sum(weak[5:] == 0.0)
    assert held >= 2


@pytest.mark.parametrize("seed", range(20))
def test_friction_that_is_held_is_held_at_zero_exactly(seed):
    """By the slope of the cost: it rises with friction that is held, and is level with friction that is not."""
    regression = hostile(seed)
    beta = beta_of("consistent", regression)
    slope = np.einsum("jnp,jn->p", regression.y, regression.y @ beta - regression.tau)
    slope = slope / np.linalg.norm(regression.y, axis=(0, 1)) / np.linalg.norm(regression.tau)
    assert (beta[5:][slope[5:] > 1e-3] == 0.0).all()
    assert (beta[5:][np.abs(slope[5:]) < 1e-9] >= 0.0).all()
    torque = beta * np.linalg.norm(regression.y, axis=(0, 1)) / np.linalg.norm(regression.tau)
    assert not ((torque[5:] > 0.0) & (torque[5:] < 1e-7)).any()


@given(seeds)
@settings(max_examples=20)
def test_gravity_may_have_either_sign(seed):
    rng = np.random.default_rng(seed)
    y, truth = random_regressor(rng), BETA.copy()
    truth[3:5] *= -1.0
    regression = problem(y, y @ truth + 1e-3 * rng.normal(size=(2, 60)))
    np.testing.assert_allclose(beta_of("consistent", regression)[3:5], truth[3:5], rtol=0.01)
