"""Regressions of several logs as one."""

import numpy as np
import pytest
from hypothesis import given
from regression_example import problem
from strategies import seeds

from repro.identification.methods.every import METHODS
from repro.identification.regression import joined
from repro.identification.solve import solve


def parts(seed, sizes=(30, 50, 40)):
    rng = np.random.default_rng(seed)
    return [problem(rng.normal(size=(2, n, 9)), rng.normal(size=(2, n))) for n in sizes]


@given(seeds)
def test_least_squares_of_all_is_that_of_all_rows(seed):
    found = joined(parts(seed), (1.0, 2.0, 0.5))
    rows = [(w * p.y.reshape(-1, 9), w * p.tau.reshape(-1)) for w, p in zip((1.0, 2.0, 0.5), parts(seed), strict=True)]
    expected = np.linalg.lstsq(np.concatenate([y for y, _ in rows]), np.concatenate([tau for _, tau in rows]))[0]
    np.testing.assert_allclose(solve(found.y, found.tau), expected, rtol=1e-6, atol=1e-9)


def test_times_go_on_and_every_signal_has_all_samples():
    found = joined(parts(0))
    assert found.t.size == 120
    assert (np.diff(found.t) > 0).all()
    for name, axis in (("y", 1), ("tau", 1), ("q", 1), ("dq", 1), ("ddq", 1), ("moving", 1), ("interleaved", 2)):
        assert getattr(found, name).shape[axis] == 120


def test_one_log_is_itself():
    (one,) = parts(1, (25,))
    assert joined([one]) is one


@pytest.mark.parametrize("name", sorted(METHODS))
def test_a_log_given_as_two_halves_gives_what_it_gave(name):
    rng = np.random.default_rng(2)
    beta = np.array([0.12, 0.07, 0.03, 3.2, 1.1, 0.07, 0.05, 0.2, 0.15])
    y = rng.normal(size=(2, 200, 9))
    whole = problem(y, y @ beta + 0.01 * rng.normal(size=(2, 200)))
    both = joined([whole.take(np.arange(100)), whole.take(np.arange(100, 200))])
    np.testing.assert_allclose(METHODS[name].estimate(both).beta, METHODS[name].estimate(whole).beta, rtol=1e-6)
