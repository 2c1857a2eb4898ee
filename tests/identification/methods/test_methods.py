"""Every method through the one interface: clean logs, joints that do not move, the same bytes twice."""

import warnings
from dataclasses import replace

import log_example
import numpy as np
import pytest
from hypothesis import given, settings
from log_example import BETA
from regression_example import log_from, problem, random_regressor, resting
from strategies import seeds

from repro.export.bibtex import entries
from repro.identification.filters.interface import FILTERS
from repro.identification.methods.every import METHODS
from repro.identification.parallel import FilterSettings, prepare
from repro.identification.standstill import without_standstill
from repro.model.dynamics import regressor
from repro.model.parameters import NAMES

CLEAN = prepare(log_from(log_example.motion), FilterSettings(cutoff=8.0))
every_method = pytest.mark.parametrize("name", sorted(METHODS))


def beta_of(name, regression):
    return METHODS[name].estimate(regression).beta


def hostile(seed, n=40):
    """A regression whose best parameters are often not physical: signs of the truth are drawn."""
    rng = np.random.default_rng(seed)
    y = random_regressor(rng, n)
    noise = rng.choice([0.01, 0.1, 1.0]) * rng.normal(size=(2, n))
    return problem(y, y @ (BETA * rng.choice([-1.0, 1.0, 1.0], 9)) + noise)


# The interface.


def test_names_are_keys():
    assert [method.name for method in METHODS.values()] == list(METHODS)
    assert len({method.title for method in METHODS.values()}) == len(METHODS)


@every_method
def test_every_method_says_where_it_comes_from(name):
    assert METHODS[name].citation in entries()
    assert METHODS[name].title


@every_method
def test_a_clean_regression_gives_the_arm_back(name):
    found = METHODS[name].estimate(CLEAN)
    np.testing.assert_allclose(found.beta, BETA, rtol=0.01)
    assert found.beta.shape == (9,)
    assert all("\n" not in note for note in found.notes)


@every_method
def test_the_same_input_gives_the_same_bytes_and_is_left_alone(name):
    for regression in (CLEAN, hostile(3)):
        arrays = [array for array in vars(regression).values() if isinstance(array, np.ndarray)]
        before = [array.tobytes() for array in arrays]
        first, second = METHODS[name].estimate(regression), METHODS[name].estimate(regression)
        assert first.beta.tobytes() == second.beta.tobytes()
        assert (first.notes, first.choice) == (second.notes, second.choice)
        assert [array.tobytes() for array in arrays] == before


@pytest.mark.slow
@every_method
@pytest.mark.parametrize("factor", [1e-4, 0.1, 3.0, 50.0, 3000.0])
def test_stronger_torque_is_a_stronger_arm(name, factor):
    rng = np.random.default_rng(8)
    noisy = replace(CLEAN, tau=CLEAN.tau + 0.02 * rng.normal(size=CLEAN.tau.shape))
    one, other = beta_of(name, noisy), beta_of(name, replace(noisy, tau=factor * noisy.tau))
    np.testing.assert_allclose(other, factor * one, rtol=1e-5, atol=1e-7 * factor)


# Joints that do not move.

#: What the row of the joint that moves says while the other one is fixed at an angle: combinations that are determined.
ALONE = {name: {name: 1.0} for name in NAMES}
STRAIGHT = [{"g1": 1.0, "g2": 1.0}, ALONE["b1"], ALONE["k1"]]
BENT = [ALONE[name] for name in ("g1", "g2", "b1", "k1")]
SECOND = [ALONE[name] for name in ("I3", "g2", "b2", "k2")]
AT_REST = [(0, at, SECOND) for at in (0.0, 0.3, 0.7)]
AT_REST += [(1, at, [{"I1": 1.0, "I2": np.cos(at)}, *(BENT if at else STRAIGHT)]) for at in (0.0, 0.3, 0.7)]


