"""Link parameters to base parameters (Eq. 1, Table 2), names, units and feasibility."""

import re

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from literal import ARMS
from scipy import constants
from strategies import links

from repro.model import parameters
from repro.model.dynamics import mass_matrix, regressor
from repro.model.parameters import inertial_from_links, is_positive, is_positive_definite

GRID = np.stack([np.zeros(721), np.linspace(-np.pi, np.pi, 721)], -1)


@given(arm=links(), gravity=st.sampled_from([constants.g, 1.62]))
def test_printed_expressions_give_the_numbers(arm, gravity):
    names = {"m1": arm.m1, "m2": arm.m2, "l1": arm.l1, "lc1": arm.lc1, "lc2": arm.lc2, "J1": arm.j1, "J2": arm.j2}
    products = [re.sub(r"(?<=[\w)]) (?=[\w(])", "*", text.replace("^", "**")) for text in parameters.EXPRESSIONS[:5]]
    values = [eval(text, {"__builtins__": {}}, {**names, "g": gravity}) for text in products]
    np.testing.assert_allclose(inertial_from_links(arm, gravity), values, rtol=1e-13)
    assert constants.g == parameters.STANDARD_GRAVITY


@given(speed=st.floats(0.2, 5.0))
def test_units_make_every_term_a_torque(speed):
    # Played `speed` times as fast, a torque's seconds-exponent of -2 is shared between parameter and column.
    q, dq, ddq = np.random.default_rng(4).uniform(-2.0, 2.0, (3, 2, 8))
    slow = regressor(q, dq, ddq, 20.0)
    fast = regressor(q, speed * dq, speed**2 * ddq, 20.0 / speed)
    exponents = {"kg m^2": 0, "N m s/rad": -1, "N m": -2}  # of seconds, with N = kg m/s^2
    for k, unit in enumerate(parameters.UNITS):
        np.testing.assert_allclose(fast[..., k], slow[..., k] * speed ** (2 + exponents[unit]), rtol=1e-12)


@pytest.mark.parametrize(
    ("i2", "g1", "g2", "possible"),
    [(0.1, -3.0, -1.2, True), (0.1, 3.0, -1.2, False), (0.1, 0.0, 0.0, True), (0.0, 3.0, 1.2, True)],
    ids=["both upside down", "one", "in a horizontal plane", "second link balanced"],
)
def test_signs_that_an_arm_can_have(i2, g1, g2, possible):
    assert parameters.has_possible_signs([0.4, i2, 0.2, g1, g2, 0.3, 0.2, 0.5, 0.4]) == possible


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


@pytest.mark.parametrize(("arm", "definite"), [("N1", True), ("N2", False), ("N3", False), ("N4", True)])
def test_published_arms_are_positive_but_two_are_not_positive_definite(arm, definite):
    beta = ARMS[arm]
    found = (is_positive(beta), is_positive_definite(beta), smallest_eigenvalue(beta) > 0.0)
    assert found == (True, definite, definite)


@pytest.mark.parametrize("value", [0.0, -1e-12])
def test_positive_parameters_are_above_zero_and_friction_of_a_definite_arm_is_not_below(value):
    each = np.where(np.eye(9, dtype=bool), value, ARMS["N1"])
    assert not is_positive(each).any()
    assert (is_positive_definite(each[5:]) == (value == 0.0)).all()
    # A centre of mass behind its joint makes I2, g1 and g2 negative: unusual, not impossible.
    assert is_positive_definite(ARMS["N1"] * [1, -1, 1, -1, -1, 1, 1, 1, 1])
