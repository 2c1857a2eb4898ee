"""Both readings of "physically possible" (Algorithm 1, line 22)."""

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from strategies import links

from repro.model.dynamics import mass_matrix
from repro.model.feasibility import CHECKS, is_positive, is_positive_definite
from repro.model.parameters import inertial_from_links

# Published test arms (Tables 4 and 5).
N1 = np.array([0.6590, 0.4156, 0.5578, 0.9296, 0.1349, 0.3850, 0.4875, 0.1472, 0.1044])
N2 = np.array([0.6259, 0.4901, 0.8725, 0.5148, 0.7013, 0.3372, 0.0574, 0.0345, 0.1668])
N3 = np.array([0.5020, 0.9779, 0.5040, 0.4777, 0.5724, 0.0715, 0.3820, 0.0972, 0.5721])
N4 = np.array([0.6944, 0.5271, 0.3408, 0.3536, 0.8523, 0.5325, 0.4714, 0.1361, 0.2451])

GRID = np.stack([np.zeros(721), np.linspace(-np.pi, np.pi, 721)], -1)


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


@pytest.mark.parametrize(("beta", "definite"), [(N1, True), (N2, False), (N3, False), (N4, True)])
def test_published_arms_are_positive_but_two_are_not_positive_definite(beta, definite):
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
    check = CHECKS[name]
    bad = N1 * [1, 1, -1, 1, 1, 1, 1, 1, 1]
    batch = np.array([[N1, bad, N4], [bad, N4, N1]])
    answer = check(batch)
    assert answer.dtype == np.bool_
    np.testing.assert_array_equal(answer, [[True, False, True], [False, True, True]])


@pytest.mark.parametrize("check", CHECKS.values(), ids=CHECKS.keys())
@pytest.mark.parametrize("bad", [np.ones(8), np.full(9, np.nan)], ids=["eight", "nan"])
def test_bad_beta_is_refused(check, bad):
    with pytest.raises(ValueError, match=r"^beta: "):
        check(bad)
