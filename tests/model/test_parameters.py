"""Link parameters to base parameters (Eq. 1, Table 2), names and units."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import constants
from strategies import links

from repro.model.dynamics import gravity_torque, mass_matrix, regressor
from repro.model.parameters import (
    DESCRIPTIONS,
    EXPRESSIONS,
    NAMES,
    STANDARD_GRAVITY,
    UNITS,
    Links,
    check_beta,
    inertial_from_links,
)


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
    q = np.array([q1, q2])
    np.testing.assert_allclose(mass_matrix(q, beta), inertia, rtol=0, atol=1e-12)
    np.testing.assert_allclose(gravity_torque(q, beta), gravity, rtol=0, atol=1e-12)


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
