"""Link parameters to base parameters (Eq. 1, Table 2), names, units and feasibility."""

import re

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from literal import ARMS
from scipy import constants
from strategies import links

from repro.model.dynamics import inverse_dynamics, mass_matrix, regressor
from repro.model.parameters import (
    DESCRIPTIONS,
    EXPRESSIONS,
    FEASIBILITY,
    NAMES,
    STANDARD_GRAVITY,
    UNITS,
    Links,
    check_beta,
    inertial_from_links,
    is_positive,
    is_positive_definite,
)

N1, N4 = ARMS["N1"], ARMS["N4"]
GRID = np.stack([np.zeros(721), np.linspace(-np.pi, np.pi, 721)], -1)


def test_worked_example():
    arm = Links(m1=2.0, m2=3.0, l1=0.5, lc1=0.2, lc2=0.4, j1=0.1, j2=0.05)
    np.testing.assert_allclose(inertial_from_links(arm, gravity=10.0), [1.46, 1.2, 0.53, 19.0, 12.0], rtol=1e-14)


@given(arm=links(), q1=st.floats(-4.0, 4.0), q2=st.floats(-4.0, 4.0))
def test_inertia_and_gravity_follow_from_the_centres_of_mass(arm, q1, q2):
    # M = sum of m Jv' Jv + J w' w, with Jv the velocity Jacobian of a centre of mass; g = sum of m g dz/dq.
    along1, along12 = (np.array([np.cos(a), np.sin(a)]) for a in (q1, q1 + q2))
    zero = np.zeros(2)
    jacobian1 = np.stack([arm.lc1 * along1, zero], -1)
    jacobian2 = np.stack([arm.l1 * along1 + arm.lc2 * along12, arm.lc2 * along12], -1)
    spin1, spin2 = np.array([1.0, 0.0]), np.array([1.0, 1.0])
    inertia = arm.m1 * jacobian1.T @ jacobian1 + arm.m2 * jacobian2.T @ jacobian2
    inertia += arm.j1 * np.outer(spin1, spin1) + arm.j2 * np.outer(spin2, spin2)
    gravity = STANDARD_GRAVITY * (arm.m1 * jacobian1[1] + arm.m2 * jacobian2[1])
    beta = np.concatenate([inertial_from_links(arm), np.zeros(4)])
    q, still = np.array([[q1], [q2]]), np.zeros((2, 1))
    np.testing.assert_allclose(mass_matrix(q[:, 0], beta), inertia, rtol=0, atol=1e-12)
    np.testing.assert_allclose(inverse_dynamics(q, still, still, beta)[:, 0], gravity, rtol=0, atol=1e-12)


@pytest.mark.slow
@given(arm=links(), factor=st.floats(0.1, 10.0))
def test_gravity_scales_only_the_gravity_parameters(arm, factor):
    earth, elsewhere = inertial_from_links(arm), inertial_from_links(arm, factor * STANDARD_GRAVITY)
    np.testing.assert_allclose(elsewhere, earth * [1.0, 1.0, 1.0, factor, factor], rtol=1e-13)


def test_arrays_of_links_broadcast():
    rng = np.random.default_rng(0)
    m1, j2 = rng.uniform(0.1, 1.0, (4, 3)), rng.uniform(0.1, 1.0, 3)
    many = inertial_from_links(Links(m1=m1, m2=0.5, l1=0.3, lc1=0.1, lc2=0.2, j1=0.01, j2=j2))
    assert many.shape == (4, 3, 5)
    assert many.dtype == np.float64
    one = inertial_from_links(Links(m1=m1[2, 1], m2=0.5, l1=0.3, lc1=0.1, lc2=0.2, j1=0.01, j2=j2[1]))
    np.testing.assert_allclose(many[2, 1], one, rtol=1e-15)


def test_gravity_is_the_standard_one_unless_another_is_given():
    arm = Links(m1=1.0, m2=1.0, l1=1.0, lc1=1.0, lc2=1.0, j1=0.1, j2=0.1)
    np.testing.assert_allclose(inertial_from_links(arm)[3:], [2.0 * constants.g, constants.g], rtol=1e-15)


def test_there_are_nine_of_everything_in_the_published_order():
    assert NAMES == ("I1", "I2", "I3", "g1", "g2", "b1", "b2", "k1", "k2")
    assert len(UNITS) == len(DESCRIPTIONS) == len(EXPRESSIONS) == 9
    assert len(set(DESCRIPTIONS)) == 9


@given(arm=links())
def test_printed_expressions_give_the_numbers(arm):
    names = {"m1": arm.m1, "m2": arm.m2, "l1": arm.l1, "lc1": arm.lc1, "lc2": arm.lc2, "J1": arm.j1, "J2": arm.j2}
    names["g"] = STANDARD_GRAVITY
    products = [re.sub(r"(?<=[\w)]) (?=[\w(])", "*", text.replace("^", "**")) for text in EXPRESSIONS[:5]]
    values = [eval(text, {"__builtins__": {}}, names) for text in products]
    np.testing.assert_allclose(inertial_from_links(arm), values, rtol=1e-13)


