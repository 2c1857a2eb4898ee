"""What a motion tells, against NumPy's linear algebra and combinations derived by hand."""

import re

import numpy as np
import pytest
from log_example import BETA, motion
from regression_example import H, exact, regression_of, rows_of, with_joint_fixed

from repro.identification.excitation import excitation, torque_fraction
from repro.model.parameters import NAMES

T = H * np.arange(1500)


def unit_length(r):
    """Columns of unit length of the parameters that the motion moves."""
    length = np.linalg.norm(rows_of(r), axis=0)
    return rows_of(r)[:, length > 0] / length[length > 0]


def combinations(words):
    """Coefficients of combinations such as ``I1 + 0.31 I3 - 2 g1``, a row each."""
    found = np.zeros((len(words), 9))
    for row, text in zip(found, words, strict=True):
        for sign, size, name in re.findall(r"(?:([+-]) (\S+) )?([Igbk][123])", text):
            row[NAMES.index(name)] = float(sign + (size or "1"))
    return found


@pytest.mark.parametrize("pace", [1.0, 0.3, 0.05, 2.0])
def test_rank_condition_and_correlation_of_friction_are_those_of_the_columns_of_unit_length(pace):
    q, dq, ddq = motion(pace * T)
    r = exact((q, pace * dq, pace**2 * ddq))
    result = excitation(r)
    a = unit_length(r)
    assert result.rank == np.linalg.matrix_rank(a) == 9
    assert result.condition == pytest.approx(np.linalg.cond(a), rel=1e-9)
    assert (result.base_parameters, result.determined) == (NAMES, (True,) * 9)
    covariance = np.linalg.inv(a.T @ a)
    size = np.sqrt(np.diag(covariance))
    expected = covariance / np.outer(size, size)
    assert result.friction_correlation == pytest.approx((expected[5, 7], expected[6, 8]), rel=1e-7)


@pytest.mark.parametrize(("joint", "at"), [(0, 0.0), (0, 0.5), (1, 0.0), (1, 0.7), (1, np.pi / 2), (1, np.pi)])
def test_base_parameters_in_words_are_what_the_motion_determines(joint, at):
    r = exact(with_joint_fixed(motion(T), joint, at))
    result = excitation(r)
    a, c = unit_length(r), combinations(result.base_parameters)
    assert result.rank == np.linalg.matrix_rank(a, tol=1e-4) == len(c) < 9
    assert np.linalg.matrix_rank(c) == result.rank
    # What the combinations do not see moves no torque ...
    basis = np.linalg.svd(c)[2]
    hidden, seen = basis[result.rank :], basis[: result.rank]
    assert hidden.shape == (9 - result.rank, 9)
    assert np.abs(hidden @ rows_of(r).T).max() < 3e-3 * np.abs(seen @ rows_of(r).T).max()
    # ... and whatever moves a torque is seen: no direction of the seen ones is lost.
    assert np.linalg.matrix_rank(rows_of(r) @ seen.T, tol=1e-4 * np.linalg.norm(rows_of(r))) == result.rank
    without_each = (np.delete(rows_of(r), k, axis=1) for k in range(9))
    # A parameter is determined by itself where no others can stand in for it.
    for name, column, others, alone in zip(NAMES, rows_of(r).T, without_each, result.determined, strict=True):
        left = column - others @ np.linalg.lstsq(others, column, rcond=1e-8)[0]
        assert alone == (name in result.base_parameters) == (np.linalg.norm(left) > 1e-3 * np.linalg.norm(column))


def test_no_motion_at_all_tells_nothing():
    still = regression_of(np.zeros((2, 50, 9)), np.zeros((2, 50)))
    assert (torque_fraction(still, BETA) == 0.0).all()
    result = excitation(still)
    assert (result.rank, result.condition, result.friction_correlation) == (0, np.inf, (0.0, 0.0))
    assert (result.determined, result.base_parameters) == ((False,) * 9, ())


def test_torque_share_by_hand():
    y, tau = np.zeros((2, 2, 9)), np.array([[3.0, 4.0], [0.0, 2.0]])
    y[0, :, 0] = 1.0, 1.0  # I1 moves 2 N m in joint 1, whose RMS torque is sqrt(12.5)
    y[1, :, 4] = 0.0, 1.0  # g2 moves sqrt(0.5) N m in joint 2, whose RMS torque is sqrt(2), and less in joint 1
    y[0, :, 4] = 0.1, 0.1
    share = torque_fraction(regression_of(y, tau), np.array([2.0, 5.0, 5.0, 5.0, 1.0, 5.0, 5.0, 5.0, 5.0]))
    assert share == pytest.approx([2.0 / np.sqrt(12.5), 0, 0, 0, 0.5, 0, 0, 0, 0], abs=1e-12)
