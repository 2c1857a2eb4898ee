"""What a motion tells, against NumPy's linear algebra and combinations derived by hand."""

import re

import numpy as np
import pytest
from log_example import BETA, motion
from regression_example import H, exact, exciting, regression_of

from repro.identification.excitation import excitation, torque_fraction
from repro.model.parameters import NAMES

N = 1500
T = H * np.arange(N)
PLACE = {name: k for k, name in enumerate(NAMES)}


def rows_of(r):
    return r.y.reshape(-1, 9)


def unit_length(r):
    """Columns of unit length of the parameters that the motion moves, and their places."""
    length = np.linalg.norm(rows_of(r), axis=0)
    moved = np.flatnonzero(length > 0)
    return rows_of(r)[:, moved] / length[moved], moved


def with_joint_fixed(joint, at):
    q, dq, ddq = motion(T)
    q[joint], dq[joint], ddq[joint] = at, 0.0, 0.0
    return exact((q, dq, ddq))


def slowed(factor, t=T):
    """The same path at another pace."""
    q, dq, ddq = motion(factor * t)
    return q, factor * dq, factor**2 * ddq


def combinations(words):
    """Coefficients of parsed combinations such as ``I1 + 0.31 I3 - 2 g1``, a row each."""
    found = np.zeros((len(words), 9))
    for row, text in zip(found, words, strict=True):
        assert re.fullmatch(r"[Igbk][123]( [+-] [0-9.e+-]+ [Igbk][123])*", text), text
        first, *rest = re.split(r" (?=[+-] )", text)
        row[PLACE[first]] = 1.0
        for part in rest:
            sign, size, name = part.split()
            assert row[PLACE[name]] == 0.0
            row[PLACE[name]] = float(sign + size)
    return found


# Excitation


@pytest.mark.parametrize("pace", [1.0, 0.3, 0.05, 2.0])
def test_rank_and_condition_are_those_of_the_columns_of_unit_length(pace):
    r = exact(slowed(pace))
    result = excitation(r)
    a, moved = unit_length(r)
    assert moved.size == 9
    assert result.rank == np.linalg.matrix_rank(a) == 9
    assert result.condition == pytest.approx(np.linalg.cond(a), rel=1e-9)
    assert result.base_parameters == NAMES


@pytest.mark.parametrize(("joint", "at"), [(0, 0.0), (0, 0.5), (1, 0.0), (1, 0.7), (1, np.pi / 2)])
def test_base_parameters_in_words_are_what_the_motion_determines(joint, at):
    r = with_joint_fixed(joint, at)
    result = excitation(r)
    a, _ = unit_length(r)
    c = combinations(result.base_parameters)
    assert result.rank == np.linalg.matrix_rank(a, tol=1e-4) == len(c) < 9
    assert np.linalg.matrix_rank(c) == result.rank
    # What the combinations do not see moves no torque ...
    basis = np.linalg.svd(c)[2]
    hidden, seen = basis[result.rank :], basis[: result.rank]
    assert hidden.shape == (9 - result.rank, 9)
    assert np.abs(hidden @ rows_of(r).T).max() < 3e-3 * np.abs(seen @ rows_of(r).T).max()
    # ... and whatever moves a torque is seen: no direction of the seen ones is lost.
    assert np.linalg.matrix_rank(rows_of(r) @ seen.T, tol=1e-4 * np.linalg.norm(rows_of(r))) == result.rank
    # Two parameter sets that agree in the combinations give the same torque, two that do not give another.
    rng = np.random.default_rng(3)
    other = BETA + rng.normal(size=9 - result.rank) @ hidden
    assert c @ other == pytest.approx(c @ BETA, abs=1e-9)
    assert r.y @ other == pytest.approx(r.y @ BETA, abs=3e-3 * np.abs(r.tau).max())
    assert np.abs(r.y @ (BETA + 0.3 * seen[-1]) - r.tau).max() > 0.01


@pytest.mark.parametrize(
    ("joint", "at", "alone"),
    [
        (1, 0.0, {"g1", "g2", "b1", "k1"}),
        (1, 0.7, {"I1", "I2", "I3", "g1", "g2", "b1", "k1"}),
        (0, 0.0, {"I2", "I3", "g2", "b2", "k2"}),
        (0, 0.5, {"I2", "I3", "g1", "g2", "b2", "k2"}),
        (None, 0.0, set(NAMES)),
    ],
)
def test_a_parameter_is_determined_where_no_other_can_stand_in_for_it(joint, at, alone):
    r = exciting(N) if joint is None else with_joint_fixed(joint, at)
    result = excitation(r)
    assert {name for name, by_itself in zip(NAMES, result.determined, strict=True) if by_itself} == alone
    a = rows_of(r)
    for k, name in enumerate(NAMES):
        others = np.delete(a, k, axis=1)
        left = a[:, k] - others @ np.linalg.lstsq(others, a[:, k], rcond=1e-8)[0]
        assert (np.linalg.norm(left) > 1e-3 * np.linalg.norm(a[:, k])) == (name in alone)
        assert (name in result.base_parameters) == (name in alone)


def test_no_motion_at_all_tells_nothing():
    still = regression_of(np.zeros((2, 50, 9)), np.zeros((2, 50)))
    assert (torque_fraction(still, BETA) == 0.0).all()
    result = excitation(still)
    assert result.rank == 0
    assert result.condition == np.inf
    assert result.friction_correlation == (0.0, 0.0)
    assert result.determined == (False,) * 9
    assert result.base_parameters == ()


def test_friction_correlation_is_that_of_the_least_squares_covariance():
    for pace in (0.1, 1.0, 2.0):
        r = exact(slowed(pace))
        covariance = np.linalg.inv(rows_of(r).T @ rows_of(r))
        size = np.sqrt(np.diag(covariance))
        expected = covariance / np.outer(size, size)
        assert excitation(r).friction_correlation == pytest.approx((expected[5, 7], expected[6, 8]), rel=1e-7)


def test_torque_share_by_hand():
    y, tau = np.zeros((2, 2, 9)), np.array([[3.0, 4.0], [0.0, 2.0]])
    y[0, :, 0] = 1.0, 1.0  # I1 moves 2 N m in joint 1, whose RMS torque is sqrt(12.5)
    y[1, :, 4] = 0.0, 1.0  # g2 moves sqrt(0.5) N m in joint 2, whose RMS torque is sqrt(2), and less in joint 1
    y[0, :, 4] = 0.1, 0.1
    share = torque_fraction(regression_of(y, tau), np.array([2.0, 5.0, 5.0, 5.0, 1.0, 5.0, 5.0, 5.0, 5.0]))
    assert share == pytest.approx([2.0 / np.sqrt(12.5), 0, 0, 0, 0.5, 0, 0, 0, 0], abs=1e-12)
