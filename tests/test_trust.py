"""What an estimate is worth: against NumPy's linear algebra, textbook formulas and the spread over simulated data."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from log_example import BETA, motion
from ownarm_log import CUTOFF, H, autoregressive, exact, exciting, regression_of

from repro.estimators import ordinary
from repro.estimators.interface import Estimate
from repro.model.parameters import NAMES
from repro.trust.bootstrap import block_length, bootstrap, correlation_time, redraw
from repro.trust.excitation import excitation, torque_share
from repro.trust.residuals import lag_one
from repro.trust.words import COMBINED, NOT_EXCITED, verdict

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


@pytest.mark.parametrize("pace", [1.0, 0.3, 2.0])
def test_rank_and_condition_are_those_of_the_columns_of_unit_length(pace):
    r = exact(slowed(pace))
    told = excitation(r)
    a, moved = unit_length(r)
    assert moved.size == 9
    assert told.rank == np.linalg.matrix_rank(a) == 9
    assert told.condition == pytest.approx(np.linalg.cond(a), rel=1e-9)
    assert told.base_parameters == NAMES


def test_condition_does_not_depend_on_units():
    r = exciting(N)
    scaled = regression_of(r.y * 10.0 ** np.arange(-4, 5), r.tau)
    assert excitation(scaled).condition == pytest.approx(excitation(r).condition, rel=1e-9)
    assert excitation(scaled).friction_correlation == pytest.approx(excitation(r).friction_correlation, rel=1e-9)


@pytest.mark.parametrize(("joint", "at"), [(0, 0.0), (0, 0.5), (1, 0.0), (1, 0.7), (1, np.pi / 2)])
def test_base_parameters_in_words_are_what_the_motion_determines(joint, at):
    r = with_joint_fixed(joint, at)
    told = excitation(r)
    a, _ = unit_length(r)
    c = combinations(told.base_parameters)
    assert told.rank == np.linalg.matrix_rank(a, tol=1e-4) == len(c) < 9
    assert np.linalg.matrix_rank(c) == told.rank
    # What the combinations do not see moves no torque ...
    basis = np.linalg.svd(c)[2]
    hidden, seen = basis[told.rank :], basis[: told.rank]
    assert hidden.shape == (9 - told.rank, 9)
    assert np.abs(hidden @ rows_of(r).T).max() < 3e-3 * np.abs(seen @ rows_of(r).T).max()
    # ... and whatever moves a torque is seen: no direction of the seen ones is lost.
    assert np.linalg.matrix_rank(rows_of(r) @ seen.T, tol=1e-4 * np.linalg.norm(rows_of(r))) == told.rank
    # Two parameter sets that agree in the combinations give the same torque, two that do not give another.
    rng = np.random.default_rng(3)
    other = BETA + rng.normal(size=9 - told.rank) @ hidden
    assert c @ other == pytest.approx(c @ BETA, abs=1e-9)
    assert r.y @ other == pytest.approx(r.y @ BETA, abs=3e-3 * np.abs(r.tau).max())
    assert np.abs(r.y @ (BETA + 0.3 * seen[-1]) - r.tau).max() > 0.01


def test_a_straight_arm_shows_sums_of_inertias_only():
    # q2 = 0: tau1 = (I1 + I2) ddq1 + (g1 + g2) sin q1 + friction, tau2 = (I2/2 + I3) ddq1 + g2 sin q1, by Eq. 1.
    told = excitation(with_joint_fixed(1, 0.0))
    c = combinations(told.base_parameters)
    assert told.rank == 6
    for known in (
        {"I1": 1, "I2": 1},
        {"I2": 0.5, "I3": 1},
        {"g1": 1, "g2": 1},
        {"g2": 1},
        {"b1": 1},
        {"k1": 1},
    ):
        row = np.array([known.get(name, 0.0) for name in NAMES])
        assert np.linalg.matrix_rank(np.vstack([c, row]), tol=1e-2) == 6, known
    for alone in ("I1", "I2", "I3", "b2", "k2"):
        row = np.eye(9)[PLACE[alone]]
        assert np.linalg.matrix_rank(np.vstack([c, row]), tol=1e-2) == 7, alone


@settings(max_examples=40)
@given(st.floats(0.3, 1.2), st.floats(-1.5, 1.5), st.sampled_from([0, 1]))
def test_base_parameters_at_any_fixed_place(pace, at, joint):
    q, dq, ddq = slowed(pace)
    at = round(at, 2)  # at a billionth of a radian gravity is rounding
    q[joint], dq[joint], ddq[joint] = at, 0.0, 0.0
    r = exact((q, dq, ddq))
    told = excitation(r)
    c = combinations(told.base_parameters)
    hidden = np.linalg.svd(c)[2][told.rank :]
    a, _ = unit_length(r)
    assert told.rank == len(c) == np.linalg.matrix_rank(a, tol=1e-4 * np.linalg.norm(a, 2))
    assert np.abs(r.y @ hidden.T).max() < 0.01 * np.abs(r.y).max()


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
    told = excitation(r)
    assert {name for name, by_itself in zip(NAMES, told.determined, strict=True) if by_itself} == alone
    a = rows_of(r)
    for k, name in enumerate(NAMES):
        others = np.delete(a, k, axis=1)
        left = a[:, k] - others @ np.linalg.lstsq(others, a[:, k], rcond=1e-8)[0]
        assert (np.linalg.norm(left) > 1e-3 * np.linalg.norm(a[:, k])) == (name in alone)
        assert (name in told.base_parameters) == (name in alone)


def test_no_motion_at_all_tells_nothing():
    told = excitation(regression_of(np.zeros((2, 50, 9)), np.ones((2, 50))))
    assert told.rank == 0
    assert told.condition == np.inf
    assert told.friction_correlation == (0.0, 0.0)
    assert told.determined == (False,) * 9
    assert told.base_parameters == ()


def test_base_parameters_leave_out_what_moves_no_torque_and_not_what_has_a_small_number():
    """Columns in units that make a coefficient of a millionth half of the torque, and one of a thousand nothing."""
    rng = np.random.default_rng(4)
    y = rng.normal(size=(2, 300, 9))
    y[..., 4] = 1e-6 * (y[..., 3] + y[..., 0])  # g2 in combination with g1 and I1, its torque a millionth
    y[..., 8] = 1e-4 * y[..., 6] + 1e-7 * y[..., 5]  # k2 with b2, and with b1 too little to be seen
    told = excitation(regression_of(y, np.ones((2, 300))))
    c = combinations(told.base_parameters)
    assert told.rank == len(c) == 7
    assert told.determined == tuple(name in {"I2", "I3", "b1", "k1"} for name in NAMES)
    seen = np.zeros((2, 9))
    seen[0, [3, 4]] = 1.0, 1e-6
    seen[1, [0, 4]] = 1.0, 1e-6
    friction = np.zeros((1, 9))
    friction[0, [6, 8]] = 1.0, 1e-4
    for row in (*seen, *friction):
        assert np.linalg.matrix_rank(scaled_to_torque(np.vstack([c, row]), y), tol=1e-2) == 7
    assert "b1" in told.base_parameters


def scaled_to_torque(combination, y):
    """Rows of coefficients in units of the torque that each parameter moves, of length one."""
    rows = combination / np.linalg.norm(y, axis=(0, 1))
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


def test_friction_correlation_is_that_of_the_least_squares_covariance():
    for pace in (0.1, 1.0, 2.0):
        r = exact(slowed(pace))
        covariance = np.linalg.inv(rows_of(r).T @ rows_of(r))
        size = np.sqrt(np.diag(covariance))
        expected = covariance / np.outer(size, size)
        assert excitation(r).friction_correlation == pytest.approx((expected[5, 7], expected[6, 8]), rel=1e-7)


def test_slow_motion_does_not_tell_viscous_from_coulomb_friction_but_slow_and_fast_does():
    slow, fast = slowed(0.01), slowed(1.0)
    pieces = [np.concatenate(pair, axis=-1) for pair in zip(slowed(0.1), slowed(3.0, T[: N // 5]), strict=True)]
    of_slow, of_fast, of_both = (np.abs(excitation(exact(m)).friction_correlation) for m in (slow, fast, pieces))
    assert (of_slow > 0.99).all()
    assert (of_both < 0.65).all()
    assert (of_both < of_fast).all()


@pytest.mark.parametrize("pace", [0.01, 0.001, 1e-4])
def test_of_collinear_friction_more_of_one_is_less_of_the_other(pace):
    """Below the tanh's knee viscous and Coulomb torque are one signal, and their estimates trade against each other."""
    assert max(excitation(exact(slowed(pace))).friction_correlation) < -0.9