@given(speed=st.floats(0.2, 5.0))
def test_units_make_every_term_a_torque(speed):
    # Played `speed` times as fast, a torque's seconds-exponent of -2 is shared between parameter and column.
    q, dq, ddq = np.random.default_rng(4).uniform(-2.0, 2.0, (3, 2, 8))
    slow = regressor(q, dq, ddq, 20.0)
    fast = regressor(q, speed * dq, speed**2 * ddq, 20.0 / speed)
    for k, unit in enumerate(UNITS):
        base, _, seconds = unit.partition("/s")
        assert base == "kg m^2"
        parameter_exponent = -int(seconds.lstrip("^") or 1) if "/s" in unit else 0
        np.testing.assert_allclose(fast[..., k], slow[..., k] * speed ** (2 + parameter_exponent), rtol=1e-12)


def test_check_beta_returns_the_same_numbers_as_float64():
    checked = check_beta(np.arange(18).reshape(2, 9))
    assert checked.dtype == np.float64
    np.testing.assert_array_equal(checked, np.arange(18.0).reshape(2, 9))


@pytest.mark.parametrize(
    ("bad", "message"),
    [
        (np.float64(3.0), r"^beta: .*9 parameters, got shape \(\)"),
        (np.ones(10), r"^beta: .*9 parameters, got shape \(10,\)"),
        (np.ones((9, 3)), r"^beta: .*9 parameters, got shape \(9, 3\)"),
        (np.array([1.0] * 8 + [np.nan]), r"^beta: every parameter must be finite"),
        (np.array([[1.0] * 9, [-np.inf] + [1.0] * 8]), r"^beta: every parameter must be finite"),
    ],
)
def test_bad_beta_is_refused(bad, message):
    with pytest.raises(ValueError, match=message):
        check_beta(bad)


def smallest_eigenvalue(beta):
    """Smallest eigenvalue of M over one turn of q2, shape (...)."""
    return np.linalg.eigvalsh(mass_matrix(GRID, np.asarray(beta)[..., None, :])).min((-1, -2))


@given(i1=st.floats(-0.5, 3.0), i2=st.floats(-2.0, 2.0), i3=st.floats(-0.5, 2.0))
@example(i1=-2.0, i2=0.1, i3=-1.0)  # negative definite: the determinant alone does not tell
def test_positive_definite_agrees_with_eigenvalues(i1, i2, i3):
    beta = np.array([i1, i2, i3, 1.0, 1.0, 0.1, 0.1, 0.1, 0.1])
    smallest = smallest_eigenvalue(beta)
    assume(abs(smallest) > 1e-9)  # on the border itself rounding decides
    assert is_positive_definite(beta) == (smallest > 0.0)


@pytest.mark.slow
def test_positive_definite_agrees_with_eigenvalues_on_many_sets():
    beta = np.random.default_rng(0).uniform([0, -1.5, 0, -1, -1, 0, 0, 0, 0], [2, 1.5, 1, 1, 1, 1, 1, 1, 1], (4000, 9))
    expected = smallest_eigenvalue(beta) > 0.0
    assert 0.2 < expected.mean() < 0.8  # both answers are tried
    np.testing.assert_array_equal(is_positive_definite(beta), expected)


@pytest.mark.parametrize(("arm", "definite"), [("N1", True), ("N2", False), ("N3", False), ("N4", True)])
def test_published_arms_are_positive_but_two_are_not_positive_definite(arm, definite):
    beta = ARMS[arm]
    assert is_positive(beta)
    assert is_positive_definite(beta) == definite
    assert (smallest_eigenvalue(beta) > 0.0) == definite


@given(arm=links(), friction=st.lists(st.floats(1e-3, 1.0), min_size=4, max_size=4))
def test_links_with_mass_pass_both_checks(arm, friction):
    beta = np.concatenate([inertial_from_links(arm), friction])
    assert is_positive(beta)
    assert is_positive_definite(beta)


@pytest.mark.parametrize("k", range(9))
@pytest.mark.parametrize("value", [0.0, -1e-12])
def test_positive_refuses_any_parameter_that_is_not_above_zero(k, value):
    beta = N1.copy()
    beta[k] = value
    assert not is_positive(beta)


@pytest.mark.parametrize("k", [5, 6, 7, 8])
def test_positive_definite_refuses_friction_that_drives(k):
    beta = N1.copy()
    beta[k] = -1e-12
    assert not is_positive_definite(beta)


def test_positive_definite_does_not_judge_the_sign_of_coupling_or_gravity():
    # A centre of mass behind its joint makes I2, g1 and g2 negative: unusual, not impossible.
    assert is_positive_definite(N1 * [1, -1, 1, -1, -1, 1, 1, 1, 1])


@pytest.mark.parametrize("name", ["positive", "positive-definite"])
def test_checks_judge_each_set_of_a_batch(name):
    check = FEASIBILITY[name]
    bad = N1 * [1, 1, -1, 1, 1, 1, 1, 1, 1]
    batch = np.array([[N1, bad, N4], [bad, N4, N1]])
    answer = check(batch)
    assert answer.dtype == np.bool_
    np.testing.assert_array_equal(answer, [[True, False, True], [False, True, True]])
