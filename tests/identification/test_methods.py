"""Every method through the one interface: independent solvers, joints that do not move, the same bytes twice."""

import warnings
from dataclasses import replace

import log_example
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from log_example import BETA
from regression_example import beta_of, hostile, log_from, noisy_problem, random_regressor, regression_of, resting
from scipy.optimize import nnls
from strategies import seeds

from repro.identification import least_squares
from repro.identification.filtering import FILTERS, FilterSettings, prepare
from repro.identification.least_squares import METHODS
from repro.identification.method import LEAST_SQUARES
from repro.identification.regression import drop_standstill, masked
from repro.identification.uncertainty import fit_replicate

pytestmark = pytest.mark.slow

CLEAN = prepare(log_from(log_example.motion), FilterSettings(cutoff=8.0))
PROBLEMS = {"clean": CLEAN, "noisy": noisy_problem(8, 60, 0.02), "hostile": hostile(3), "more hostile": hostile(5)}
every_method = pytest.mark.parametrize("name", sorted(METHODS))


@pytest.fixture(autouse=True)
def _cross_validation_is_quick(monkeypatch):
    """Which penalty parsimonious chooses is tested elsewhere."""
    monkeypatch.setattr(least_squares, "PENALTIES", (0.0, 0.3, 3.0))
    monkeypatch.setattr(least_squares, "BLOCKS", 2)


def test_names_and_titles():
    assert tuple(METHODS) == LEAST_SQUARES
    assert len({method.title for method in METHODS.values()}) == len(METHODS)


@every_method
@pytest.mark.parametrize("kind", PROBLEMS)
def test_every_method_keeps_the_contract(name, kind):
    """Nine finite numbers, the same bytes each time, the input unchanged, and a repetition keeps the choice."""
    regression, method = PROBLEMS[kind], METHODS[name]
    arrays = [array for array in vars(regression).values() if isinstance(array, np.ndarray)]
    before = [array.tobytes() for array in arrays]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        first, second = method.estimate(regression), method.estimate(regression)
    assert first.beta.shape == (9,) and np.isfinite(first.beta).all()
    assert all("\n" not in note for note in first.notes)
    assert first.beta.tobytes() == second.beta.tobytes() == method.repeat(regression, first).tobytes()
    assert (first.notes, first.choice) == (second.notes, second.choice)
    assert [array.tobytes() for array in arrays] == before


@every_method
@pytest.mark.parametrize("kind", PROBLEMS)
def test_a_replicate_is_the_fit_to_its_samples(name, kind):
    """Whether by sums or by samples; joint 2 has fewer of them."""
    regression, method = PROBLEMS[kind], METHODS[name]
    n = regression.t.size
    regression = masked(regression, np.array([np.full(n, True), np.arange(n) % 5 > 1]))
    first, times = method.estimate(regression), np.arange(n) * 7 % 4
    expected = method.repeat(regression.take(np.repeat(np.arange(n), times)), first)
    assert fit_replicate(method, regression, first, times) == pytest.approx(expected, rel=1e-6, abs=1e-9)


def independent(name, y, tau):
    """The estimate by NumPy's or SciPy's solver of the same problem."""
    rows, right = y.reshape(-1, 9), tau.reshape(-1)
    if name == "bounded":
        return nnls(rows, right)[0]
    moved = y.any(axis=(0, 1))
    beta = np.zeros(9)
    beta[moved] = np.linalg.lstsq(rows[:, moved], right)[0]
    if name == "instrumental":  # without noise of the motion: weighted by the variance of each joint, once
        size = np.sqrt(np.mean((tau - y @ beta) ** 2, axis=1))[:, None]
        return independent("ordinary", y / size[..., None], tau / size)
    return beta


@pytest.mark.parametrize("name", ["ordinary", "bounded", "instrumental"])
@pytest.mark.parametrize("still", [None, 0, 1], ids=["moving", "joint 1 still", "joint 2 still"])
@settings(max_examples=30)
@given(seeds, st.floats(0.1, 1.4))
def test_estimates_are_those_of_an_independent_solver(name, still, seed, at):
    regression = hostile(seed, 60, still, at)
    found = beta_of(name, regression)
    np.testing.assert_allclose(found, independent(name, regression.y, regression.tau), rtol=1e-6, atol=1e-8)
    assert (found[~regression.y.any(axis=(0, 1))] == 0.0).all()


@every_method
@pytest.mark.parametrize("kind", ["noisy", "hostile", "more hostile"])
@pytest.mark.parametrize("factor", [1e-4, 3000.0])
def test_stronger_torque_is_a_stronger_arm(name, kind, factor):
    """The convex solver's tolerances are for numbers about 1, torques are not; what is held at zero stays so."""
    one = PROBLEMS[kind]
    weak, strong = beta_of(name, one), beta_of(name, replace(one, tau=factor * one.tau))
    size = np.linalg.norm(one.y, axis=(0, 1))
    np.testing.assert_allclose(size * strong / factor, size * weak, rtol=0, atol=1e-4 * np.linalg.norm(one.tau))
    np.testing.assert_array_equal(strong[5:] == 0.0, weak[5:] == 0.0)


#: What the row of the joint that moves determines while the other one is fixed at an angle: rows of coefficients.
I1, I2, I3, G1, G2, B1, B2, K1, K2 = np.eye(9)
AT_REST = [(0, at, [I3, G2, B2, K2]) for at in (0.0, 0.3)]
AT_REST += [(1, at, [I1 + np.cos(at) * I2, B1, K1, *([G1, G2] if at else [G1 + G2])]) for at in (0.0, 0.7)]


@pytest.mark.parametrize("filter_name", sorted(FILTERS))
@pytest.mark.parametrize(("joint", "at", "known"), AT_REST)
def test_a_joint_at_rest_spoils_nothing(filter_name, joint, at, known):
    """What the log tells is found, what it does not tell stays a number, and friction that nothing moves is zero."""
    regression = drop_standstill(prepare(resting(joint, at), FilterSettings(name=filter_name, cutoff=5.0)))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = {name: beta_of(name, regression) for name in METHODS}
    for name, beta in found.items():
        assert np.isfinite(beta).all()
        assert np.abs(beta).max() < 100.0, (name, beta)
        left = np.linalg.norm((regression.tau - regression.y @ beta)[1 - joint])
        assert left < 0.02 * np.linalg.norm(regression.tau[1 - joint]), name
        assert np.stack(known) @ beta == pytest.approx(np.stack(known) @ BETA, rel=0.03), name
        assert (beta[[5 + joint, 7 + joint]] == 0.0).all(), (name, beta)


@every_method
@pytest.mark.parametrize("joint", [0, 1])
def test_instruments_and_rows_of_rounding_are_no_motion(name, joint):
    """Rounding of a fixed joint, of another size in each half of the samples."""
    rng = np.random.default_rng(joint)
    y = random_regressor(rng, 80, joint, 0.5)
    unmoved = np.flatnonzero(~y.any(axis=(0, 1)))
    halves = np.stack([y, y])
    halves[..., unmoved] = 1e-13 * rng.normal(size=(2, 2, 80, unmoved.size)) ** 9
    y[..., unmoved] = halves[..., unmoved].mean(0)
    regression = regression_of(y, y @ BETA + 1e-3 * rng.normal(size=(2, 80)), even_odd=halves)
    beta, moved = beta_of(name, regression), np.setdiff1d(np.arange(9), unmoved)
    np.testing.assert_allclose(beta[moved], BETA[moved], rtol=0.1)
    assert (beta[[5 + joint, 7 + joint]] == 0.0).all()
    assert np.abs(beta).max() < 100.0