@given(st.floats(0.01, 100.0))
def test_exactly_collinear_friction_has_a_correlation_of_minus_one(ratio):
    r = exciting(300)
    y = r.y.copy()
    y[..., 7:9] = ratio * y[..., 5:7]
    told = excitation(regression_of(y, r.tau))
    assert told.friction_correlation == pytest.approx((-1.0, -1.0), abs=1e-3)
    y[..., 7:9] *= -1.0
    assert excitation(regression_of(y, r.tau)).friction_correlation == pytest.approx((1.0, 1.0), abs=1e-3)
    assert told.determined == (True,) * 5 + (False,) * 4


def test_friction_of_a_fixed_joint_has_no_correlation():
    assert excitation(with_joint_fixed(1, 0.3)).friction_correlation[1] == 0.0
    assert excitation(with_joint_fixed(0, 0.3)).friction_correlation[0] == 0.0


def test_torque_share_by_hand():
    y, tau = np.zeros((2, 2, 9)), np.array([[3.0, 4.0], [0.0, 2.0]])
    y[0, :, 0] = 1.0, 1.0  # I1 moves 2 N m in joint 1, whose RMS torque is sqrt(12.5)
    y[1, :, 4] = 0.0, 1.0  # g2 moves sqrt(0.5) N m in joint 2, whose RMS torque is sqrt(2), and less in joint 1
    y[0, :, 4] = 0.1, 0.1
    share = torque_share(regression_of(y, tau), np.array([2.0, 5.0, 5.0, 5.0, 1.0, 5.0, 5.0, 5.0, 5.0]))
    assert share == pytest.approx([2.0 / np.sqrt(12.5), 0, 0, 0, 0.5, 0, 0, 0, 0], abs=1e-12)