@pytest.mark.slow
@pytest.mark.parametrize("filter_name", sorted(FILTERS))
@pytest.mark.parametrize(("joint", "at", "known"), AT_REST)
def test_a_joint_at_rest_spoils_nothing(filter_name, joint, at, known):
    """What the log tells is found, what it does not tell stays a number, and friction that nothing moves is zero."""
    regression = without_standstill(prepare(resting(joint, at), FilterSettings(name=filter_name, cutoff=5.0)))
    # Choosing parsimonious' penalty takes half a second where the solver of `consistent` has to run.
    slow = filter_name != "savitzky-golay" or (joint, at) in {(0, 0.0), (0, 0.7)}
    names = [name for name in METHODS if not (slow and name == "parsimonious")]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = {name: beta_of(name, regression) for name in names}
    for name, beta in found.items():
        assert np.isfinite(beta).all()
        assert np.abs(beta).max() < 100.0, (name, beta)
        left = np.linalg.norm((regression.tau - regression.y @ beta)[1 - joint])
        assert left < 0.02 * np.linalg.norm(regression.tau[1 - joint]), name
        for combination in known:
            row = np.array([combination.get(each, 0.0) for each in NAMES])
            assert row @ beta == pytest.approx(row @ BETA, rel=0.03), (name, combination)
        assert (beta[[5 + joint, 7 + joint]] == 0.0).all(), (name, beta)


@pytest.mark.slow
@every_method
@pytest.mark.parametrize("joint", [0, 1])
def test_instruments_and_rows_of_rounding_are_no_motion(name, joint):
    """Rounding of a fixed joint, of another size in each half of the samples."""
    rng = np.random.default_rng(joint)
    q, dq, ddq = (size * rng.normal(size=(2, 80)) for size in (1.0, 2.0, 5.0))
    q[joint], dq[joint], ddq[joint] = 0.5, 0.0, 0.0
    y = regressor(q, dq, ddq)
    unmoved = np.flatnonzero(~y.any(axis=(0, 1)))
    halves = np.stack([y, y])
    halves[..., unmoved] = 1e-13 * rng.normal(size=(2, 2, 80, unmoved.size)) ** 9
    y[..., unmoved] = halves[..., unmoved].mean(0)
    regression = problem(y, y @ BETA + 1e-3 * rng.normal(size=(2, 80)), halves)
    beta, moved = beta_of(name, regression), np.setdiff1d(np.arange(9), unmoved)
    np.testing.assert_allclose(beta[moved], BETA[moved], rtol=0.1)
    assert (beta[[5 + joint, 7 + joint]] == 0.0).all()
    assert np.abs(beta).max() < 100.0


@every_method
def test_a_repetition_keeps_what_was_chosen(name):
    method, first = METHODS[name], METHODS[name].estimate(CLEAN)
    np.testing.assert_array_equal(method.repeat(CLEAN, first), first.beta)
    other = hostile(5)
    if method.refit is None:
        np.testing.assert_array_equal(method.repeat(other, first), method.estimate(other).beta)


@pytest.mark.parametrize("name", ["bounded", "consistent", "parsimonious", "robust", "weighted", "instrumental"])
def test_small_normal_noise_moves_no_method_far_from_ordinary(name):
    rng = np.random.default_rng(1)
    noisy = replace(CLEAN, tau=CLEAN.tau + 0.01 * rng.normal(size=CLEAN.tau.shape))
    np.testing.assert_allclose(beta_of(name, noisy), beta_of("ordinary", noisy), rtol=0.05)


@given(seeds)
@settings(max_examples=30)
def test_ordinary_is_numpy_s(seed):
    regression = hostile(seed)
    expected, *_ = np.linalg.lstsq(regression.y.reshape(-1, 9), regression.tau.reshape(-1))
    np.testing.assert_allclose(beta_of("ordinary", regression), expected, rtol=1e-8, atol=1e-10)