@given(st.lists(st.floats(-5.0, 5.0), min_size=9, max_size=9), st.floats(1e-3, 1e3))
def test_torque_shares_have_the_limits_of_rms(beta, unit):
    beta = np.array(beta)
    r = exciting(200)
    tau = r.y @ beta
    share = torque_share(replace(r, tau=tau), beta)
    assert (share >= 0.0).all()
    assert (share[beta == 0.0] == 0.0).all()
    if np.abs(tau).max() > 1e-6:
        # RMS of a sum is at most the sum of RMS, and sign or unit of the torque is no matter.
        assert share.sum() >= 1.0 - 1e-9
        scaled = torque_share(replace(r, tau=-unit * tau), unit * beta)
        assert scaled == pytest.approx(share, rel=1e-9)


def test_a_parameter_alone_moves_all_torque_and_an_unmoved_one_none():
    r = exciting(N)
    for k in range(9):
        alone = BETA[k] * np.eye(9)[k]
        share = torque_share(replace(r, tau=r.y @ alone), BETA)
        assert share[k] == pytest.approx(1.0, rel=1e-12)
    fixed = with_joint_fixed(1, 0.4)
    still = torque_share(fixed, BETA)
    assert (still[[PLACE["b2"], PLACE["k2"]]] == 0.0).all()
    assert (np.delete(still, [PLACE["b2"], PLACE["k2"]]) > 0.0).all()


def test_without_torque_no_parameter_has_a_share():
    r = exciting(N)
    assert (torque_share(replace(r, tau=np.zeros_like(r.tau)), BETA) == 0.0).all()


# Bootstrap


def textbook(r):
    """Standard errors of ordinary least squares for white residuals of one size."""
    a, tau = rows_of(r), r.tau.reshape(-1)
    beta, energy = np.linalg.lstsq(a, tau, rcond=None)[:2]
    return beta, np.sqrt(np.diag(np.linalg.inv(a.T @ a)) * energy[0] / (tau.size - 9))


def ordinary_spread(r, seed, replicates=200, method=ordinary.METHOD, as_good=()):
    return bootstrap(method, r, method.estimate(r), as_good, np.random.default_rng(seed), replicates)


def test_on_white_noise_standard_errors_are_those_of_the_textbook():
    clean = exciting(N)
    r = replace(clean, tau=clean.tau + 0.1 * np.random.default_rng(1).normal(size=(2, N)))
    beta, expected = textbook(r)
    spread = ordinary_spread(r, 2, 1000)
    assert spread.standard_error == pytest.approx(expected, rel=0.15)
    assert 0.5 * (spread.low + spread.high) == pytest.approx(beta, rel=1e-6, abs=1e-9)


def test_on_correlated_noise_they_are_those_of_many_simulated_logs():
    n, rho, rng = 3000, 0.95, np.random.default_rng(9)
    clean = exciting(n)
    solver = np.linalg.pinv(rows_of(clean))
    simulated = np.std([solver @ autoregressive(rho, n, rng, 0.1).reshape(-1) for _ in range(600)], axis=0)
    logs = [replace(clean, tau=clean.tau + autoregressive(rho, n, rng, 0.1)) for _ in range(6)]
    claimed = np.mean([ordinary_spread(r, k).standard_error for k, r in enumerate(logs)], axis=0)
    white = np.mean([textbook(r)[1] for r in logs], axis=0)
    assert claimed == pytest.approx(simulated, rel=0.3)
    assert (claimed > 2.0 * white).all()
    assert (claimed[[PLACE["g1"], PLACE["g2"]]] > 3.5 * white[[PLACE["g1"], PLACE["g2"]]]).all()


def test_intervals_reach_as_far_as_students_t():
    # Residuals correlated throughout make the longest blocks: twenty, 19 degrees of freedom, 2.093 in every table.
    r = exciting(N)
    drifting = replace(r, tau=r.tau + 0.1 * np.sin(2 * np.pi * T / T[-1]))
    assert block_length(drifting.tau - drifting.y @ ordinary.estimate(drifting).beta, H) == N // 20
    spread = ordinary_spread(drifting, 3)
    assert (spread.high - spread.low) / (2 * spread.standard_error) == pytest.approx([2.093] * 9, abs=1e-3)


@pytest.mark.parametrize("rho", [0.5, 0.9, 0.95])
def test_correlation_time_of_an_autoregression_is_its_theory(rho):
    # The sum of rho^k from lag 0 on; (1 + rho) / (1 - rho) / 2, which takes half of lag 0, is half a sample less.
    times = []
    for seed in range(6):
        error = autoregressive(rho, 30_000, np.random.default_rng(seed))
        error[0] = 3.0 * np.random.default_rng(seed + 50).normal(size=30_000)  # the longer of both counts
        times.append(correlation_time(error + np.array([[5.0], [-2.0]]), 0.01) / 0.01)
    assert np.mean(times) == pytest.approx(1.0 / (1.0 - rho), rel=0.1)
    assert np.mean(times) == pytest.approx(0.5 * (1.0 + rho) / (1.0 - rho) + 0.5, rel=0.1)


def test_correlation_time_of_white_noise_is_a_sample_and_of_nothing_too():
    white = np.random.default_rng(4).normal(size=(2, 50_000))
    assert correlation_time(white, 0.02) == pytest.approx(0.02, rel=0.05)
    assert correlation_time(np.zeros((2, 100)), 0.02) == 0.02
    assert correlation_time(np.full((2, 100), 3.0), 0.02) == pytest.approx(0.02)


@given(st.integers(2, 400), st.floats(0.0, 0.999), st.integers(0, 99))
def test_blocks_are_at_least_a_sample_and_twenty_fit(n, rho, seed):
    length = block_length(autoregressive(rho, n, np.random.default_rng(seed)), H)
    assert isinstance(length, int)
    assert 1 <= length <= max(n // 20, 1)


def test_blocks_span_five_correlation_times():
    error = autoregressive(0.9, 20_000, np.random.default_rng(6))
    length = block_length(error, H)
    assert length == pytest.approx(5 * correlation_time(error, H) / H, abs=0.5)
    assert block_length(error, 10 * H) == length  # in samples, whatever their period


@given(st.data())
def test_redrawn_samples_are_whole_stretches_of_the_log(data):
    n = data.draw(st.integers(1, 300))
    length = data.draw(st.integers(1, n))
    rows = redraw(n, length, np.random.default_rng(data.draw(st.integers(0, 2**32 - 1))))
    assert rows.shape == (n,)
    assert rows.min() >= 0
    assert rows.max() < n
    inside = np.arange(1, n) % length != 0
    assert (np.diff(rows)[inside] == 1).all()


def test_stretches_begin_anywhere():
    rng = np.random.default_rng(7)
    starts = {int(redraw(10, 4, rng)[0]) for _ in range(300)}
    assert starts == set(range(7))


def test_the_same_seed_gives_the_same_numbers_and_another_one_others():
    r = exciting(400)
    r = replace(r, tau=r.tau + 0.1 * np.random.default_rng(8).normal(size=r.tau.shape))
    first, again, other = (ordinary_spread(r, seed) for seed in (5, 5, 6))
    for name in ("standard_error", "low", "high"):
        assert (getattr(first, name) == getattr(again, name)).all()
        assert (getattr(first, name) != getattr(other, name)).all()


def test_regressor_and_torque_are_redrawn_together():
    # A log that Eq. 1 fits exactly has no error however it is redrawn.
    spread = ordinary_spread(exciting(400), 5)
    assert spread.standard_error == pytest.approx(np.zeros(9), abs=1e-9)


def test_other_filters_add_the_mean_square_of_what_they_change():
    rng = np.random.default_rng(10)
    r, *others = (exact(motion(T[:400]), noise=0.1 * rng.normal(size=(2, 400))) for _ in range(4))
    alone, together = ordinary_spread(r, 1), ordinary_spread(r, 1, as_good=others)
    beta = ordinary.estimate(r).beta
    moved = [np.linalg.lstsq(rows_of(o), o.tau.reshape(-1), rcond=None)[0] - beta for o in others]
    added = together.standard_error**2 - alone.standard_error**2
    assert added == pytest.approx(np.mean(np.square(moved), axis=0), rel=1e-6)
    assert (together.high - together.low > alone.high - alone.low).all()


def test_a_method_that_is_biased_on_purpose_adds_its_bias():
    r = exact(motion(T[:400]), noise=0.1 * np.random.default_rng(11).normal(size=(2, 400)))
    bias = np.linspace(-0.4, 0.4, 9)
    biased = replace(
        ordinary.METHOD, estimate=lambda x: Estimate(ordinary.estimate(x).beta + bias), unbiased=ordinary.METHOD
    )
    without = ordinary_spread(r, 1, method=replace(biased, unbiased=None))
    with_bias = ordinary_spread(r, 1, method=biased)
    assert with_bias.standard_error**2 - without.standard_error**2 == pytest.approx(bias**2, rel=1e-6, abs=1e-9)


def test_what_a_method_chose_is_kept_in_every_replicate():
    r, seen = exciting(400), []

    def refit(regression, choice):
        seen.append(choice)
        return ordinary.estimate(regression).beta

    chooser = replace(ordinary.METHOD, estimate=lambda _: Estimate(BETA, choice=0.7), refit=refit)
    told = []
    bootstrap(
        chooser, r, chooser.estimate(r), (r, r), np.random.default_rng(0), 15, lambda k, total: told.append((k, total))
    )
    assert seen == [0.7] * 17
    assert told == [(k, 15) for k in range(1, 16)]


# Residuals


def test_whiteness_of_a_residual_made_by_hand():
    # Centred -1.5, -0.5, 0.5, 1.5: 0.75 - 0.25 + 0.75 over 5 at a lag of one; at two -0.75 - 0.75.
    tau = np.array([[1.0, 2.0, 3.0, 4.0], [1.0, -1.0, 1.0, -1.0]])
    zero = np.zeros((2, 4, 9))
    assert lag_one(regression_of(zero, tau, H, 1 / H), BETA) == pytest.approx((0.25, -0.75))
    assert lag_one(regression_of(zero, tau, H, 0.5 / H), BETA) == pytest.approx((-0.3, 0.5))
    # A lag beyond the log, a residual that is constant, and one that is zero.
    assert lag_one(regression_of(zero, tau, H, 0.1 / H), BETA) == (0.0, 0.0)
    assert lag_one(regression_of(zero, np.array([[2.0] * 4, [0.0] * 4]), H, 1 / H), BETA) == (0.0, 0.0)


def test_white_residuals_are_near_zero_and_drifting_ones_near_one():
    rng = np.random.default_rng(12)
    clean = exciting(20_000)
    noise = np.stack([rng.normal(size=20_000), np.sin(0.05 * H * np.arange(20_000))])
    white, drift = lag_one(replace(clean, tau=clean.tau + noise), BETA)
    assert white == pytest.approx(0.0, abs=0.03)
    assert drift == pytest.approx(1.0, abs=0.01)


def test_the_lag_is_a_period_of_the_cutoff():
    n = 5000
    t = H * np.arange(n)
    at_cutoff, at_half = np.sin(2 * np.pi * CUTOFF * t), np.sin(np.pi * CUTOFF * t)
    found = lag_one(regression_of(np.zeros((2, n, 9)), np.stack([at_cutoff, at_half])), BETA)
    assert found == pytest.approx((1.0, -1.0), abs=0.01)


# Words


def within(share, estimate=2.0, excited=True, held=False):
    """Verdict on an estimate whose interval reaches this share of it to either side."""
    reach = share * abs(estimate)
    return verdict(estimate, estimate - reach, estimate + reach, excited, held)


@pytest.mark.parametrize("estimate", [2.0, -2.0, 1e-6])
@pytest.mark.parametrize(
    ("share", "words"),
    [
        (0.0, "known to 0.1 %"),
        (0.0004, "known to 0.1 %"),
        (0.004, "known to 0.4 %"),
        (0.00401, "known to 0.5 %"),
        (0.0099, "known to 1 %"),
        (0.00991, "known to 1 %"),
        (0.01, "known to 1 %"),
        (0.0101, "known to 2 %"),
        (0.03, "known to 3 %"),
        (0.0301, "known to 4 %"),
        (0.12, "known to 12 %"),
        (0.49, "known to 49 %"),
        (0.4999, "known to 50 %"),
        (0.51, "sign known, size only roughly"),
        (0.99, "sign known, size only roughly"),
        (1.01, "not told from zero"),
        (30.0, "not told from zero"),
    ],
)
def test_words_at_their_limits(share, words, estimate):
    assert within(share, estimate) == words


def test_words_without_a_number():
    assert verdict(2.0, -0.1, 4.1, excited=False, held=False) == NOT_EXCITED == "not excited by this motion"
    assert verdict(2.0, None, None, excited=False, held=False) == NOT_EXCITED
    assert verdict(0.0, None, None, excited=True, held=True) == "held at zero: the log alone would make it negative"
    assert verdict(2.0, None, None, excited=True, held=False) == "no interval claimed by this method"
    assert verdict(2.0, -0.1, 4.1, excited=True, held=False) == "not told from zero"
    assert verdict(-2.0, -4.0, 0.0, excited=True, held=False) == "not told from zero"
    assert verdict(0.0, -0.1, 0.1, excited=True, held=False) == "not told from zero"
    assert verdict(0.1, 0.05, 4.0, excited=True, held=False) == "sign known, size only roughly"


@pytest.mark.parametrize(("share", "words"), [(0.03, "known to 3 %"), (0.7, "sign known, size only roughly")])
def test_a_parameter_that_is_told_from_zero_is_known_however_little_torque_it_moves(share, words):
    assert within(share, 1e-7, excited=False) == within(share, 1e-7, excited=True) == words


def test_of_a_combination_no_parameter_is_known():
    for low, high, held in ((1.99, 2.01, False), (None, None, False), (None, None, True), (-1.0, 5.0, False)):
        assert verdict(2.0, low, high, excited=True, held=held, determined=False) == COMBINED
        assert verdict(2.0, low, high, excited=False, held=held, determined=False) == NOT_EXCITED
    assert "combination" in COMBINED
    assert "base parameters" in COMBINED


@given(st.floats(0.0, 0.4999), st.floats(1e-9, 1e9))
def test_percents_are_never_optimistic_and_at_most_a_digit_too_large(share, estimate):
    told = float(re.fullmatch(r"known to ([0-9.]+) %", within(share, estimate))[1])
    actual = 50.0 * ((estimate + share * estimate) - (estimate - share * estimate)) / estimate
    assert told >= actual - 1e-7
    assert told <= max(actual + (1.0 if told > 1.0 else 0.1), 0.1) + 1e-7
